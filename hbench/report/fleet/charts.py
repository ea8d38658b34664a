"""Control charts, capability and wear of a fleet, in words and tables."""

import re
from collections.abc import Iterable, Iterator

from hbench.records import (
    ChartStep,
    ControlChart,
    Estimate,
    Fleet,
    WearTrend,
    WordTable,
)
from hbench.report.conformity.text import check_words, limit_words
from hbench.report.fleet.names import (
    name_of,
    signed,
    working_speed,
)
from hbench.report.render.numbers import NONE, finer, p_words, significant, with_ends, with_interval
from hbench.sentences import capital
from hbench.units import from_si

CHECK_WHAT = "check whether the cylinders, the bench or its instruments changed there"
_NAMED = 5  # campaigns in a sentence
_AMOUNTS = {
    "distance_m": ("distance", "km", 1e-3),
    "friction_work_j": ("friction work", "MJ", 1e-6),
}


def because_of_step(fleet: Fleet) -> str:
    """Return that limits are those before a step that campaigns are beyond; empty without one."""
    outside = [chart for chart in fleet.charts if chart.outside]
    if not any(chart.n_limits < chart.n for chart in outside):
        return ""
    return " of the campaigns before the change"


def wear_sentences(fleet: Fleet) -> Iterator[str]:
    """Yield significant wear."""
    for trend in fleet.wear:
        if trend.real:
            yield (
                f"{trend.specimen}: {name_of(trend)} changes with {_AMOUNTS[trend.over][0]} by "
                f"{_slope(trend)} {slope_unit(trend)}."
            )


def chart_table(fleet: Fleet) -> WordTable:
    """Return the control limits of each number, and the campaigns beyond them.

    Mean and limits of a number with a step are those of the campaigns before it.
    """
    stepped = any(chart.n_limits < chart.n for chart in fleet.charts)
    rows = []
    for chart in fleet.charts:
        scale = chart.quantity.scale
        low, high = (significant(scale * limit, 4) for limit in chart.limits)
        rows.append(
            (
                name_of(chart),
                str(chart.n),
                *([_limits_from(chart)] if stepped else []),
                significant(scale * chart.centre, 4),
                f"{low} to {high}",
                named(chart.outside, chart.beyond),
                str(chart.moved),
            )
        )
    of = ("Mean and limits from",) if stepped else ()
    head = ("Quantity", "Campaigns", *of, "Mean", "Limits", "Beyond them", "Moving ranges beyond")
    return WordTable("Control charts", head, tuple(rows))


def _limits_from(chart: ControlChart) -> str:
    """Return the campaigns that mean and limits are of."""
    return "all" if chart.n_limits == chart.n else f"the first {chart.n_limits}"


def signal_table(fleet: Fleet) -> WordTable:
    """Return each rule that signals on a control chart, with the first campaigns."""
    rows = tuple(
        (name_of(chart), signal.rule, str(signal.count), named(signal.names, signal.count))
        for chart in fleet.charts
        for signal in chart.signals
    )
    return WordTable("Signals of the control charts", ("Quantity", "Rule", "Points", "At"), rows)


def step_table(fleet: Fleet) -> WordTable:
    """Return the most likely step of the mean of each number."""
    rows = []
    for chart in fleet.charts:
        if (step := chart.step) is None:
            continue
        scale = chart.quantity.scale
        before, after = (
            finer(scale * mean, scale * step.ci95) for mean in (step.before, step.after)
        )
        rows.append(
            (
                name_of(chart),
                step.name,
                before,
                after,
                step_size(step, scale),
                significant(step.p_holm, 2),
                "step" if step.real else "not significant",
            )
        )
    head = (
        "Quantity",
        "From campaign",
        "Mean before",
        "After",
        "Step (95 %)",
        "p (Holm)",
        "Verdict",
    )
    return WordTable("Change points", head, tuple(rows))


def step_size(step: ChartStep, scale: float) -> str:
    """Write the size of a step with its 95 % interval."""
    return signed(with_interval(scale * (step.after - step.before), scale * step.ci95))


def capability_table(fleet: Fleet) -> WordTable:
    """Return Ppk and Cpk of each limited quantity, with their intervals."""
    rows = []
    for each in fleet.capabilities:
        unit = each.requirement.unit
        rows.append(
            (
                capital(check_words(each.requirement, each.series)),
                str(each.n),
                limit_words(each.requirement),
                f"{significant(from_si(each.series.value, unit), 4)} {unit}",
                _index(each.ppk, each.sigma, unit),
                NONE
                if each.cpk is None or each.sigma_within is None
                else _index(each.cpk, each.sigma_within, unit),
                str(each.outside),
            )
        )
    head = ("Quantity", "Campaigns", "Limit", "Mean", "Ppk (s)", "Cpk (s_w)", "Beyond the limit")
    return WordTable("Capability", head, tuple(rows))


def _index(index: Estimate, sigma: float, unit: str) -> str:
    """Write an index with its interval, and the standard deviation that it is of."""
    shown = with_ends(index.value, index.low, index.high or index.value)
    return f"{shown} ({significant(from_si(sigma, unit), 2)} {unit})"


def capability_notes(fleet: Fleet) -> Iterator[str]:
    """Yield what the two indices are, and the limits that have none, with the reason."""
    if fleet.capabilities:
        stepped = any(chart.step is not None and chart.step.real for chart in fleet.charts)
        speed = working_speed(fleet)
        yield (
            "Ppk uses the standard deviation s of all campaigns, Cpk that from one campaign to the "
            "next, s_w, which a step or a drift hardly increases."
            + (" As long as the mean changes, neither predicts later campaigns." * stepped)
        )
        yield (
            "Values are those of the speeds and loads of the limits. The other numbers are means "
            f"over the loads at the working speed{f', {speed}' if speed else ''}."
        )
    for limit, reason in fleet.without_capability:
        yield f"No Ppk for {check_words(limit, None)} ({limit_words(limit)}): {reason}."


def wear_table(fleet: Fleet) -> WordTable:
    """Return the slope of each cylinder's friction over distance and work."""
    rows = [
        (
            trend.specimen,
            name_of(trend),
            _AMOUNTS[trend.over][0],
            str(len(trend.x)),
            f"{_slope(trend)} {slope_unit(trend)}",
            p_words(trend.p_holm),
            "significant" if trend.real else "not significant",
        )
        for trend in fleet.wear
    ]
    head = ("Cylinder", "Quantity", "Over", "Campaigns", "Slope", "p (Holm)", "Verdict")
    return WordTable("Wear", head, tuple(rows))


def slope_unit(trend: WearTrend) -> str:
    """Return the unit of a trend's slope."""
    return f"{trend.quantity.unit}/{_AMOUNTS[trend.over][1]}"


def chart_words(chart: ControlChart) -> str:
    """Return what the chart's values are."""
    return "deviation from its cylinder's mean, plus the mean" if chart.of_cylinders else "value"


def in_order(names: Iterable[str]) -> tuple[str, ...]:
    """Return each name once, in the order of their letters and numbers."""
    parts = re.compile(r"\d+|\D+")

    def key(name: str) -> list[tuple[bool, int, str]]:
        found = parts.findall(name)
        return [(not p.isdecimal(), int(p) if p.isdecimal() else 0, p) for p in found]

    return tuple(sorted(dict.fromkeys(names), key=key))


def named(names: tuple[str, ...], count: int) -> str:
    """Return the first names of so many, and how many more there are."""
    more = f" and {count - len(names)} more" if count > len(names) else ""
    return (", ".join(names) or "none") + more


def _slope(trend: WearTrend) -> str:
    factor = trend.quantity.scale / _AMOUNTS[trend.over][2]
    return signed(with_ends(factor * trend.slope, factor * trend.low, factor * trend.high))
