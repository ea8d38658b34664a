"""Stribeck curves: friction over velocity, measured points with intervals and fitted lines."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import (
    DIRECTION_WORDS,
    DIRECTIONS,
    KINDS,
    SIGNS,
    Curve,
    CurvePoint,
    Direction,
    EfficiencyCurve,
    Fit,
    Results,
)
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.fit_tables import determines_none, law_words
from hbench.report.campaign.series_words import load_words
from hbench.report.render import style
from hbench.report.render.numbers import number
from hbench.report.render.series import behind

AnyCurve = TypeVar("AnyCurve", Curve, EfficiencyCurve)
LoadKey = tuple[float | None, float | None]  # |F_L| [N]; P_Lr [Pa] where curves differ in it

_EXTRAPOLATED = {"linestyle": ":", "linewidth": 1.0, "alpha": 0.7, "zorder": 1}
_BARS = "Points: means of the trials; bars: their 95 % Student intervals."
_SINGLE = "Points: one trial each, so no interval."
_SOME_SINGLE = "\nA point without a bar is a single trial."
_UNDETERMINED = "Dashed: a fit that does not determine all its parameters."
_NO_LINE = "No line: too few points for the fit to determine any parameter."
BANDS = "Bands: expanded uncertainty U (95 %)."
_ASIDE = 0.006  # distance of residuals at one speed, relative to the highest speed


def over_velocity(results: Results) -> tuple[Curve, ...]:
    """Return the steady curves of labels of which one has enough speeds for a curve over velocity.

    Others of such a label, as of a direction of which trials were rejected, are drawn beside it.
    """
    steady = [curve for curve in results.curves if KINDS[curve.kind].has_constant_speed]
    labels = {(curve.kind, curve.label) for curve in steady if curve.over_velocity}
    return without_common_rod_pressure(c for c in steady if (c.kind, c.label) in labels)


def friction_magnitude(results: Results, title: str = "Friction") -> dict[str, Figure]:
    """Draw |F| [N] over |v| [mm/s], one figure a direction, with measured less fitted below."""
    curves = over_velocity(results)
    ranks = load_ranks(curves)
    figures: dict[str, Figure] = {}
    for direction, chosen in by_direction(curves):
        figures[direction] = _one_direction(results, title, direction, chosen, ranks)
    for panel in range(min((len(figure.axes) for figure in figures.values()), default=0)):
        style.share_limits(figure.axes[panel] for figure in figures.values())
    return figures


def has_curves(results: Results) -> bool:
    """Return whether a curve over velocity exists."""
    return bool(over_velocity(results))


def of_trials(points: Sequence[CurvePoint]) -> dict[str, list[float | str]]:
    """Return the data behind a curve's points: friction of each trial, runs, and U95."""
    behind_them: dict[str, list[float | str]] = {
        "trials (N)": [", ".join(number(f) for f in point.trials_n) for point in points],
        "runs": [" ".join(point.runs) for point in points],
    }
    if any(point.u95_n is not None for point in points):
        known: list[float | str] = [
            np.nan if point.u95_n is None else point.u95_n for point in points
        ]
        behind_them = {"U95 with instruments (N)": known} | behind_them
    return behind_them


def by_load(curves: Iterable[AnyCurve]) -> list[AnyCurve]:
    """Sort by the size of the load, then by the rod-side pressure; none before all."""
    return sorted(curves, key=lambda c: [-1 if part is None else part for part in load_key(c)])


def load_key(curve: AnyCurve) -> LoadKey:
    """Return the magnitude of the load and the rod-side pressure, which share a colour."""
    return None if curve.f_load_n is None else abs(curve.f_load_n), curve.p_lr_ref_pa


def by_direction(curves: Iterable[AnyCurve]) -> Iterator[tuple[Direction, list[AnyCurve]]]:
    """Yield each direction that has curves, with these."""
    curves = tuple(curves)
    for direction in DIRECTIONS:
        chosen = [curve for curve in curves if curve.direction == direction]
        if chosen:
            yield direction, chosen


def load_ranks(curves: Iterable[AnyCurve]) -> dict[LoadKey, int]:
    """Number the loads, smallest first."""
    loads = dict.fromkeys(load_key(curve) for curve in by_load(curves))
    return {load: rank for rank, load in enumerate(loads)}


def load_style(curve: AnyCurve, ranks: dict[LoadKey, int]) -> dict[str, Any]:
    """Return a load's colour and marker; hollow where the load helps the motion."""
    return style.series_style(ranks[load_key(curve)], hollow=load_helps(curve))


def load_helps(curve: AnyCurve) -> bool:
    """Return whether the load acts in the direction of the motion."""
    load = curve.f_load_n
    return load is not None and load != 0 and (load < 0) == (curve.direction == "extend")


def load_legend(figure: Figure, axes: Axes, curves: Iterable[AnyCurve]) -> None:
    """Put the legend of the loads above the axes, with P_Lr in its title where entries name it."""
    if any(curve.p_lr_ref_pa is not None for curve in curves):
        style.legend_above(figure, axes, "Load $F_L$, rod-side pressure $P_{Lr}$", columns=2)
    else:
        style.legend_above(figure, axes, "Load $F_L$")


def _one_direction(
    results: Results,
    title: str,
    direction: Direction,
    curves: list[Curve],
    ranks: dict[LoadKey, int],
) -> Figure:
    fitted = any(is_drawn(fit) for curve in curves for fit in curve.fits[:1])
    figure = style.new_figure(height_in=5.4 if fitted else 3.8)
    if fitted:
        axes, below = figure.subplots(2, sharex=True, height_ratios=(5, 2))
    else:
        axes, below = figure.add_subplot(), None
    sign = SIGNS[direction]
    for rank, curve in enumerate(by_load(curves)):
        look = load_style(curve, ranks)
        v, friction, interval = style.columns(curve)
        speed = 1e3 * np.abs(v)
        _fitted(axes, curve, look["color"], sign)
        label = load_words(curve.f_load_n, curve.p_lr_ref_pa) or "_friction"
        _expanded(axes, curve, speed, sign * friction, look["color"])
        half = style.bars(interval)
        bars = axes.errorbar(speed, sign * friction, half, label=label, **look, **style.POINTS)
        behind(bars, of_trials(curve.points))
        if below is not None and curve.fits and is_drawn(curve.fits[0]):
            residual = sign * (friction - _at(curve.fits[0], v))
            aside = (rank - (len(curves) - 1) / 2) * _ASIDE * speed.max()
            bars = below.errorbar(
                speed + aside,
                residual,
                half,
                label=f"_{label.removeprefix('_')}",
                **look,
                **style.SMALL_POINTS,
            )
            behind(bars, of_trials(curve.points))
    axes.set_ylabel("Friction |F| (N)")
    style.start_at_zero(axes)
    if below is not None:
        below.axhline(0, color="#374151", linewidth=0.9)
        below.set_ylabel("Measured\n− fitted (N)")
        reach = max(abs(limit) for limit in below.get_ylim())
        below.set_ylim(-reach, reach)
    figure.axes[-1].set_xlabel(_speed_label(curves))
    style.head(axes, f"{title}, {DIRECTION_WORDS[direction]}", results)
    style.read_as(figure, _read(curves))
    load_legend(figure, axes, curves)
    return figure


def _read(curves: Sequence[Curve]) -> str:
    """Return how to read the points, the lines with their law, and the bands."""
    fits = [fit for curve in curves for fit in curve.fits[:1]]
    laws = dict.fromkeys(law_words(fit.law) for fit in fits if is_drawn(fit))
    lines = f"Lines: fitted law ({', '.join(laws)})." if laws else ""
    bands = (
        BANDS if any(is_band([point.u95_n for point in curve.points]) for curve in curves) else ""
    )
    of_fits = " ".join(filter(None, (lines, bands)))
    points = points_words([point.ci95_n for curve in curves for point in curve.points])
    hollow = "Hollow points: the load helps the motion." if any(map(load_helps, curves)) else ""
    return "\n".join(filter(None, (points, of_fits, *undetermined_words(fits), hollow)))


def is_drawn(fit: Fit) -> bool:
    """Return whether a fit is drawn; one through as many points as parameters shows nothing."""
    return bool(fit.line) and not determines_none(fit)


def line_look(fit: Fit, colour: str) -> dict[str, Any]:
    """Return colour and dashes of a fit's line: dashed unless it is determined."""
    return {"color": colour, "linestyle": "-" if fit.verdict == "determined" else "--", "zorder": 2}


def undetermined_words(fits: Sequence[Fit]) -> list[str]:
    """Return how fits are drawn that determine some of their parameters, or none."""
    some = any(is_drawn(fit) and fit.verdict != "determined" for fit in fits)
    return [_UNDETERMINED] * some + [_NO_LINE] * any(map(determines_none, fits))


def points_words(intervals: Sequence[float | None]) -> str:
    """Return what the points are, and their bars, by the intervals of their trials."""
    if all(interval is None for interval in intervals):
        return _SINGLE
    return _BARS + (_SOME_SINGLE if None in intervals else "")


def is_band(u95: Sequence[float | None]) -> bool:
    """Return whether a curve has a band that can be seen: U at two neighbouring speeds."""
    return any(None not in pair for pair in pairwise(u95))


def _expanded(
    axes: Axes, curve: Curve, speed: np.ndarray, friction_n: np.ndarray, colour: str
) -> None:
    """Draw the band of U95. An instrument's error is alike at all speeds, which bars would hide."""
    if is_band([point.u95_n for point in curve.points]):
        half = np.array([np.nan if p.u95_n is None else p.u95_n for p in curve.points], dtype=float)
        low, high = friction_n - half, friction_n + half
        axes.fill_between(speed, low, high, color=colour, alpha=0.13, linewidth=0, zorder=1)


def _fitted(axes: Axes, curve: Curve, colour: str, sign: float) -> None:
    """Draw the first law: a line inside the measured speeds, dots where it is extrapolated.

    A fit that is not determined is dashed, and not extrapolated.
    """
    for fit in filter(is_drawn, curve.fits[:1]):
        who = f"_{fit.law}, {load_words(curve.f_load_n, curve.p_lr_ref_pa)}".removesuffix(", ")
        inside = {**line_look(fit, colour), "label": who}
        outside = {**_EXTRAPOLATED, "color": colour, "label": f"{who}, extrapolated"}
        beyond = fit.beyond if fit.verdict == "determined" else ()
        pieces = [(fit.line, inside), *((piece, outside) for piece in beyond)]
        for line, look in pieces:
            if line:
                v, friction = np.array(line, dtype=float).T
                axes.plot(1e3 * np.abs(v), sign * friction, **look)


def _speed_label(curves: Iterable[Curve]) -> str:
    """Return the words under the speeds, with a warning where lines are extrapolated."""
    fits = [fit for curve in curves for fit in curve.fits[:1]]
    beyond = any(fit.beyond and fit.verdict == "determined" for fit in fits)
    return "Speed |v| (mm/s)" + ("\ndotted: extrapolated beyond the measurement" if beyond else "")


def _at(fit: Fit, v_m_s: np.ndarray) -> np.ndarray:
    """Return the fitted friction at the points; the line holds their speeds."""
    v, friction = np.array(fit.line, dtype=float).T
    order = np.argsort(v)
    return np.interp(v_m_s, v[order], friction[order])
