"""First screen of a fleet's page: identity, tiles, and what became of each number over time."""

from collections.abc import Iterator

from hbench.records import FEWEST_CAMPAIGNS, ControlChart, Fleet, Spread, Trend, WordTable
from hbench.report.conformity.text import check_words
from hbench.report.fleet.charts import named, step_size
from hbench.report.fleet.names import (
    main_spreads,
    name_of,
    of_side,
    range_words,
    without_condition,
    working_speed,
)
from hbench.report.fleet.row import SPEED_NOT_SET, at_pressure, kind_parts
from hbench.report.fleet.text import resolved
from hbench.report.fleet.verdict import (
    change_words,
    decision_words,
    steady_spreads,
    steady_trends,
    stepped_numbers,
)
from hbench.report.render.numbers import NONE, alike, significant
from hbench.report.render.word_tables import Tile, with_columns
from hbench.sentences import capital, uncapital

_RANGES = ("friction_n", "efficiency", "half_band_n", "half_band_slope_n_pa")


def fleet_identity(fleet: Fleet) -> tuple[tuple[str, str], ...]:
    """Return bench, cylinder size, loads and speed of campaigns that are all of one kind."""
    if len(fleet.protocols) != 1:
        return ()
    parts = kind_parts(fleet.protocols[0][0])
    parts["loads"] = parts.pop("loads")  # the longest last
    if parts["working speed"] == [SPEED_NOT_SET]:
        speed = working_speed(fleet)
        parts["working speed"] = [f"{speed}, as measured" if speed else "as measured"]
    names = {"bench or origin": "Bench", "cylinder size": "Areas of piston and rod side"}
    return tuple(
        (
            names.get(name, capital(name)),
            at_pressure("; ".join(values)).removeprefix("simulated, "),
        )
        for name, values in parts.items()
        if values
    )


def fleet_tiles(fleet: Fleet) -> Iterator[Tile]:
    """Yield the tiles: campaigns, outliers, steps, drifts, capability; or ranges of a few."""
    yield _campaigns(fleet)
    if fleet.compared >= FEWEST_CAMPAIGNS and fleet.spreads:
        value = f"{fleet.outliers} of {fleet.compared}"
        yield Tile(value, "outliers", "campaigns that deviate significantly", "method-outliers")
    if fleet.charts:
        steps = [chart.step for chart in fleet.charts if chart.step and chart.step.real]
        names = named(tuple(dict.fromkeys(step.name for step in steps))[:2], 0)
        since = f"of the mean, from {names} on" if steps else "of the mean is significant"
        value = f"{len(steps)} of {len(fleet.charts)}"
        yield Tile(value, "numbers with a step", since, "method-change-points")
    if trends := steady_spreads(fleet):
        drifting = sum(trend.real for _, trend in trends)
        value, unit = f"{drifting} of {len(trends)}", "numbers with a drift"
        others = "of those without a step" if stepped_numbers(fleet) else "over the campaigns"
        yield Tile(value, unit, others, "method-trends")
    if fleet.capabilities:
        least = min(fleet.capabilities, key=lambda each: each.ppk.value)
        words = check_words(least.requirement, least.series)
        count = len(fleet.capabilities)
        of = f"smallest of {count} limits: " if count > 1 else ""
        yield Tile(significant(least.ppk.value, 2), "Ppk", of + words, "method-capability")
    if not fleet.charts:
        yield from _ranges(fleet)


def _campaigns(fleet: Fleet) -> Tile:
    good = fleet.campaigns - fleet.failed
    about = [f"analysed, {fleet.failed} failed" if fleet.failed else "analysed"]
    if fleet.decisions:
        about.append(f"decisions: {decision_words(fleet)}")
    if fleet.qualities:
        grades = ", ".join(f"{count} {grade}" for grade, count in fleet.qualities)
        why = ", ".join(
            name if count == good else f"{name} in {count}" for name, count in fleet.weak_checks
        )
        about.append(f"data: {grades}{f' (because of {why})' if why else ''}")
    return Tile(f"{good} of {fleet.campaigns}", "campaigns", "; ".join(about))


def _ranges(fleet: Fleet) -> Iterator[Tile]:
    for spread in main_spreads(fleet):
        if spread.quantity.name in _RANGES:
            scale = spread.quantity.scale
            value = alike((scale * spread.low, scale * spread.high))
            words = f"{without_condition(spread.quantity)}{of_side(spread.direction)}"
            caption = f"{uncapital(words)}: {range_words(spread.n)}"
            yield Tile(value, spread.quantity.unit, caption, "method-spread")


def overview_table(fleet: Fleet) -> WordTable:
    """Return a row for each number: its middle, its spread, and its change over time."""
    charts = {(chart.quantity, chart.direction): chart for chart in fleet.charts}
    trends = {(s.quantity, s.direction): trend for s, trend in steady_spreads(fleet)}
    rows = []
    for spread in fleet.spreads:
        if spread.n < min(FEWEST_CAMPAIGNS, fleet.compared):
            continue  # the table of their spread has it
        key = spread.quantity, spread.direction
        rows.append(
            (
                name_of(spread),
                str(spread.n),
                resolved(spread, spread.median),
                f"{resolved(spread, spread.low)} to {resolved(spread, spread.high)}",
                _change(spread, charts.get(key), trends.get(key)),
                _beyond(charts.get(key)),
            )
        )
    ends = "Smallest to largest" if fleet.compared < FEWEST_CAMPAIGNS else "5 to 95 %"
    change = "Change over time (95 %)"
    head = ("Quantity", "Campaigns", "Median", ends, change, "Beyond mean ± 3 σ")
    of_all = {str(fleet.compared)}
    kept = [i for i in range(len(head)) if {row[i] for row in rows} not in ({NONE}, of_all)]
    return with_columns(WordTable("Numbers of the fleet", head, tuple(rows)), kept)


def interval_facts(fleet: Fleet) -> tuple[tuple[str, str], ...]:
    """Explain a change whose interval does not contain 0 and that is not significant."""
    apart = [
        trend.p_holm
        for trend in steady_trends(fleet)
        if not trend.real and not trend.low <= 0 <= trend.high
    ]
    if not apart:
        return ()
    p = significant(min(apart), 2)
    words = (
        "Each interval is that of its number alone; significance is corrected for all trends that "
        f"were tested (p = {p} where the interval does not contain 0)."
    )
    return (("Change over time", words),)


def _change(spread: Spread, chart: ControlChart | None, trend: Trend | None) -> str:
    if chart is not None and chart.step is not None and chart.step.real:
        return f"step at {chart.step.name}: {step_size(chart.step, chart.quantity.scale)}"
    if trend is None:
        return NONE
    change = change_words(spread, trend)
    return f"drift: {change}" if trend.real else f"not significant: {change}"


def _beyond(chart: ControlChart | None) -> str:
    return NONE if chart is None else named(chart.outside, chart.beyond)
