"""Friction against chamber pressure, for campaigns with one speed and several pressures."""

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import CurvePoint, Results
from hbench.report import style
from hbench.report.draw_friction import MIN_POINTS
from hbench.units import from_si


@dataclass(frozen=True)
class Band:
    """What both directions say at one pressure. A side that was not measured is ``None``."""

    kind: str
    label: str
    p_tp_pa: float  # mean of the sides
    extend: CurvePoint | None
    retract: CurvePoint | None

    @property
    def half_n(self) -> float | None:
        """Half of the friction band, (F_extend - F_retract) / 2: free of an offset in force."""
        if self.extend is None or self.retract is None:
            return None
        return (self.extend.friction_n - self.retract.friction_n) / 2

    @property
    def half_ci95_n(self) -> float | None:
        """Half-width of its interval: those of the two directions, added as squares, halved."""
        sides = [side and side.ci95_n for side in (self.extend, self.retract)]
        return None if None in sides else math.hypot(*sides) / 2

    @property
    def middle_n(self) -> float | None:
        """Middle of the band, (F_extend + F_retract) / 2: asymmetry, or an error of a sensor."""
        if self.extend is None or self.retract is None:
            return None
        return (self.extend.friction_n + self.retract.friction_n) / 2


def bands(results: Results) -> tuple[Band, ...]:
    """Pair the directions of curves with few speeds: labels as they come, pressures rising."""
    pairs: dict[tuple, dict[str, CurvePoint]] = {}
    for curve in results.curves:
        if len(curve.points) < MIN_POINTS:
            for order, point in enumerate(curve.points):
                load = (curve.f_load_n, curve.p_lr_ref_pa)
                key = (curve.kind, curve.label, load, order)
                pairs.setdefault(key, {})[curve.direction] = point
    found = [
        Band(
            kind=kind,
            label=label,
            p_tp_pa=float(np.mean([point.p_tp_pa for point in sides.values()])),
            extend=sides.get("extend"),
            retract=sides.get("retract"),
        )
        for (kind, label, _, _), sides in pairs.items()
    ]
    series = list(dict.fromkeys((band.kind, band.label) for band in found))
    found.sort(key=lambda band: (series.index((band.kind, band.label)), band.p_tp_pa))
    return tuple(found)


def has_pressures(results: Results) -> bool:
    """Tell whether some label was measured at two pressures or more, without curves over speed."""
    found = [(band.kind, band.label) for band in bands(results)]
    return any(found.count(series) >= 2 for series in found)


def friction_pressure(results: Results) -> dict[str, Figure]:
    """Draw friction of each direction, and half of the band between them, over pressure [bar]."""
    figure = style.new_figure(height_in=5.6)
    axes, below = figure.subplots(2, sharex=True, height_ratios=(3, 2))
    series: dict[tuple[str, str], list[Band]] = {}
    for band in bands(results):
        series.setdefault((band.kind, band.label), []).append(band)
    for direction, sign in (("extend", 1), ("retract", -1)):  # a column of the legend each
        for rank, ((_, label), members) in enumerate(series.items()):
            sides = [(band.p_tp_pa, getattr(band, direction)) for band in members]
            rows = [(p, sign * side.friction_n, side.ci95_n) for p, side in sides if side]
            name = ", ".join(filter(None, (label, style.TITLES[direction].lower())))
            look = style.series_style(rank, hollow=direction == "retract")
            _points(axes, rows, look, style.safe(name))
    for rank, members in enumerate(series.values()):
        rows = [(b.p_tp_pa, b.half_n, b.half_ci95_n) for b in members if b.half_n is not None]
        _points(below, rows, style.series_style(rank), None)
    axes.set_ylabel("Friction |F| (N)")
    below.set(xlabel="Chamber pressure (bar)", ylabel="Half band (N)")
    style.start_at_zero(below)
    for one in (axes, below):
        one.set_ylim(bottom=min(0, one.get_ylim()[0]))
    style.head(axes, "Friction against pressure", results)
    style.legend_above(figure, axes, columns=2)
    return {"": figure}


def _points(
    axes: Axes,
    rows: list[tuple[float, float, float | None]],
    look: dict[str, object],
    label: str | None,
) -> None:
    if rows:
        table = np.array([[np.nan if cell is None else cell for cell in row] for row in rows])
        pressure, friction, interval = table.T
        pressure = from_si(pressure, "bar")
        axes.plot(pressure, friction, color=look["color"], linewidth=0.8, linestyle=":", zorder=2)
        axes.errorbar(pressure, friction, interval, label=label, **look, **style.POINTS)
