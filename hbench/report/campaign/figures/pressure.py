"""Friction against chamber pressure, for campaigns with one speed and several pressures."""

from collections.abc import Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import DIRECTION_WORDS, KINDS, Band, BandTrend, Curve, CurvePoint, Results
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.figures.friction import of_trials
from hbench.report.campaign.series_words import load_words
from hbench.report.render import style
from hbench.report.render.series import behind
from hbench.units import from_si

SeriesKey = tuple[str, str, float | None]  # kind, label, and P_Lr [Pa] where series differ in it
# Pressure [Pa], force [N], half-width of its interval [N].
PressurePoint = tuple[float | None, float, float | None]


def has_pressures(results: Results) -> bool:
    """Return whether a label was measured at two pressures or more, without curves over speed."""
    keys = [(series, curve.direction) for series, curve in _over_pressure(results)]
    return any(keys.count(key) >= 2 for key in keys)


def friction_pressure(results: Results) -> dict[str, Figure]:
    """Draw friction of each direction, half band and middle over pressure [bar]."""
    figure = style.new_figure(height_in=7.4)
    axes, half, middle = figure.subplots(3, sharex=True, height_ratios=(3, 2, 2))
    curves = list(_over_pressure(results))
    ranks = {key: rank for rank, key in enumerate(dict.fromkeys(key for key, _ in curves))}
    for direction, sign in (("extend", 1), ("retract", -1)):  # a column of the legend each
        for key, rank in ranks.items():
            chosen = [c for series, c in curves if (series, c.direction) == (key, direction)]
            points = [point for curve in chosen for point in curve.points]
            rows = [(p.p_tp_pa, sign * p.friction_n, p.ci95_n) for p in points]
            labels = (key[1], load_words(None, key[2]), DIRECTION_WORDS[direction])
            look = style.series_style(rank, hollow=direction == "retract")
            _points(axes, rows, look, style.safe(", ".join(filter(None, labels))), points)
    differs = any(p_lr is not None for _, _, p_lr in ranks)
    for key, rank in ranks.items():
        look = style.series_style(rank)
        name = style.safe(", ".join(filter(None, (key[1], load_words(None, key[2])))))
        bands = [band for band in results.bands if _key(band, differs) == key]
        trends = [trend for trend in results.band_trends if _key(trend, differs) == key]
        for panel, words, rows, lines in (
            (
                half,
                "half band",
                [(band.p_tp_pa, band.half_n, band.half_ci95_n) for band in bands],
                [(trend.pressures_pa, trend.half) for trend in trends],
            ),
            (
                middle,
                "middle",
                [(band.p_tp_pa, band.middle_n, band.middle_ci95_n) for band in bands],
                [(trend.pressures_pa, trend.middle) for trend in trends],
            ),
        ):
            _points(panel, rows, look, f"_{name or words}", guide=not lines)
            for pressures, line in lines:
                forces = [line.intercept_n + line.slope_n_pa * p for p in pressures]
                bars = [from_si(p, "bar") for p in pressures]
                label = f"_{name or words}, line"
                panel.plot(bars, forces, color=look["color"], label=label, zorder=2)
    axes.set_ylabel("Friction |F| (N)")
    half.set_ylabel("Half band (N)")
    middle.set(xlabel="Chamber pressure (bar)", ylabel="Middle (N)")
    style.start_at_zero(middle)
    for panel in (axes, half):
        panel.set_ylim(bottom=min(0, panel.get_ylim()[0]))
    middle.axhline(0, color="#374151", linewidth=0.9)
    style.head(axes, "Friction against pressure", results)
    style.read_as(figure, "Points: means of the trials; bars: their 95 % Student intervals.")
    style.legend_above(figure, axes, columns=1 if differs else 2)
    return {"": figure}


def _key(record: Band | BandTrend, differs: bool) -> SeriesKey:
    return record.kind, record.label, record.p_lr_ref_pa if differs else None


def _over_pressure(results: Results) -> Iterator[tuple[SeriesKey, Curve]]:
    chosen = (
        curve
        for curve in results.curves
        if KINDS[curve.kind].has_constant_speed
        and not curve.over_velocity
        and all(point.p_tp_pa is not None for point in curve.points)
    )
    for curve in without_common_rod_pressure(chosen):
        yield (curve.kind, curve.label, curve.p_lr_ref_pa), curve


def _points(
    axes: Axes,
    rows: list[PressurePoint],
    look: dict[str, object],
    label: str,
    means: Sequence[CurvePoint] = (),
    guide: bool = True,
) -> None:
    if rows:
        order = sorted(range(len(rows)), key=lambda i: rows[i][0] or 0.0)
        rows = [rows[i] for i in order]
        table = np.array([[np.nan if cell is None else cell for cell in row] for row in rows])
        pressure, friction, interval = table.T
        pressure = from_si(pressure, "bar")
        if guide:
            eye = {"linewidth": 0.8, "linestyle": ":", "zorder": 2}
            axes.plot(pressure, friction, color=look["color"], **eye)
        bars = axes.errorbar(pressure, friction, interval, label=label, **look, **style.POINTS)
        if means:
            behind(bars, of_trials([means[i] for i in order]))
