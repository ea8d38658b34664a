"""Efficiency and its uncertainty over speed and load."""

from collections import defaultdict

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from hbench.records import KINDS, EfficiencyCurve, EfficiencyPoint, Results
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.campaign.figures.friction import load_helps
from hbench.report.campaign.series_words import TITLES, within_title
from hbench.report.render import style
from hbench.report.render.series import behind, without_math

_LEAST = 3  # loads, and speeds


def has_efficiency_map(results: Results) -> bool:
    """Return whether a direction has efficiencies at three loads of one sign or more."""
    return bool(_groups(results))


def efficiency_map(results: Results) -> dict[str, Figure]:
    """Draw efficiency and its U95 [%] over speed [mm/s] and load [kN], one figure a direction.

    All maps have the same axes, magnitudes from small to large, and the same scale of colours.
    Loads that oppose the motion and loads that help it have separate figures, since the power
    flows in opposite directions and there is no efficiency between them.
    """
    figures: dict[str, Figure] = {}
    groups = {name: _points(curves) for name, curves in _groups(results).items()}
    if not groups:
        return figures
    columns = [[points[:, i] for points in groups.values()] for i in range(4)]
    limits = style.common_limits(columns[0]), style.common_limits(columns[1])
    levels = style.common_levels(columns[2]), style.common_levels(columns[3])
    for name, points in groups.items():
        speed, load, value, u95 = points.T
        known = bool(np.isfinite(u95).all())
        figure = style.new_figure(height_in=6.0 if known else 3.8)
        panels = figure.subplots(2 if known else 1, sharex=True, squeeze=False)[:, 0]
        _map(figure, panels[0], (speed, load, value), limits, levels[0], "Efficiency (%)")
        if known:
            label = "U, trials and instruments (%)"
            _map(figure, panels[1], (speed, load, u95), limits, levels[1], label)
        panels[-1].set_xlabel("Speed |v| (mm/s)")
        style.head(panels[0], f"Efficiency map, {within_title(name)}", results)
        style.read_as(figure, style.OF_MAPS)
        figures[name] = figure
    return figures


def _points(curves: list[EfficiencyCurve]) -> np.ndarray:
    """Return speed [mm/s], magnitude of the load [kN], efficiency and U95 [%]: a row a point."""
    rows = [
        (1e3 * abs(p.v_m_s), abs(curve.f_load_n) / 1e3, 100 * p.efficiency, _percent(p))
        for curve in curves
        for p in curve.points
        if p.efficiency is not None and curve.f_load_n is not None
    ]
    return np.array(rows)


def _percent(point: EfficiencyPoint) -> float:
    return np.nan if point.u95 is None else 100 * point.u95


def _groups(results: Results) -> dict[str, list[EfficiencyCurve]]:
    groups: dict[str, list[EfficiencyCurve]] = defaultdict(list)
    steady = (curve for curve in results.efficiency if KINDS[curve.kind].has_constant_speed)
    for curve in without_common_rod_pressure(curve for curve in steady if curve.f_load_n):
        helps = load_helps(curve)
        names = [TITLES[curve.direction] + (", load helps" if helps else "")]
        if curve.p_lr_ref_pa is not None:
            names.append(f"{curve.p_lr_ref_pa / 1e5:g} bar")
        if sum(point.efficiency is not None for point in curve.points) >= _LEAST:
            groups[", ".join(filter(None, (curve.label, *names)))].append(curve)
    return {
        names: curves
        for names, curves in groups.items()
        if len({curve.f_load_n for curve in curves}) >= _LEAST
    }


def _map(
    figure: Figure,
    axes: Axes,
    points: tuple[np.ndarray, np.ndarray, np.ndarray],
    limits: tuple[tuple[float, float], tuple[float, float]],
    levels: np.ndarray | None,
    label: str,
) -> None:
    """Fill between the points, straight from point to point on triangles of similar sides."""
    speed, load, value = points
    corners = Triangulation(speed / speed.max(), load / np.abs(load).max()).triangles
    mesh = Triangulation(speed, load, corners)
    filled = axes.tricontourf(mesh, value, levels=levels, cmap="cividis")
    lines = axes.tricontour(mesh, value, levels=filled.levels, colors=style.ON_MAPS, linewidths=0.5)
    axes.set(xlim=limits[0], ylim=limits[1])
    style.label_contours(axes, lines)
    (dots,) = axes.plot(speed, load, label="_measured", **style.DOTS)
    behind(dots, {without_math(label): value})
    axes.set_ylabel("Load |$F_L$| (kN)")
    axes.grid(visible=False)
    figure.colorbar(filled, ax=axes, label=label)
