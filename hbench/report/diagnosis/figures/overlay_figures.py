"""Figures of held-out runs: signals as measured, and as simulated before and after."""

import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from hbench.records import Diagnosis, Overlay
from hbench.report.diagnosis.figures.gap_figures import AFTER, BEFORE, MEASURED
from hbench.report.diagnosis.names import DisplayName, compared_model, mathtext, models_of, signal
from hbench.report.render import style
from hbench.units import parse_unit

_ROW_IN = 1.2
_WINDOW_S = 0.16  # over which gaps are compared
_LABEL_LINE = 12  # letters of a line beside a row


def overlay_figures(diagnosis: Diagnosis) -> dict[str, Figure]:
    """Draw each run's signals, and beside each the errors of the simulations.

    Where nothing was added to the model, a signal that it reproduces within the repeatability is
    left out.
    """
    shown = [overlay for overlay in diagnosis.overlays if _deviates(diagnosis, overlay)]
    return {
        run: _run(diagnosis, run, [overlay for overlay in shown if overlay.run == run])
        for run in dict.fromkeys(overlay.run for overlay in shown)
    }


def _deviates(diagnosis: Diagnosis, overlay: Overlay) -> bool:
    """Return whether a signal's gap in its run exceeds the repeatability, or is not known."""
    if "after" in models_of(diagnosis):
        return True
    gaps = {each.plan.run: each.gap.signals for each in diagnosis.gap_runs}
    gap = gaps.get(overlay.run, {}).get(overlay.signal)
    return gap is None or (gap.before if diagnosis.refit_refused else gap.refitted) > 1


def _run(diagnosis: Diagnosis, run: str, overlays: Sequence[Overlay]) -> Figure:
    figure = style.new_figure(height_in=0.9 + _ROW_IN * len(overlays), wide=True)
    panels = figure.subplots(len(overlays), 2, sharex=True, squeeze=False)
    after = models_of(diagnosis).get("after")
    for (left, right), overlay in zip(panels, overlays, strict=True):
        display = signal(overlay.signal)
        factor, unit = _scale(overlay, display)
        left.plot(
            overlay.t_s, factor * overlay.measured, color=MEASURED, linewidth=3.2, label="measured"
        )
        right.axhline(0, color="#374151", linewidth=0.9)
        sides = [(compared_model(diagnosis), overlay.before, BEFORE, 1.0)]
        sides += [(after, overlay.after, AFTER, 1.3)] if after else []
        for label, values, colour, width in sides:
            left.plot(overlay.t_s, factor * values, color=colour, linewidth=width, label=label)
            off = factor * (values - overlay.measured)
            t_mean, means = _window_means(overlay.t_s, off)
            thin = {"linewidth": 0.7, "alpha": 0.5} if len(means) < len(off) else {}
            right.plot(overlay.t_s, off, color=colour, label=f"_{label}", **thin)
            if thin:
                right.plot(t_mean, means, ".-", color=colour, label=f"_means, {label}")
        title = textwrap.fill(display.title, _LABEL_LINE)
        left.ticklabel_format(axis="y", useOffset=False)
        left.set_ylabel(f"{mathtext(title)}\n({unit})")
        right.set_ylabel(f"error ({unit})")
    for axes in panels[-1]:
        axes.set_xlabel("Time (s)")
    figure.align_ylabels(panels[:, 0])
    figure.align_ylabels(panels[:, 1])
    style.head(panels[0, 0], f"Run {run}", diagnosis)
    panels[0, 1].set_title("Simulated less measured")
    style.legend_above(figure, panels[0, 0], columns=3)
    return figure


def _window_means(t_s: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the means over successive windows of about ``_WINDOW_S``, with their middle times."""
    samples = max(1, round(_WINDOW_S / float(np.median(np.diff(t_s)))))
    whole = len(t_s) // samples * samples
    t_mean, means = (each[:whole].reshape(-1, samples).mean(axis=1) for each in (t_s, values))
    return t_mean, means


def _scale(overlay: Overlay, display: DisplayName) -> tuple[float, str]:
    """Return the factor from the overlay's unit to the one it is shown in, and that unit."""
    if not display.unit:
        return 1.0, overlay.unit
    given, wanted = parse_unit(overlay.unit), parse_unit(display.unit)
    if given.dimension != wanted.dimension:
        return 1.0, overlay.unit
    return given.factor / wanted.factor, display.unit
