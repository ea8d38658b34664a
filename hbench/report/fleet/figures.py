"""Figures of a fleet: the distribution of each number over the campaigns, and its drift."""

from collections.abc import Collection, Iterable

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from hbench.records import DIRECTIONS, FEWEST_CAMPAIGNS, Fleet, Quantity, Side, Spread
from hbench.records.numbers import NORMAL_95
from hbench.report.campaign.series_words import TITLES
from hbench.report.fleet.dates import set_dates
from hbench.report.fleet.names import campaign_names, short_title
from hbench.report.fleet.precision_figures import head, precision_sketches
from hbench.report.fleet.verdict import stepped_numbers
from hbench.report.render import style
from hbench.report.render.figures import Drawing, Sketch, draw_sketches
from hbench.report.render.series import behind
from hbench.sentences import counted, plural

DISTRIBUTIONS, DRIFTS = "distributions", "drifts"
_COUNTED = "Each campaign counts once, in its class of values."
_SINGLE = f"Bars: ±{NORMAL_95:.2f} standard errors of a campaign's own trials."
_NO_BARS = "\nA point without bars has no standard error: do not rely on its value."
_BLOCKS = "Points: medians of campaigns that follow each other; band: 5 to 95 % of them."
_NAMED = 30  # campaigns: up to so many have their names below the axis
_LONGEST = 16  # letters of such a name
_FEWEST = 3  # campaigns that a figure compares, in a fleet that has more


def draw_fleet(fleet: Fleet) -> tuple[Drawing, ...]:
    """Draw the distribution of each number and its course, both directions in each figure."""
    sketches = []
    for quantity in dict.fromkeys(spread.quantity for spread in fleet.spreads):
        spreads = [spread for spread in fleet.spreads if spread.quantity == quantity]
        if all(spread.n < min(_FEWEST, fleet.compared) for spread in spreads):
            continue  # nothing to compare
        name = quantity.name.replace("_", "-")
        enough = [spread for spread in spreads if spread.n >= FEWEST_CAMPAIGNS]
        with rc_context(style.RC):
            drift = draw_drift(quantity, spreads, fleet)
            if enough:
                figure = draw_distribution(quantity, enough, fleet)
                title, caption = quantity.words, _outside(enough)
                sketches.append(
                    Sketch(f"distribution-{name}", DISTRIBUTIONS, title, caption, figure)
                )
        caption = _trends(spreads, stepped_numbers(fleet))
        sketches.append(Sketch(f"drift-{name}", DRIFTS, quantity.words, caption, drift))
    with rc_context(style.RC):
        sketches += precision_sketches(fleet)
    return draw_sketches(sketches)


def draw_distribution(quantity: Quantity, spreads: Iterable[Spread], fleet: Fleet) -> Figure:
    """Draw the number of campaigns over the value."""
    figure = style.new_figure(height_in=3.6)
    axes = figure.add_subplot()
    for spread in spreads:
        look = _look(spread)
        edges = quantity.scale * np.array(spread.edges)
        middles = (edges[:-1] + edges[1:]) / 2
        title = _title(spread)
        axes.stairs(spread.counts, edges, fill=True, color=look["color"], alpha=0.2, label=title)
        axes.stairs(spread.counts, edges, color=look["color"], linewidth=1.6)
        axes.plot(middles, spread.counts, linestyle="none", label=f"_{title}")
        median = quantity.scale * spread.median
        axes.axvline(median, color=look["color"], linestyle="--", linewidth=1.2)
        axes.plot([], [], color=look["color"], linestyle="--", label=f"{title}, median")
    axes.set(xlabel=f"{quantity.words} ({quantity.unit})", ylabel="Campaigns")
    axes.set_ylim(bottom=0)
    axes.yaxis.get_major_locator().set_params(integer=True)
    head(axes, quantity, fleet)
    style.read_as(figure, _COUNTED)
    style.legend_above(figure, axes, columns=2)
    return figure


def draw_drift(quantity: Quantity, spreads: Iterable[Spread], fleet: Fleet) -> Figure:
    """Draw the value over the date, or over the order of the campaigns."""
    spreads = list(spreads)
    figure = style.new_figure(height_in=3.6)
    axes = figure.add_subplot()
    stepped = stepped_numbers(fleet)
    for spread in spreads:
        _course(axes, spread, (spread.quantity, spread.direction) not in stepped)
    axes.set_ylabel(f"{short_title(quantity)} ({quantity.unit})")
    set_dates(axes, fleet)
    if not fleet.by_date and 0 < len(names := _names(fleet)) <= _NAMED:
        axes.set_xticks(range(1, len(names) + 1), names, rotation=40, ha="right", fontsize=8)
        axes.set_xlabel("Campaign")
    head(axes, quantity, fleet)
    style.read_as(figure, _read_as(spreads))
    style.legend_above(figure, axes)
    return figure


def _course(axes: Axes, spread: Spread, with_trend: bool) -> None:
    look, scale = _look(spread), spread.quantity.scale
    title = _title(spread)
    at = np.array([block.at for block in spread.blocks])
    median, low, high = (
        scale * np.array([getattr(block, name) for block in spread.blocks])
        for name in ("median", "low", "high")
    )
    if any(block.n > 1 for block in spread.blocks):
        axes.fill_between(at, low, high, color=look["color"], alpha=0.15, linewidth=0)
        (points,) = axes.plot(at, median, linestyle="none", label=title, markersize=4, **look)
        counts = np.array([float(block.n) for block in spread.blocks])
        behind(points, {"campaigns": counts, "5 % quantile": low, "95 % quantile": high})
    else:
        axes.errorbar(at, median, (high - low) / 2, label=title, **look, **style.SMALL_POINTS)
    if with_trend and spread.trend is not None and spread.trend.real:
        ends = [scale * spread.trend.start, scale * (spread.trend.start + spread.trend.change)]
        label = f"{title}, trend"
        axes.plot([at[0], at[-1]], ends, color="#000000", linewidth=3.0, zorder=4)
        axes.plot([at[0], at[-1]], ends, color=look["color"], label=label, zorder=5)


def _look(spread: Spread) -> dict:
    return style.series_style(0 if spread.direction is None else DIRECTIONS.index(spread.direction))


def _title(spread: Spread) -> str:
    return "Campaigns" if spread.direction is None else TITLES[spread.direction]


def _names(fleet: Fleet) -> list[str]:
    """Return the labels of the compared campaigns of a small fleet, or their folders."""
    names = campaign_names(fleet)
    return [
        style.safe(campaign.label or names[campaign.path], _LONGEST)
        for campaign in fleet.rows
        if campaign.compared
    ]


def _outside(spreads: Iterable[Spread]) -> str:
    sentences = ["Number of campaigns by value; dashed: medians."]
    for spread in spreads:
        if spread.below or spread.above:
            side = "" if spread.direction is None else f"{_title(spread)}: "
            ways = (("left", spread.below), ("right", spread.above))
            beyond = " and ".join(f"{_lie(count)} further {way}" for way, count in ways if count)
            sentences.append(f"{side}{beyond} than the figure shows.")
    return " ".join(sentences)


def _lie(count: int) -> str:
    return f"{counted(count, 'campaign')} {plural(count, 'lies', 'lie')}"


def _read_as(spreads: Iterable[Spread]) -> str:
    blocks = [block for spread in spreads for block in spread.blocks]
    if any(block.n > 1 for block in blocks):
        return _BLOCKS
    return _SINGLE if all(block.high > block.low for block in blocks) else _SINGLE + _NO_BARS


def _trends(spreads: Iterable[Spread], stepped: Collection[tuple[Quantity, Side]]) -> str:
    drawn = list(spreads)
    steps = [_title(each).lower() for each in drawn if (each.quantity, each.direction) in stepped]
    trends = [
        spread.trend
        for spread in drawn
        if spread.trend is not None and (spread.quantity, spread.direction) not in stepped
    ]
    if all(spread.trend is None for spread in drawn):
        return f"The trend is not tested: that takes at least {FEWEST_CAMPAIGNS} campaigns."
    text = "By date of the campaign."
    if any(trend.real for trend in trends):
        text += " Line: significant trend (Theil and Sen's line)."
    elif trends:
        text += " No trend is significant."
    if steps:
        text += f" The control charts show a step of the mean: {' and '.join(steps)}."
    untested = [_title(spread).lower() for spread in drawn if spread.n < FEWEST_CAMPAIGNS]
    if not untested:
        return text
    return f"{text} Not tested: {' and '.join(untested)}, with fewer than {FEWEST_CAMPAIGNS}."
