"""Figures of a comparison: both curves, and B less A below, for each direction and load."""

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from hbench.records import CampaignDifferences, Curve, CurveDifference
from hbench.report.campaign.figures.friction import of_trials
from hbench.report.campaign.series_words import kind_words, load_words
from hbench.report.render import style
from hbench.report.render.figures import Drawing, Sketch, draw_sketches
from hbench.report.render.series import behind

_CAPTION = (
    "Above: means of the trials with their 95 % intervals. Below: B less A; the bars are the 95 % "
    "interval of the trials, the wide pale ones add the instruments. Filled: it is real."
)


def draw_differences(differences: CampaignDifferences) -> tuple[Drawing, ...]:
    """Draw each pair of curves that has at least two speeds."""
    sketches = []
    for number, curve in enumerate(differences.curves):
        if len(curve.points) < 2:
            continue
        with rc_context(style.RC):
            figure = draw_pair(curve, differences)
        title = figure.axes[0].get_title("left")
        sketches.append(Sketch(f"pair-{number + 1}", "comparison", title, _CAPTION, figure))
    return draw_sketches(sketches)


def draw_pair(difference: CurveDifference, differences: CampaignDifferences) -> Figure:
    """Draw |F| [N] of both over |v| [mm/s], and the difference below."""
    figure = style.new_figure(height_in=5.0)
    above, below = figure.subplots(2, sharex=True, height_ratios=(5, 3))
    for index, (name, curve) in enumerate((("A", difference.a), ("B", difference.b))):
        label = f"{name}: {style.safe(differences.names[index])}"
        look = style.series_style(index)
        bars = above.errorbar(*_columns(curve), label=label, **look, **style.POINTS)
        behind(bars, of_trials(curve.points))
    v = 1e3 * np.abs([point.v_m_s for point in difference.points])
    differences_n = [point.friction_n for point in difference.points]
    u95 = [np.nan if d.u95 is None else d.u95 for d in differences_n]
    ci95 = [np.nan if d.ci95 is None else d.ci95 for d in differences_n]
    values = np.array([d.value for d in differences_n])
    below.axhline(0, color="#374151", linewidth=0.9)
    below.errorbar(v, values, u95, linestyle="none", color="#000000", elinewidth=5, alpha=0.18)
    below.errorbar(v, values, ci95, linestyle="none", color="#000000", elinewidth=1.1, capsize=2.5)
    real = np.array([d.real for d in differences_n])
    for chosen, face in ((real, "#000000"), (~real, "white")):
        label = "_B − A" if face == "white" else "_B − A, real"
        look = {"color": "#000000", "markerfacecolor": face, "zorder": 4, "label": label}
        (dots,) = below.plot(v[chosen], values[chosen], "o", **look)
        halves = {"± B − A (N)": np.array(ci95)[chosen], "U95 (N)": np.array(u95)[chosen]}
        behind(dots, halves)
    above.set_ylabel("Friction |F| (N)")
    below.set(xlabel="Speed |v| (mm/s)", ylabel="B − A (N)")
    style.start_at_zero(above)
    load = load_words(difference.a.f_load_n, difference.a.p_lr_ref_pa)
    kind = kind_words(difference.a)
    title = ", ".join(filter(None, (style.TITLES[difference.direction], kind, load)))
    above.set_title(f"Friction, {title[0].lower()}{title[1:]}")
    style.read_as(figure, "Bars: 95 % intervals of trials; wide and pale: with instruments.")
    sources = {differences.a.source, differences.b.source}
    if "simulated" in sources:
        mark = "simulated" if len(sources) == 1 else "one is simulated"
        above.set_title(mark, loc="right", color=style.QUIET, fontsize=10, fontweight="normal")
    style.legend_above(figure, above, columns=1)
    return figure


def _columns(curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    sign = 1.0 if curve.direction == "extend" else -1.0
    points = curve.points
    return (
        1e3 * np.abs([point.v_m_s for point in points]),
        sign * np.array([point.friction_n for point in points]),
        np.array([np.nan if point.ci95_n is None else point.ci95_n for point in points]),
    )
