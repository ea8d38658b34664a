"""Figures of the measurement: sources of variance, control charts, wear."""

import math
from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import DIRECTIONS, ControlChart, Fleet, Precision, Quantity, Side, WearTrend
from hbench.report.campaign.series_words import TITLES
from hbench.report.fleet.charts import chart_words
from hbench.report.fleet.dates import set_dates
from hbench.report.fleet.names import of_side, short_title
from hbench.report.fleet.precision import source_words
from hbench.report.render import style
from hbench.report.render.figures import Sketch
from hbench.report.render.series import behind

COMPONENTS, CHARTS, WEAR = "components", "charts", "wear"
_REACH = 3.0  # times the largest estimate: longer bars are cut
_APART = 0.22  # of the two directions in a row
_LONGEST = 16  # letters of such a name
_MOST_CYLINDERS = 6  # in a figure of wear


def precision_sketches(fleet: Fleet) -> Iterator[Sketch]:
    """Yield the figures of each number, both directions together, each to be drawn at once."""
    for quantity in dict.fromkeys(study.quantity for study in fleet.precision):
        studies = [study for study in fleet.precision if study.quantity == quantity]
        figure, cut = draw_components(quantity, studies, fleet)
        caption = "Bars: 95 % intervals." + (" Bars at the edge continue." if cut else "")
        name = f"components-{_name(quantity, None)}"
        yield Sketch(name, COMPONENTS, quantity.words, caption, figure)
    for chart in fleet.charts:
        name = _name(chart.quantity, chart.direction)
        caption = (
            f"Above: each point is a {chart_words(chart)}; lines: mean and mean ± 3 σ. Below: "
            "exponentially weighted moving average (EWMA) with its limits. Rings: beyond the "
            "limits; squares: last point of another pattern."
        )
        if chart.step is not None and chart.step.real:
            caption += (
                " Thick lines: means before and after the step; the limits are those of the "
                f"{chart.n_limits} campaigns before it."
            )
        if chart.n > len(chart.values):
            caption += f" The last {len(chart.values)} of {chart.n} campaigns are shown."
        words = f"{chart.quantity.words}{of_side(chart.direction)}"
        yield Sketch(f"control-{name}", CHARTS, words, caption, draw_chart(chart, fleet))
    over_distance = [trend for trend in fleet.wear if trend.over == "distance_m"]
    for quantity, direction in dict.fromkeys((t.quantity, t.direction) for t in over_distance):
        trends = [t for t in over_distance if (t.quantity, t.direction) == (quantity, direction)]
        words = f"{quantity.words}{of_side(direction)}"
        caption = "Solid lines: significant; dashed: not significant."
        if len(trends) > _MOST_CYLINDERS:
            caption += f" The {_MOST_CYLINDERS} cylinders with the smallest p."
        figure = draw_wear(trends[:_MOST_CYLINDERS], fleet)
        yield Sketch(f"wear-{_name(quantity, direction)}", WEAR, words, caption, figure)


def draw_components(
    quantity: Quantity, studies: list[Precision], fleet: Fleet
) -> tuple[Figure, bool]:
    """Draw the standard deviation of each source; return also whether a bar is cut."""
    names = list(dict.fromkeys(source_words(s) for study in studies for s in study.sources))
    figure = style.new_figure(height_in=1.6 + 0.42 * len(names))
    axes = figure.add_subplot()
    largest, cut = 0.0, False
    for study in studies:
        offset = 0.0 if study.direction is None else _APART * (study.direction == "retract")
        value, low, high = (
            quantity.scale * np.array([math.sqrt(part(s.variance)) for s in study.sources])
            for part in (
                lambda v: v.value,
                lambda v: v.low,
                lambda v: math.inf if v.high is None else v.high,
            )
        )
        largest = max(largest, value.max())
        at = np.array([names.index(source_words(s)) for s in study.sources]) + offset
        look = _look(study.direction)
        shown = np.minimum(high, 1e3 * value.max())
        (points,) = axes.plot(
            value, at, linestyle="none", label=_title(study.direction), zorder=3, **look
        )
        axes.hlines(at, low, shown, color=look["color"], linewidth=1.4)
        behind(points, {"lower end": low, "upper end": high})
        cut |= bool((high > _REACH * value.max()).any())
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_xlim(0, _REACH * largest if largest > 0 else None)
    axes.set_xlabel(f"Standard deviation ({quantity.unit})")
    axes.grid(axis="y", visible=False)
    head(axes, quantity, fleet)
    style.legend_above(figure, axes)
    return figure, cut


def draw_chart(chart: ControlChart, fleet: Fleet) -> Figure:
    """Draw the values over the date with mean and limits, and their EWMA below."""
    figure = style.new_figure(height_in=5.0)
    axes, below = figure.subplots(2, sharex=True, height_ratios=(3, 2))
    look = _look(chart.direction)
    scale = chart.quantity.scale
    at, values = np.array(chart.at), scale * np.array(chart.values)
    low, high = (scale * limit for limit in chart.limits)
    axes.plot(at, values, linewidth=0.8, color=look["color"], alpha=0.5)
    (points,) = axes.plot(
        at, values, linestyle="none", markersize=4, label=_title(chart.direction), **look
    )
    behind(points, {"campaign": chart.names})
    beyond = (values < low) | (values > high)
    if beyond.any():
        axes.plot(
            at[beyond], values[beyond], linestyle="none", marker="o", markersize=11,
            markerfacecolor="none", color="#000000", label="beyond the limits",
        )  # fmt: skip
    patterns = np.isin(
        np.arange(len(values)),
        [chart.names.index(name) for s in chart.signals for name in s.names if name in chart.names],
    )
    others = patterns & ~beyond
    if others.any():
        axes.plot(
            at[others], values[others], linestyle="none", marker="s", markersize=10,
            markerfacecolor="none", color=style.QUIET, label="pattern",
        )  # fmt: skip
    axes.margins(y=0.1)
    for panel in (axes, below):
        panel.axhline(scale * chart.centre, color=style.QUIET, linewidth=1.2)
    for limit in (low, high):
        axes.axhline(limit, color=style.QUIET, linestyle="--", linewidth=1.2)
    if chart.step is not None and chart.step.real:
        for mean, ends in (
            (chart.step.before, (at[0], chart.step.at)),
            (chart.step.after, (chart.step.at, at[-1])),
        ):
            axes.plot(ends, [scale * mean] * 2, color="#000000", linewidth=2.0, label="_step")
    _draw_ewma(below, chart, at, look)
    axes.set(ylabel=f"{short_title(chart.quantity)} ({chart.quantity.unit})")
    below.set_ylabel(f"EWMA ({chart.quantity.unit})")
    set_dates(below, fleet)
    figure.align_ylabels()
    head(axes, chart.quantity, fleet)
    style.legend_above(figure, axes)
    return figure


def _draw_ewma(axes: Axes, chart: ControlChart, at: np.ndarray, look: dict) -> None:
    scale = chart.quantity.scale
    values, low, high = (
        scale * np.array(each) for each in (chart.ewma, chart.ewma_low, chart.ewma_high)
    )
    axes.plot(at, values, color=look["color"], linewidth=1.5, label="_EWMA")
    for limit in (low, high):
        axes.plot(
            at, limit, color=style.QUIET, linestyle="--", linewidth=1.2, label="_limit of the EWMA"
        )
    beyond = (values < low) | (values > high)
    if beyond.any():
        axes.plot(
            at[beyond], values[beyond], linestyle="none", marker="o", markersize=8,
            markerfacecolor="none", color="#000000", label="_beyond the limits",
        )  # fmt: skip


def draw_wear(trends: list[WearTrend], fleet: Fleet) -> Figure:
    """Draw the values of some cylinders over the distance, with their lines."""
    figure = style.new_figure(height_in=3.6)
    axes = figure.add_subplot()
    quantity = trends[0].quantity
    for i, trend in enumerate(sorted(trends, key=lambda trend: trend.specimen)):
        look = style.series_style(i)
        x = np.array(trend.x)
        values = quantity.scale * np.array(trend.values)
        name = style.safe(trend.specimen, _LONGEST)
        axes.plot(x, values, linestyle="none", label=name, markersize=4, **look)
        line = quantity.scale * (trend.intercept + trend.slope * x[[0, -1]])
        dashes = "-" if trend.real else "--"
        axes.plot(x[[0, -1]], line, color=look["color"], linestyle=dashes)
    axes.set(
        xlabel="Distance, cumulated (m)",
        ylabel=f"{short_title(quantity)} ({quantity.unit})",
    )
    head(axes, quantity, fleet)
    style.legend_above(figure, axes)
    return figure


def _name(quantity: Quantity, direction: Side) -> str:
    return "-".join(filter(None, (quantity.name.replace("_", "-"), direction)))


def _look(direction: Side) -> dict:
    return style.series_style(0 if direction is None else DIRECTIONS.index(direction))


def _title(direction: Side) -> str:
    return "Both directions" if direction is None else TITLES[direction]


def head(axes: Axes, quantity: Quantity, fleet: Fleet) -> None:
    """Put the quantity as the title, and a mark where campaigns are simulated."""
    axes.set_title(short_title(quantity))
    style.mark_sources(axes, [source for source, _ in fleet.sources], "some are simulated")
