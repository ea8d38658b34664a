"""The rejected runs by reason."""

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from hbench.records import Results
from hbench.report.campaign.reasons import reason_counts
from hbench.report.render import style


def has_rejected(results: Results) -> bool:
    """Return whether a run was rejected."""
    return not all(run.accepted for run in results.runs)


def has_several_rejected(results: Results) -> bool:
    """Return whether more than one run was rejected, so that there is something to count."""
    return sum(not run.accepted for run in results.runs) > 1


def rejected(results: Results) -> dict[str, Figure]:
    """Draw how many runs each reason rejected."""
    counts = reason_counts(results).most_common()[::-1]
    figure = style.new_figure(height_in=1.1 + 0.3 * len(counts))
    axes = figure.add_subplot()
    names = [style.safe(code.replace("_", " "), most=30) for code, _ in counts]
    bars = axes.barh(
        range(len(counts)),
        [n for _, n in counts],
        color=style.COLOURS[0],
        height=0.6,
        label="_runs",
    )
    axes.bar_label(bars, padding=4)
    axes.set_yticks(range(len(counts)), names)
    axes.tick_params(axis="y", length=0)
    axes.grid(visible=False)
    axes.set_xlabel("Runs rejected (count)")
    axes.xaxis.set_major_locator(MaxNLocator("auto", steps=[1, 2, 5, 10], integer=True))
    axes.margins(x=0.1)
    axes.set_ylim(-0.7, len(counts) - 0.3)
    style.head(axes, "Rejected runs, by reason", results)
    return {"": figure}
