"""Friction against chamber pressure, for campaigns with one speed and several pressures."""

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import KINDS, Curve, CurvePoint, Results
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.figures.friction import of_trials
from hbench.report.campaign.series_words import load_words
from hbench.report.render import style
from hbench.report.render.series import behind
from hbench.units import from_si

SeriesKey = tuple[str, str, float | None]  # kind, label, and P_Lr [Pa] where series differ in it
# Pressure [Pa], force [N], half-width of its interval [N].
PressurePoint = tuple[float, float, float | None]


def has_pressures(results: Results) -> bool:
    """Return whether a label was measured at two pressures or more, without curves over speed."""
    keys = [(series, curve.direction) for series, curve in _over_pressure(results)]
    return any(keys.count(key) >= 2 for key in keys)


def friction_pressure(results: Results) -> dict[str, Figure]:
    """Draw friction of each direction, and half of the band between them, over pressure [bar]."""
    figure = style.new_figure(height_in=5.6)
    axes, below = figure.subplots(2, sharex=True, height_ratios=(3, 2))
    curves = list(_over_pressure(results))
    ranks = {key: rank for rank, key in enumerate(dict.fromkeys(key for key, _ in curves))}
    for direction, sign in (("extend", 1), ("retract", -1)):  # a column of the legend each
        for key, rank in ranks.items():
            chosen = [c for series, c in curves if (series, c.direction) == (key, direction)]
            points = [point for curve in chosen for point in curve.points]
            rows = [(p.p_tp_pa or 0.0, sign * p.friction_n, p.ci95_n) for p in points]
            labels = (key[1], load_words(None, key[2]), style.TITLES[direction].lower())
            look = style.series_style(rank, hollow=direction == "retract")
            _points(axes, rows, look, style.safe(", ".join(filter(None, labels))), points)
    differs = any(p_lr is not None for _, _, p_lr in ranks)
    for key, rank in ranks.items():
        series = (key[1], load_words(None, key[2]))
        rows = [
            (band.p_tp_pa or 0.0, band.half_n, band.half_ci95_n)
            for band in results.bands
            if (band.kind, band.label, band.p_lr_ref_pa if differs else None) == key
        ]
        label = style.safe(", ".join(filter(None, series)))
        _points(below, rows, style.series_style(rank), f"_{label or 'half band'}")
    axes.set_ylabel("Friction |F| (N)")
    below.set(xlabel="Chamber pressure (bar)", ylabel="Half band (N)")
    style.start_at_zero(below)
    for panel in (axes, below):
        panel.set_ylim(bottom=min(0, panel.get_ylim()[0]))
    style.head(axes, "Friction against pressure", results)
    style.read_as(figure, "Points: means of the trials; bars: their 95 % Student intervals.")
    style.legend_above(figure, axes, columns=1 if differs else 2)
    return {"": figure}


def _over_pressure(results: Results) -> Iterator[tuple[SeriesKey, Curve]]:
    chosen = (curve for curve in results.curves if KINDS[curve.kind].has_constant_speed)
    for curve in without_common_rod_pressure(curve for curve in chosen if not curve.over_velocity):
        yield (curve.kind, curve.label, curve.p_lr_ref_pa), curve


def _points(
    axes: Axes,
    rows: list[PressurePoint],
    look: dict[str, object],
    label: str,
    means: Sequence[CurvePoint] = (),
) -> None:
    if rows:
        order = sorted(range(len(rows)), key=lambda i: rows[i][0])
        rows = [rows[i] for i in order]
        table = np.array([[np.nan if cell is None else cell for cell in row] for row in rows])
        pressure, friction, interval = table.T
        pressure = from_si(pressure, "bar")
        axes.plot(pressure, friction, color=look["color"], linewidth=0.8, linestyle=":", zorder=2)
        bars = axes.errorbar(pressure, friction, interval, label=label, **look, **style.POINTS)
        if means:
            behind(bars, of_trials([means[i] for i in order]))
