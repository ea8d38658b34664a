"""Figures of ramps and steps beside steady runs, and of their tested differences."""

from collections import defaultdict
from dataclasses import replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import KINDS, Comparison, Curve, Fit, Results
from hbench.records.numbers import SIGNIFICANCE
from hbench.records.rod_pressure import series_key, without_common_rod_pressure
from hbench.report.campaign.figures.friction import (
    is_drawn,
    line_look,
    of_trials,
    undetermined_words,
)
from hbench.report.campaign.motion_rows import comparison_words, differs
from hbench.report.campaign.series_words import TITLES, load_words, within_title
from hbench.report.render import style
from hbench.report.render.numbers import short
from hbench.report.render.series import behind

_READ = "Points: means of the trials; bars: their 95 % intervals; lines: Tustin's law."
_ORDER = ("steady_curve", "ramp_curve", "step_levels")  # of the analyses that give curves


def has_ramps(results: Results) -> bool:
    """Return whether there are ramps or steps to draw."""
    return any(not KINDS[curve.kind].has_constant_speed for curve in results.curves)


def ramps(results: Results) -> dict[str, Figure]:
    """Draw friction [N] against the motion over |v| [mm/s] of steady runs, ramps and steps.

    One figure a load. The lower panel omits the ramps' points before breakaway, so that differences
    are visible.
    """
    groups: dict[tuple, list[Curve]] = defaultdict(list)
    for curve in without_common_rod_pressure(
        curve for curve in results.curves if _analysis(curve) in _ORDER
    ):
        groups[series_key(curve)].append(curve)
    accelerations = sorted({c.a_ref_m_s2 or 0.0 for c in results.curves if KINDS[c.kind].is_ramp})
    figures = {}
    for (label, direction, load, p_lr), curves in groups.items():
        analyses = {_analysis(curve) for curve in curves}
        if "ramp_curve" in analyses or analyses == {"steady_curve", "step_levels"}:
            figure = style.new_figure(height_in=6.4)
            axes, below = figure.subplots(2, sharex=True, height_ratios=(2, 3))
            for curve in sorted(curves, key=_drawing_order):
                _points(axes, curve, accelerations)
                _points(below, _from_breakaway(curve), accelerations)
            for panel_axes in (axes, below):
                panel_axes.set_ylabel("Friction (N)")
            below.set_xlabel("Speed |v| (mm/s)")
            style.start_at_zero(axes)
            names = (label, TITLES[direction], load_words(load, p_lr))
            title = ", ".join(filter(None, names))
            style.head(axes, f"Ramps, {within_title(title)}", results)
            fits = [fit for curve in curves for fit in _lines(curve)]
            style.read_as(figure, "\n".join((_READ, *undetermined_words(fits))))
            style.legend_above(figure, axes, columns=3)
            figures["-".join(filter(None, names))] = figure
    for panel in (0, 1):
        style.share_limits(figure.axes[panel] for figure in figures.values())
    return figures


def _analysis(curve: Curve) -> str:
    return KINDS[curve.kind].analysis


def _lines(curve: Curve) -> list[Fit]:
    """Return the fits of a ramp that are shown as lines."""
    is_ramp = _analysis(curve) == "ramp_curve"
    return [fit for fit in curve.fits if is_ramp and fit.law == "tustin"]


def _drawing_order(curve: Curve) -> tuple[int, float]:
    return _ORDER.index(_analysis(curve)), curve.a_ref_m_s2 or 0.0


def has_comparisons(results: Results) -> bool:
    """Return whether a difference was tested."""
    return any(comparison.ci95_n is not None for comparison in results.motions.comparisons)


def comparisons(results: Results) -> dict[str, Figure]:
    """Draw the tested differences of friction [N] with their intervals, a figure a question."""
    figures = {}
    for what, title, less in (
        ("acceleration", "Accelerations", "fastest less slowest"),
        ("steady", "Ramp less steady", "ramp less steady"),
    ):
        tested = [
            comparison
            for comparison in results.motions.comparisons
            if comparison.what == what and comparison.ci95_n is not None
        ]
        if tested:
            figures[what] = _differences(results, tested, title, less)
    return figures


def _from_breakaway(curve: Curve) -> Curve:
    """Leave out the points at speeds below those of the curve's fits."""
    lines = [abs(v) for fit in curve.fits for v, _ in fit.line]
    first = min(lines, default=0.0) - 1e-9
    return replace(curve, points=tuple(p for p in curve.points if abs(p.v_m_s) >= first))


def _points(axes: Axes, curve: Curve, accelerations: list[float]) -> None:
    v, friction, interval = style.columns(curve)
    label = KINDS[curve.kind].display_name
    if _analysis(curve) == "steady_curve":
        look = {"color": "#000000", "marker": "o", "markerfacecolor": "white", "zorder": 4}
    elif _analysis(curve) == "step_levels":
        look = {"color": style.QUIET, "marker": "D", "zorder": 4}
    else:
        label += f" {short(curve.a_ref_m_s2)} m/s²" if curve.a_ref_m_s2 else ""
        look = style.series_style(accelerations.index(curve.a_ref_m_s2 or 0.0))
        for fit in filter(is_drawn, _lines(curve)):
            speed, force = np.abs(np.array(fit.line, dtype=float)).T
            line = line_look(fit, str(look["color"])) | {"linewidth": 1}
            axes.plot(1e3 * speed, force, label=f"_tustin, {label}", **line)
    friction = friction if curve.direction == "extend" else -friction
    bars = axes.errorbar(
        1e3 * np.abs(v), friction, interval, label=label, **{**style.SMALL_POINTS, **look}
    )
    behind(bars, of_trials(curve.points))


def _differences(results: Results, comparisons: list[Comparison], title: str, less: str) -> Figure:
    figure = style.new_figure(height_in=1.6 + 0.27 * len(comparisons))
    axes = figure.add_subplot()
    names = []
    for row, comparison in enumerate(comparisons):
        colour = style.COLOURS[1] if differs(comparison) else style.COLOURS[0]
        face = colour if differs(comparison) else "white"
        a = f", {short(comparison.a_m_s2[0])} m/s²" if comparison.what == "steady" else ""
        names.append(style.safe(comparison_words(comparison) + a, most=60))
        axes.errorbar(
            comparison.effect_n,
            row,
            label="_differs" if differs(comparison) else "_not significant",
            xerr=comparison.ci95_n,
            color=colour,
            marker="o",
            markerfacecolor=face,
            **style.POINTS,
        )
    axes.axvline(0, color="#374151", linewidth=0.9)
    axes.set_yticks(range(len(comparisons)), names, fontsize=8)
    axes.set_ylim(len(comparisons) - 0.5, -0.5)
    axes.set_xlabel(f"|F|, {less} (N)")
    for face, meaning in (("C", f"p < {SIGNIFICANCE:g} after Holm"), ("w", "not significant")):
        colour = style.COLOURS[1] if face == "C" else style.COLOURS[0]
        axes.plot([], [], "o", color=colour, mfc=colour if face == "C" else "white", label=meaning)
    style.head(axes, title, results)
    style.read_as(figure, "Bars: 95 % intervals over the trials.")
    style.legend_above(figure, axes)
    return figure
