"""Friction, breakaway and leakage over the distance travelled."""

import numpy as np
from matplotlib.figure import Figure

from hbench.records import DistanceTrend, Results
from hbench.report.campaign.motion_rows import DISTANCE_QUANTITIES, distance_words
from hbench.report.render import style
from hbench.report.render.series import behind
from hbench.units import from_si

_PANEL_IN = 2.5
_LEGEND_LINE = 0.12  # of the panel's height, for each series
_MANY = 40  # values; more have smaller points


def has_over_distance(results: Results) -> bool:
    """Return whether a quantity was measured often enough for a trend over the distance."""
    return bool(results.motions.over_distance)


def over_distance(results: Results) -> dict[str, Figure]:
    """Draw each value over the distance [m] with the straight line of its series."""
    groups: dict[str, list[DistanceTrend]] = {}
    for trend in results.motions.over_distance:
        groups.setdefault(trend.quantity, []).append(trend)
    figure = style.new_figure(height_in=1.4 + _PANEL_IN * len(groups))
    panels = figure.subplots(len(groups), sharex=True, squeeze=False)[:, 0]
    for axes, (quantity, trends) in zip(panels, groups.items(), strict=True):
        name, unit = DISTANCE_QUANTITIES[quantity]
        for rank, trend in enumerate(trends):
            look = style.series_style(rank)
            x, y = np.array(trend.distance_m), np.array(trend.values)
            label = distance_words(trend)
            look |= {"markersize": 3 if len(x) > _MANY else 6}
            points = axes.errorbar(x, y * from_si(1.0, unit), label=label, **look, **style.POINTS)
            behind(points, {})
            line = trend.intercept + trend.slope * x
            axes.plot(x, line * from_si(1.0, unit), color=look["color"], lw=1.0, label=f"_{label}")
        axes.set_ylabel(f"{name} ({unit})")
        if len(groups) > 1:
            low, high = axes.get_ylim()
            axes.set_ylim(low, high + _LEGEND_LINE * len(trends) * (high - low))
            axes.legend(fontsize=8, frameon=True, edgecolor="#9ca3af", loc="upper left")
    panels[-1].set_xlabel("Distance travelled (m)")
    style.head(panels[0], "Over the distance", results)
    if len(groups) == 1:
        style.legend_above(figure, panels[0], columns=2)
    style.read_as(figure, "One point for each run or cycle; lines: straight, by least squares.")
    return {"": figure}
