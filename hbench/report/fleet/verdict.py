"""Verdict of a fleet, and its findings: outliers and drifts in sentences."""

import math
from collections.abc import Iterator

from hbench.records import FEWEST_CAMPAIGNS, Fleet, Quantity, Side, Spread, Suspect, Trend
from hbench.report.fleet.charts import (
    CHECK_WHAT,
    because_of_step,
    in_order,
    named,
    step_size,
    wear_sentences,
)
from hbench.report.fleet.names import (
    WORKING_SPEED,
    campaign_names,
    in_sentence,
    main_spreads,
    of_change,
    of_side,
    range_words,
    signed,
    working_speed,
)
from hbench.report.render.numbers import alike, half_width, significant, with_ends
from hbench.sentences import capital, plural, uncapital

_LIMITS_ARE_NARROWER = (
    "A campaign beyond a control limit need not be an outlier: control limits are narrower."
)
_NAMED = 3  # steps, outliers and drifts in a sentence


def fleet_verdict(fleet: Fleet) -> str:
    """Return decisions, failures, friction and what is conspicuous, in a few short sentences."""
    sentences = [f"Decisions: {decision_words(fleet)}."] if fleet.decisions else []
    passed = fleet.decisions == (("PASS", fleet.campaigns),)
    changes = _changes(fleet)
    changed = "; ".join(f"{' and '.join(sizes)} changed from {at} on" for at, sizes in changes)
    if passed:
        but = f", but {changed}" if changed else ""
        sentences = [f"All {fleet.campaigns} campaigns have the decision PASS{but}."]
    elif changed:
        sentences.append(f"{capital(changed)}.")
    if fleet.failed:
        sentences.append(f"{fleet.failed} of {fleet.campaigns} campaigns could not be analysed.")
    analyzed = fleet.campaigns - fleet.failed
    poor = dict(fleet.qualities).get("poor", 0)
    if fleet.incomplete:
        verb = "is" if fleet.incomplete == 1 else "are"
        sentences.append(f"{fleet.incomplete} of {analyzed} analysed campaigns {verb} incomplete.")
    if fleet.copies:
        which = "is a copy" if fleet.copies == 1 else "are copies"
        sentences.append(
            f"{fleet.copies} of {analyzed} analysed campaigns {which} with the logs of another, "
            "not compared."
        )
    if poor:
        verb = plural(poor, "has", "have")
        sentences.append(f"{poor} of {analyzed} analysed campaigns {verb} poor data.")
    if not fleet.spreads:
        sentences.append("No campaign has a number to compare.")
        return " ".join(sentences)
    friction = () if changes else _friction_words(fleet)  # of two levels; the tiles have its range
    found = [
        *_change_words(changes),
        *_drift_within(fleet, changes),
        *friction,
        *_conspicuous_words(fleet),
    ]
    if passed and not (fleet.incomplete or poor or any(_to_be_checked(fleet))):
        few = f"; changes over time are tested from {FEWEST_CAMPAIGNS} campaigns on"
        found.append(f"Next step: none{few if fleet.compared < FEWEST_CAMPAIGNS else ''}.")
    return " ".join([*sentences, *found])


def _to_be_checked(fleet: Fleet) -> Iterator[bool]:
    """Yield whether there are failed campaigns, outliers, steps, signals of charts or drifts."""
    yield bool(fleet.failed or fleet.outliers)
    yield any(chart.outside or (chart.step and chart.step.real) for chart in fleet.charts)
    yield any(trend.real for trend in steady_trends(fleet))


def _friction_words(fleet: Fleet) -> Iterator[str]:
    """Yield the range of the first of the main numbers, such as friction, of each direction."""
    shown = main_spreads(fleet)
    same = [spread for spread in shown if spread.quantity == shown[0].quantity]
    parts = []
    for spread in same:
        ends = alike([spread.quantity.scale * end for end in (spread.low, spread.high)])
        side = of_side(spread.direction).removeprefix(",")
        parts.append(f"{ends} {spread.quantity.unit}{side}")
    if parts:
        quantity = shown[0].quantity
        name = quantity.words.removesuffix(WORKING_SPEED) + _at_speed(fleet, quantity)
        of = f"{range_words(same[0].n)}{_largest_interval(fleet, same)}"
        yield f"{name} is {' and '.join(parts)} ({of})."


def _at_speed(fleet: Fleet, quantity: Quantity) -> str:
    speed = working_speed(fleet) if quantity.words.endswith(WORKING_SPEED) else ""
    return f" at {speed}" if speed else ""


def _largest_interval(fleet: Fleet, spreads: list[Spread]) -> str:
    """Write the largest half-width of the campaigns' own intervals; empty if one is unknown."""
    columns = [spread.quantity.column(spread.direction) for spread in spreads]
    numbers = [
        row.numbers[c] for row in fleet.rows if row.compared for c in columns if c in row.numbers
    ]
    halves = [(n.high - n.low) / 2 for n in numbers if n.low is not None and n.high is not None]
    if not halves or len(halves) < len(numbers):
        return ""
    quantity = spreads[0].quantity
    return f"; 95 % intervals up to ±{half_width(quantity.scale * max(halves))} {quantity.unit}"


def _changes(fleet: Fleet) -> list[tuple[str, dict[str, list[str]]]]:
    """Return the first campaigns of steps; for each quantity, its step of each direction."""
    steps: dict[str, dict[str, list[str]]] = {}
    for chart in fleet.charts:
        if chart.step is not None and chart.step.real:
            size = f"{step_size(chart.step, chart.quantity.scale)} {of_change(chart.quantity.unit)}"
            if chart.quantity.unit != "%" and chart.step.before:
                change = 100 * abs(chart.step.after / chart.step.before - 1)
                size += f" ({significant(change, 2)} %)"
            side = of_side(chart.direction).removeprefix(",")
            sizes = steps.setdefault(chart.step.name, {})
            sizes.setdefault(in_sentence(chart.quantity), []).append(f"{size}{side}")
    return list(steps.items())[:_NAMED]


def _change_words(changes: list[tuple[str, dict[str, list[str]]]]) -> Iterator[str]:
    """Yield the sizes of the steps of the first quantity, and what to check."""
    for at, sizes in changes:
        title, each = next(iter(sizes.items()))
        there = f" from {at} on" if len(changes) > 1 else ""
        yield f"The change of {title}{there} is {' and '.join(each)}: {CHECK_WHAT}."


def _drift_within(fleet: Fleet, changes: list[tuple[str, dict[str, list[str]]]]) -> Iterator[str]:
    """Yield that drifts within the campaigns may cause a step, where their data allow one."""
    count = dict(fleet.weak_checks).get("drift", 0)
    if changes and count:
        size = fleet.drift_possible
        most = "" if size is None else f" (up to {math.ceil(100 * size)} % in the worst)"
        which = f"{count} of {fleet.compared}" if count < fleet.compared else f"all {count}"
        yield f"A drift within campaigns may also cause this: the data of {which} allow one{most}."


def _conspicuous_words(fleet: Fleet) -> Iterator[str]:
    """Yield what else is to be looked into: drifts, single campaigns and outliers."""
    known = steady_trends(fleet)
    drifts = sum(trend.real for trend in known)
    if drifts:
        without = "without such a change " if stepped_numbers(fleet) else ""
        verb = plural(drifts, "drifts", "drift")
        yield f"{drifts} of {len(known)} numbers {without}{verb} significantly."
    beyond = in_order(name for chart in fleet.charts for name in chart.outside)
    if beyond:
        verb = plural(len(beyond), "is", "are")
        which = named(beyond if len(beyond) <= _NAMED + 1 else beyond[:_NAMED], len(beyond))
        some = any(chart.beyond > len(chart.outside) for chart in fleet.charts)
        count = f"{'At least ' * some}{len(beyond)} of {fleet.compared} campaigns"
        limit = f"a control limit{because_of_step(fleet)} ({which})"
        yield f"{count} {verb} beyond {limit}."
    if fleet.outliers:
        verb = "is an outlier" if fleet.outliers == 1 else "are outliers"
        yield f"{fleet.outliers} of {fleet.compared} campaigns {verb}."
    elif any(suspect.deviations for suspect in fleet.worst):
        yield "No campaign is an outlier."


def further_sentences(fleet: Fleet) -> Iterator[str]:
    """Yield the findings that neither the verdict nor the table of change points contains."""
    if not fleet.spreads:
        return
    yield from _drift_sentences(fleet)
    yield from _contrary_sentences(fleet)
    yield from wear_sentences(fleet)
    if any(suspect.deviations for suspect in fleet.worst):
        verb = "is an outlier" if fleet.outliers == 1 else "are outliers"
        of = campaign_names(fleet)
        names = [_outlier_words(each, of[each.path]) for each in fleet.worst[: fleet.outliers]]
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        some = f"{fleet.outliers} of {fleet.compared} campaigns {verb}: "
        some += f"{'; '.join(names[:_NAMED])}{more}."
        if fleet.outliers:
            yield some
        elif any(chart.outside for chart in fleet.charts) and not stepped_numbers(fleet):
            yield _LIMITS_ARE_NARROWER
    else:
        yield "Outliers are not identified: that takes at least 10 campaigns of the same kind."


def _drift_sentences(fleet: Fleet) -> Iterator[str]:
    """Yield the significant drifts of the numbers that have no step."""
    drifts = [_drift(spread, trend) for spread, trend in steady_spreads(fleet) if trend.real]
    if drifts:
        more = f"; and {len(drifts) - _NAMED} more" if len(drifts) > _NAMED else ""
        all_of_them = "; ".join(drifts[:_NAMED])
        yield f"Significant drift from the first to the last campaign: {all_of_them}{more}."
    elif any(spread.trend is not None for spread in fleet.spreads) and not stepped_numbers(fleet):
        yield "No drift is significant."


def _contrary_sentences(fleet: Fleet) -> Iterator[str]:
    """Yield where breakaway drifts significantly against a step of friction in its direction."""
    steps = {
        chart.direction: chart.step.after - chart.step.before
        for chart in fleet.charts
        if chart.quantity.name == "friction_n" and chart.step is not None and chart.step.real
    }
    for spread, trend in steady_spreads(fleet):
        step = steps.get(spread.direction, 0.0)
        if "Breakaway" in spread.quantity.words and trend.real and trend.change * step < 0:
            number = f"{spread.quantity.words}{of_side(spread.direction)}"
            falls, rises = ("falls", "rises") if trend.change < 0 else ("rises", "falls")
            p = significant(trend.p_holm, 2)
            advice = (
                " The fit extrapolates it: measure breakaway with runs of kind breakaway before "
                "relying on this."
                if spread.quantity.name == "breakaway_fit_n"
                else ""
            )
            change = f"{change_words(spread, trend)}\N{NO-BREAK SPACE}{spread.quantity.unit}"
            yield (
                f"{number}, {falls} while friction {rises}: by {change} (p = {p} among all "
                f"trends tested).{advice}"
            )


def stepped_numbers(fleet: Fleet) -> set[tuple[Quantity, Side]]:
    """Return the numbers whose control chart has a significant step."""
    return {(c.quantity, c.direction) for c in fleet.charts if c.step is not None and c.step.real}


def steady_trends(fleet: Fleet) -> list[Trend]:
    """Return the trends of the numbers that have no significant step."""
    return [trend for _, trend in steady_spreads(fleet)]


def steady_spreads(fleet: Fleet) -> list[tuple[Spread, Trend]]:
    """Return the numbers that have no significant step, which appears as a drift, with trends."""
    stepped = stepped_numbers(fleet)
    return [
        (spread, spread.trend)
        for spread in fleet.spreads
        if spread.trend is not None and (spread.quantity, spread.direction) not in stepped
    ]


def _outlier_words(suspect: Suspect, name: str) -> str:
    """Return a campaign with the number that deviates most, such as friction, extending +4.2 σ."""
    deviation = suspect.deviations[0]
    number = f"{in_sentence(deviation.quantity)}{of_side(deviation.direction)}"
    return f"{name} ({number} {signed(significant(deviation.z, 2))} σ)"


def decision_words(fleet: Fleet) -> str:
    """Write how many campaigns have each decision of acceptance."""
    return ", ".join(f"{count} {name}" for name, count in fleet.decisions)


def change_words(spread: Spread, trend: Trend) -> str:
    """Write the change of a number over the span with its 95 % interval."""
    scale = spread.quantity.scale
    return signed(with_ends(scale * trend.change, scale * trend.low, scale * trend.high))


def _drift(spread: Spread, trend: Trend) -> str:
    title = uncapital(spread.quantity.words)
    change = f"{change_words(spread, trend)} {of_change(spread.quantity.unit)}"
    return f"{title}{of_side(spread.direction)} {change}"
