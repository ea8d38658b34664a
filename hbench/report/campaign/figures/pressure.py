"""Friction against chamber pressure, for campaigns with few speeds and several pressures."""

from collections.abc import Collection, Iterable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import DIRECTION_WORDS, KINDS, Band, BandTrend, Curve, CurvePoint, Results
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.figures.friction import of_trials, over_velocity
from hbench.report.campaign.series_words import load_words
from hbench.report.render import style
from hbench.report.render.numbers import significant
from hbench.report.render.series import behind
from hbench.units import from_si

Series = tuple[str, str, float | None, float]  # kind, label, P_Lr [Pa] where it differs, speed
# Pressure [Pa], force [N], half-width of its interval [N].
PressurePoint = tuple[float | None, float, float | None]


def has_pressures(results: Results) -> bool:
    """Return whether a label was measured at two pressures or more, without curves over speed."""
    series = _over_pressure(results)
    return any(len(points) >= 2 for curves in series.values() for points in curves.values())


def friction_pressure(results: Results) -> dict[str, Figure]:
    """Draw friction of each direction, half band and middle over pressure [bar].

    Without friction bands, as of one direction alone, friction is all there is to draw.
    """
    series = _over_pressure(results)
    banded = any(_of_series(results.bands, key, series) for key in series)
    figure = style.new_figure(height_in=7.4 if banded else 4.2)
    rows = (3, 2, 2) if banded else (1,)
    axes, *panels = np.atleast_1d(figure.subplots(len(rows), sharex=True, height_ratios=rows))
    names = {key: _name(key, series) for key in series}
    for direction, sign in (("extend", 1), ("retract", -1)):  # a column of the legend each
        for rank, (key, points_of) in enumerate(series.items()):
            points = points_of.get(direction, [])
            forces = [(p.p_tp_pa, sign * p.friction_n, p.ci95_n) for p in points]
            look = style.series_style(rank, hollow=direction == "retract")
            name = ", ".join(filter(None, (names[key], DIRECTION_WORDS[direction])))
            _points(axes, forces, look, style.safe(name), points)
    if banded:
        for rank, key in enumerate(series):
            bands = _of_series(results.bands, key, series)
            trends = [t for t in results.band_trends if t.bands[0] in bands]
            look, name = style.series_style(rank), style.safe(names[key])
            _band_panels(panels, bands, trends, look, name)
        half, middle = panels
        half.set_ylabel("Half band (N)")
        half.set_ylim(bottom=min(0, half.get_ylim()[0]))
        middle.set_ylabel("Middle (N)")
        style.start_at_zero(middle)
        middle.axhline(0, color="#374151", linewidth=0.9)
    axes.set_ylabel("Friction |F| (N)")
    axes.set_ylim(bottom=min(0, axes.get_ylim()[0]))
    figure.axes[-1].set_xlabel("Chamber pressure (bar)")
    style.head(axes, "Friction against pressure", results)
    style.read_as(figure, "Points: means of the trials; bars: their 95 % Student intervals.")
    differs = any(p_lr is not None for _, _, p_lr, _ in series)
    style.legend_above(figure, axes, columns=1 if differs else 2)
    return {"": figure}


def _band_panels(
    panels: Sequence[Axes],
    bands: Sequence[Band],
    trends: Sequence[BandTrend],
    look: dict[str, object],
    name: str,
) -> None:
    """Draw half bands and middles of a series over pressure, with their lines."""
    halves = [(band.p_tp_pa, band.half_n, band.half_ci95_n) for band in bands]
    middles = [(band.p_tp_pa, band.middle_n, band.middle_ci95_n) for band in bands]
    lines = [[trend.half for trend in trends], [trend.middle for trend in trends]]
    words = ("half band", "middle")
    for panel, what, rows, of_panel in zip(panels, words, (halves, middles), lines, strict=True):
        _points(panel, rows, look, f"_{name or what}", guide=not of_panel)
        for trend, line in zip(trends, of_panel, strict=True):
            forces = [line.intercept_n + line.slope_n_pa * p for p in trend.pressures_pa]
            bars = [from_si(p, "bar") for p in trend.pressures_pa]
            panel.plot(bars, forces, color=look["color"], label=f"_{name or what}, line", zorder=2)


def _over_pressure(results: Results) -> dict[Series, dict[str, list[CurvePoint]]]:
    """Return the points of each series, by direction. Where a load has two speeds, each is one."""
    of_labels = dict[tuple[str, str, float | None], list[Curve]]()
    drawn = {(curve.kind, curve.label) for curve in over_velocity(results)}
    chosen = (
        curve
        for curve in results.curves
        if KINDS[curve.kind].has_constant_speed
        and (curve.kind, curve.label) not in drawn
        and all(point.p_tp_pa is not None for point in curve.points)
    )
    for curve in without_common_rod_pressure(chosen):
        key = curve.kind, curve.label, curve.p_lr_ref_pa
        of_labels.setdefault(key, []).append(curve)
    series = dict[Series, dict[str, list[CurvePoint]]]()
    for key, curves in of_labels.items():
        speeds = _set_speeds(curves)
        for curve in curves:
            for point in curve.points:
                of_speed = series.setdefault((*key, _nearest(point.v_m_s, speeds)), {})
                of_speed.setdefault(curve.direction, []).append(point)
    return series


def _set_speeds(curves: Sequence[Curve]) -> np.ndarray:
    """Return the mean speeds [m/s] of the loads with the most of them, slow ones first."""
    most = max(len(curve.points) for curve in curves)
    speeds = [[abs(p.v_m_s) for p in c.points] for c in curves if len(c.points) == most]
    return np.sort(np.abs(speeds), axis=1).mean(axis=0)


def _nearest(v_m_s: float, speeds: np.ndarray) -> float:
    return float(speeds[np.argmin(np.abs(speeds - abs(v_m_s)))])


def _of_series(bands: Iterable[Band], key: Series, series: Collection[Series]) -> list[Band]:
    """Return the bands of a series."""
    kind, label, p_lr, _ = key
    differs = any(each[2] is not None for each in series)
    speeds = np.array([each[3] for each in series if each[:3] == key[:3]])
    return [
        band
        for band in bands
        if (band.kind, band.label) == (kind, label)
        and (not differs or band.p_lr_ref_pa == p_lr)
        and _nearest(band.v_m_s, speeds) == key[3]
    ]


def _name(key: Series, series: Collection[Series]) -> str:
    """Return a series' label, with its rod-side pressure and its speed where these differ."""
    _, label, p_lr, v_m_s = key
    several = sum(each[:3] == key[:3] for each in series) > 1
    speed = f"{significant(1e3 * v_m_s, 3)} mm/s" if several else ""
    return ", ".join(filter(None, (label, load_words(None, p_lr), speed)))


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
