"""Figures of a comparison: curves, bands or breakaway of both, and B less A."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import ScaledTranslation

from hbench.records import (
    DIRECTION_WORDS,
    BandDifference,
    CampaignDifferences,
    Curve,
    CurveDifference,
    Difference,
)
from hbench.report.campaign.figures.friction import of_trials
from hbench.report.campaign.series_words import kind_words, load_words
from hbench.report.comparison.breakaways import breakaway_names
from hbench.report.comparison.cells import label_of, with_names
from hbench.report.comparison.tables import hidden_curves, single_points
from hbench.report.render import style
from hbench.report.render.figures import Drawing, Sketch, draw_sketches
from hbench.report.render.series import behind
from hbench.units import from_si

_BESIDE = 0.04  # inches by which A and B are drawn left and right of their speed
_CAPTION = (
    "Above: friction of A and B, means of the trials, side by side. Below: B minus A, on the "
    "same axis in all figures. {marks}"
)
_FILLED = (
    "Filled: significant at this speed alone, with p corrected for the number of points{drift}. "
    "Hollow: not significant."
)
_HOLLOW = (
    "No difference at a single speed of a single curve is significant{drift}, after correction for "
    "{tests} tests."
)
_NOT_DRIFT = ", and not explained by a drift"
_OR_DRIFT = " beyond a possible drift"
_SPEEDS_CAPTION = (
    "B minus A of friction at each speed, in the mean over the curves, with the 95 % interval of "
    "the trials."
)
_BREAKAWAY_CAPTION = (
    "Left: breakaway of A and B, means of the trials. Right: B minus A. Filled: the difference is "
    "significant. Hollow: not significant."
)
_BANDS_CAPTION = (
    "Above: half bands of A and B, (F extending − F retracting) / 2. Lines: least squares over "
    "pressure. Below: B minus A. Filled: the difference is significant. Hollow: not significant."
)


def draw_differences(differences: CampaignDifferences) -> tuple[Drawing, ...]:
    """Draw the half bands of each series, each pair of curves with two speeds, and breakaway."""
    differences = with_names(differences)
    sketches = []
    for number, bands in enumerate(_series(differences), start=1):
        if len(bands) < 2:
            continue
        with rc_context(style.RC):
            figure = draw_bands(bands, differences)
        title = ", ".join(filter(None, (label_of(bands[0]), "Half band over pressure")))
        sketches.append(Sketch(f"bands-{number}", "bands", title, _BANDS_CAPTION, figure))
    mean = differences.mean_of_curves
    if mean is not None and len(mean.speeds) > 1:
        with rc_context(style.RC):
            figure = draw_speeds(differences)
        title = "Difference of friction over speed"
        sketches.append(Sketch("speeds", "speeds", title, _SPEEDS_CAPTION, figure))
    if differences.breakaways:
        with rc_context(style.RC):
            figure = draw_breakaways(differences)
        sketches.append(Sketch("breakaway", "breakaway", "Breakaway", _BREAKAWAY_CAPTION, figure))
    pairs = []
    for number, curve in enumerate(differences.curves):
        if len(curve.points) < 2:
            continue
        with rc_context(style.RC):
            figure = draw_pair(curve, differences)
        title = figure.axes[0].get_title("left")
        caption = _CAPTION.format(marks=_marks(curve, differences))
        pairs.append(Sketch(f"pair-{number + 1}", "comparison", title, caption, figure))
    style.share_limits(pair.figure.axes[1] for pair in pairs)
    return draw_sketches(sketches + pairs)


def _marks(curve: CurveDifference, differences: CampaignDifferences) -> str:
    """Explain the marks of B less A that the figure of a curve has."""
    significant = any(point.friction_n.real for point in curve.points)
    hidden = _is_hidden(curve, differences)
    if significant and not hidden:
        return _FILLED.format(drift=_NOT_DRIFT if hidden_curves(differences) else "")
    tests = len(single_points(differences.curves))
    return _HOLLOW.format(drift=_OR_DRIFT if significant else "", tests=tests)


def _is_hidden(curve: CurveDifference, differences: CampaignDifferences) -> bool:
    """Return whether a drift may account for the difference of a curve."""
    return any(each.a is curve.a for each in hidden_curves(differences))


def _series(differences: CampaignDifferences) -> Iterable[list[BandDifference]]:
    """Return the bands with known pressures, by label and rod-side pressure."""
    series: dict[tuple, list[BandDifference]] = {}
    for band in differences.bands:
        if band.a.p_tp_pa is not None and band.b.p_tp_pa is not None:
            series.setdefault((band.a.label, band.a.p_lr_ref_pa), []).append(band)
    return series.values()


def draw_bands(bands: Sequence[BandDifference], differences: CampaignDifferences) -> Figure:
    """Draw the half bands [N] of both over pressure [bar], and the difference below."""
    figure = style.new_figure(height_in=5.0)
    above, below = figure.subplots(2, sharex=True, height_ratios=(5, 3))
    for index, side in enumerate("ab"):
        own = [getattr(band, side) for band in bands]
        label = f"{side.upper()}: {style.safe(_named(differences, index, own[0].label))}"
        look = style.series_style(index)
        rows = [(_bar(each.p_tp_pa), each.half_n, _or_nan(each.half_ci95_n)) for each in own]
        above.errorbar(*np.array(sorted(rows)).T, label=label, **look, **style.POINTS)
        for trend in (getattr(each, side) for each in differences.band_trends):
            if any(band in trend.bands for band in own):
                forces = [
                    trend.half.intercept_n + trend.half.slope_n_pa * p for p in trend.pressures_pa
                ]
                line = {"color": look["color"], "label": f"_{side.upper()}, line", "zorder": 2}
                above.plot([_bar(p) for p in trend.pressures_pa], forces, **line)
    _draw_differences(
        below,
        np.array([_bar(band.a.p_tp_pa) for band in bands]),
        [band.half_n for band in bands],
        [band.half_n.real for band in bands],
    )
    above.set_ylabel("Half band (N)")
    below.set(xlabel="Chamber pressure (bar)", ylabel="B − A (N)")
    style.start_at_zero(above)
    above.set_ylim(bottom=min(0.0, above.get_ylim()[0]))
    above.set_title("Half band over pressure")
    style.read_as(figure, "Bars: 95 % intervals of trials; wide and pale: with instruments.")
    _mark(above, differences)
    style.legend_above(figure, above, columns=1)
    return figure


def _named(differences: CampaignDifferences, index: int, label: str) -> str:
    return ", ".join(filter(None, (differences.names[index], label)))


def _bar(pressure_pa: float | None) -> float:
    return np.nan if pressure_pa is None else from_si(pressure_pa, "bar")


def _or_nan(value: float | None) -> float:
    return np.nan if value is None else value


def draw_speeds(differences: CampaignDifferences) -> Figure:
    """Draw B less A [N] over |v| [mm/s], in the mean over the curves."""
    figure = style.new_figure(height_in=3.2)
    axes = figure.add_subplot()
    mean = differences.mean_of_curves
    rows = [(1e3 * e.v_m_s, e.value_n, _or_nan(e.ci95_n)) for e in (mean.speeds if mean else ())]
    axes.axhline(0, color="#374151", linewidth=0.9)
    look = style.series_style(0)
    axes.errorbar(*np.array(sorted(rows)).T, label="_B − A", **look, **style.POINTS)
    axes.set(xlabel="Speed |v| (mm/s)", ylabel="B − A (N)")
    style.start_at_zero(axes)
    axes.set_title("B − A, mean over the curves")
    _mark(axes, differences)
    return figure


def draw_pair(difference: CurveDifference, differences: CampaignDifferences) -> Figure:
    """Draw |F| [N] of both over |v| [mm/s], and the difference below."""
    figure = style.new_figure(height_in=5.0)
    above, below = figure.subplots(2, sharex=True, height_ratios=(5, 3))
    inches = figure.dpi_scale_trans
    for index, (name, curve) in enumerate((("A", difference.a), ("B", difference.b))):
        label = f"{name}: {style.safe(differences.names[index])}"
        look = style.series_style(index)
        place = above.transData + ScaledTranslation(_BESIDE * (2 * index - 1), 0, inches)
        bars = above.errorbar(*_columns(curve), label=label, **look, **style.POINTS)
        for artist in bars.get_children():
            artist.set_transform(place)
        behind(bars, of_trials(curve.points))
    v = 1e3 * np.abs([point.v_m_s for point in difference.points])
    hidden = _is_hidden(difference, differences)
    points = [point.friction_n for point in difference.points]
    _draw_differences(below, v, points, [point.real and not hidden for point in points])
    above.set_ylabel("Friction |F| (N)")
    below.set(xlabel="Speed |v| (mm/s)", ylabel="B − A (N)")
    style.start_at_zero(above)
    load = load_words(difference.a.f_load_n, difference.a.p_lr_ref_pa)
    kind = kind_words(difference.a)
    words = "Friction", DIRECTION_WORDS[difference.direction], kind, load
    above.set_title(", ".join(filter(None, words)))
    style.read_as(figure, "Bars: 95 % intervals of trials; wide and pale: with instruments.")
    _mark(above, differences)
    style.legend_above(figure, above, columns=1)
    return figure


def draw_breakaways(differences: CampaignDifferences) -> Figure:
    """Draw breakaway [N] of both in a row for each case, and the differences beside it."""
    rows = differences.breakaways
    figure = style.new_figure(height_in=1.9 + 0.32 * len(rows))
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(5, 4))
    at = np.arange(len(rows), dtype=float)
    for index, side in enumerate("ab"):
        own = [getattr(row, side) for row in rows]
        label = f"{side.upper()}: {style.safe(differences.names[index])}"
        place = left.transData + ScaledTranslation(
            0, _BESIDE * (1 - 2 * index), figure.dpi_scale_trans
        )
        values = [each.breakaway_n for each in own]
        bars = left.errorbar(
            *(values, at, None, [_or_nan(each.ci95_n) for each in own]),
            **{"label": label, **style.series_style(index), **style.POINTS},
        )
        for artist in bars.get_children():
            artist.set_transform(place)
        behind(bars, {"U95 (N)": [_or_nan(each.u95_n) for each in own]})
    tested = [row.breakaway_n for row in rows]
    _draw_differences(right, at, tested, [each.real for each in tested], across=True)
    left.set_yticks(at, breakaway_names(rows), fontsize=9.5)
    left.set_ylim(len(rows) - 0.5, -0.5)
    left.set_xlabel("Breakaway (N)")
    right.set_xlabel("B − A (N)")
    for axes in (left, right):
        axes.grid(visible=False, axis="y")
        axes.margins(x=0.1)
        axes.locator_params(axis="x", nbins=4)  # room for numbers of four digits
    right.tick_params(axis="y", length=0)
    left.set_title("Breakaway")
    style.read_as(figure, "Bars: 95 % intervals of trials; wide and pale: with instruments.")
    _mark(right, differences)
    style.legend_above(figure, left, columns=1)
    return figure


def _draw_differences(
    axes: Axes,
    at: np.ndarray,
    differences: Sequence[Difference],
    significant: Sequence[bool],
    across: bool = False,
) -> None:
    """Draw B less A over ``at``, or ``across`` in rows at ``at``; the significant ones filled."""
    u95, ci95 = (
        np.array([_or_nan(getattr(each, name)) for each in differences]) for name in ("u95", "ci95")
    )
    values = np.array([each.value for each in differences])
    x, y, bar = (values, at, "xerr") if across else (at, values, "yerr")
    (axes.axvline if across else axes.axhline)(0, color="#374151", linewidth=0.9)
    bars: dict[str, Any] = {"linestyle": "none", "color": "#000000"}
    axes.errorbar(x, y, **{bar: u95}, elinewidth=5, alpha=0.3, **bars)
    axes.errorbar(x, y, **{bar: ci95}, elinewidth=1.1, capsize=2.5, **bars)
    real = np.array(significant)
    for chosen, face in ((real, "#000000"), (~real, "white")):
        label = "_B − A" if face == "white" else "_B − A, real"
        look = {"color": "#000000", "markerfacecolor": face, "zorder": 4, "label": label}
        (dots,) = axes.plot(x[chosen], y[chosen], "o", **look)
        behind(dots, {"± B − A (N)": ci95[chosen], "U95 (N)": u95[chosen]})


def _mark(axes: Axes, differences: CampaignDifferences) -> None:
    """Mark the figure of simulated campaigns."""
    sources = differences.a.source, differences.b.source
    style.mark_sources(axes, sources, "one is simulated")


def _columns(curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    points = curve.points
    return (
        1e3 * np.abs([point.v_m_s for point in points]),
        curve.against_motion * np.array([point.friction_n for point in points]),
        np.array([np.nan if point.ci95_n is None else point.ci95_n for point in points]),
    )
