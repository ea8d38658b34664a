"""Sentences of a campaign's verdict on changes over the distance: run-in and endurance."""

from hbench.records import DistanceTrend, Results
from hbench.records.numbers import SIGNIFICANCE
from hbench.report.campaign.motion_rows import DISTANCE_QUANTITIES, distance_words
from hbench.report.render.numbers import number, whole_mm_s, with_interval
from hbench.sentences import listed, plural
from hbench.units import from_si

_VERDICTS = {
    "settled": "has settled",
    "changing": "still changed",
    "not determined": "may still have changed",
}
_MOST_NAMED = 3  # significant changes; the table has them all


def run_in_words(results: Results) -> str:
    """State whether the friction of cycles has settled; empty without cycles."""
    cycles = [trend for trend in results.motions.over_distance if _is_of_cycles(trend)]
    if not cycles:
        return ""
    alike = len({trend.series for trend in cycles}) == 1
    groups = []
    for verdict in dict.fromkeys(trend.verdict for trend in cycles):
        places = [_last_change(each, alike) for each in cycles if each.verdict == verdict]
        groups.append(f"{_VERDICTS[verdict]} {listed(places)}")
    last = max(cycles, key=lambda trend: trend.distance_m[-1])
    again = "" if last.verdict == "settled" else " Repeat the cycles until it has settled."
    return (
        f"Friction {listed(groups)}.{again} The intervals are those of the scatter of the cycles, "
        "without the errors of the instruments."
    )


def endurance_words(results: Results) -> str:
    """State which quantities changed between blocks of cycles; empty without such blocks."""
    trends = results.motions.over_distance
    if all(map(_is_of_cycles, trends)) or not any(map(_is_of_cycles, trends)):
        return ""
    over = f"over {number(max(trend.distance_m[-1] for trend in trends), 0)} m of travel"
    changed = [trend for trend in trends if trend.p_holm < SIGNIFICANCE]
    if not changed:
        names = dict.fromkeys(DISTANCE_QUANTITIES[trend.quantity][0].lower() for trend in trends)
        return f"No change of {listed(list(names), 'or')} {over} is significant."
    named = [_change(trend) for trend in changed[:_MOST_NAMED]]
    more = len(changed) - len(named)
    named += [f"{more} more"] if more else []
    are = plural(len(changed), "is", "are")
    return f"{len(changed)} of {len(trends)} trends {over} {are} significant: {'; '.join(named)}."


def _is_of_cycles(trend: DistanceTrend) -> bool:
    return trend.kind == "triangle"


def _last_change(trend: DistanceTrend, alike: bool) -> str:
    """Write where cycles were made, their friction and its last change."""
    speed = "" if trend.v_m_s is None else f"cycles up to {whole_mm_s(trend.v_m_s)} mm/s"
    change = with_interval(trend.last_change, trend.last_change_ci95)
    sign = "+" if trend.last_change > 0 else ""
    length = number(trend.distance_m[-1] - trend.last_from_m, 1)
    return (
        f"in {speed if alike else distance_words(trend)} "
        f"({number(trend.last_mean, 0)} N, change {sign}{change} N over the last {length} m)"
    )


def _change(trend: DistanceTrend) -> str:
    """Write a quantity and its change over the whole distance."""
    name, unit = DISTANCE_QUANTITIES[trend.quantity]
    over = from_si(1.0, unit) * (trend.distance_m[-1] - trend.distance_m[0])
    sign = "+" if trend.slope > 0 else ""
    change = with_interval(over * trend.slope, over * trend.slope_ci95)
    return f"{name.lower()} ({distance_words(trend)}) {sign}{change} {unit}"
