"""Stribeck curves: friction over velocity, measured points with intervals and fitted lines."""

from collections.abc import Iterable
from typing import TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import Curve, Direction, EfficiencyCurve, Fit, Results
from hbench.report import style
from hbench.report.text import force

AnyCurve = TypeVar("AnyCurve", Curve, EfficiencyCurve)

MIN_POINTS = 3  # fewer speeds are no curve over velocity
_ASIDE = 0.006  # residuals of one speed stand side by side, this part of the highest speed apart


def over_velocity(results: Results) -> tuple[Curve, ...]:
    """Return the curves that have enough speeds to be drawn over velocity."""
    return tuple(curve for curve in results.curves if len(curve.points) >= MIN_POINTS)


def stribeck(results: Results) -> dict[str, Figure]:
    """Draw |F| [N] over |v| [mm/s], one figure a direction, with measured less fitted below."""
    curves = over_velocity(results)
    ranks = load_ranks(curves)
    figures = {}
    for direction in style.DIRECTIONS:
        chosen = [curve for curve in curves if curve.direction == direction]
        if chosen:
            figures[direction] = _one_direction(results, direction, chosen, ranks)
    for panel in range(min((len(figure.axes) for figure in figures.values()), default=0)):
        style.share_limits(figure.axes[panel] for figure in figures.values())
    return figures


def signed(results: Results) -> dict[str, Figure]:
    """Draw F [N] over v [mm/s] with their signs, both directions in one figure."""
    figure = style.new_figure(height_in=4.8)
    axes = figure.add_subplot()
    curves = over_velocity(results)
    ranks = load_ranks(curves)
    named = set()
    for curve in by_load(curves):
        key = load_key(curve.f_load_n)
        label = force(key) if key is not None and key not in named else None
        named.add(key)
        look = load_style(curve.f_load_n, curve.direction, ranks)
        _fitted(axes, curve.fits, look["color"], sign=1, absolute=False)
        v, friction, interval = _columns(curve)
        axes.errorbar(1e3 * v, friction, interval, label=label, **look, **style.SMALL_POINTS)
    for line in (axes.axhline, axes.axvline):
        line(0, color="#374151", linewidth=0.9, zorder=1)
    axes.set(xlabel="Velocity v (mm/s), positive extends", ylabel="Friction F (N)")
    style.head(axes, "Both directions", results)
    style.legend_above(figure, axes, "Load |$F_L$|")
    return {"": figure}


def has_curves(results: Results) -> bool:
    """Tell whether anything can be drawn over velocity."""
    return bool(over_velocity(results))


def has_both_directions(results: Results) -> bool:
    """Tell whether both directions have curves over velocity."""
    return len({curve.direction for curve in over_velocity(results)}) == 2


def by_load(curves: Iterable[AnyCurve]) -> list[AnyCurve]:
    """Sort by the size of the load, none before all."""
    return sorted(curves, key=lambda curve: -1 if curve.f_load_n is None else abs(curve.f_load_n))


def load_key(f_load_n: float | None) -> float | None:
    """Return what two curves of the same colour share: the size of the load."""
    return None if f_load_n is None else abs(f_load_n)


def load_ranks(curves: Iterable[AnyCurve]) -> dict[float | None, int]:
    """Number the sizes of the loads, smallest first."""
    sizes = dict.fromkeys(load_key(curve.f_load_n) for curve in by_load(curves))
    return {size: rank for rank, size in enumerate(sizes)}


def load_style(
    f_load_n: float | None, direction: Direction, ranks: dict[float | None, int]
) -> dict[str, object]:
    """Return a load's colour and marker; hollow where the load helps the motion."""
    helps = bool(f_load_n) and (f_load_n < 0) == (direction == "extend")
    return style.series_style(ranks[load_key(f_load_n)], hollow=helps)


def _one_direction(
    results: Results, direction: Direction, curves: list[Curve], ranks: dict[float | None, int]
) -> Figure:
    fitted = any(fit.line for curve in curves for fit in curve.fits)
    figure = style.new_figure(height_in=5.4 if fitted else 3.8)
    if fitted:
        axes, below = figure.subplots(2, sharex=True, height_ratios=(5, 2))
    else:
        axes, below = figure.add_subplot(), None
    sign = 1 if direction == "extend" else -1
    for rank, curve in enumerate(by_load(curves)):
        look = load_style(curve.f_load_n, direction, ranks)
        v, friction, interval = _columns(curve)
        speed = 1e3 * np.abs(v)
        _fitted(axes, curve.fits, look["color"], sign, absolute=True)
        label = None if curve.f_load_n is None else force(curve.f_load_n)
        axes.errorbar(speed, sign * friction, interval, label=label, **look, **style.POINTS)
        if below is not None and curve.fits and curve.fits[0].line:
            residual = sign * (friction - _at(curve.fits[0], v))
            aside = (rank - (len(curves) - 1) / 2) * _ASIDE * speed.max()
            below.errorbar(speed + aside, residual, interval, **look, **style.SMALL_POINTS)
    axes.set_ylabel("Friction |F| (N)")
    style.start_at_zero(axes)
    if below is not None:
        below.axhline(0, color="#374151", linewidth=0.9)
        below.set_ylabel("Measured\n− fitted (N)")
        reach = max(abs(limit) for limit in below.get_ylim())
        below.set_ylim(-reach, reach)
    figure.axes[-1].set_xlabel("Speed |v| (mm/s)")
    style.head(axes, style.TITLES[direction], results)
    style.legend_above(figure, axes, "Load $F_L$")
    return figure


def _columns(curve: Curve) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    points = curve.points
    interval = [np.nan if point.ci95_n is None else point.ci95_n for point in points]
    return (
        np.array([point.v_m_s for point in points], dtype=float),
        np.array([point.friction_n for point in points], dtype=float),
        np.array(interval, dtype=float),
    )


def _fitted(axes: Axes, fits: tuple[Fit, ...], colour: str, sign: int, absolute: bool) -> None:
    for fit in fits:
        if fit.line:
            v, friction = np.array(fit.line, dtype=float).T
            speed = np.abs(v) if absolute else v
            dashes = "-" if fit.converged else "--"
            axes.plot(1e3 * speed, sign * friction, color=colour, linestyle=dashes, zorder=2)


def _at(fit: Fit, v_m_s: np.ndarray) -> np.ndarray:
    """Return the fitted friction at the points; the line holds their speeds."""
    v, friction = np.array(fit.line, dtype=float).T
    order = np.argsort(v)
    return np.interp(v_m_s, v[order], friction[order])
