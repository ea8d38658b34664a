"""A fleet in words and numbers: tables for the terminal and the page, and as JSON."""

import json
import math
from collections.abc import Iterator
from dataclasses import asdict

from hbench.records import (
    FEWEST_CAMPAIGNS,
    Fleet,
    FleetCampaign,
    FleetNumber,
    Spread,
    Suspect,
    Trend,
    WordTable,
)
from hbench.report.fleet.names import (
    folder_name,
    name_of,
    of_change,
    of_side,
    range_words,
    signed,
    without_condition,
)
from hbench.report.fleet.precision import (
    capability_notes,
    capability_table,
    change_sentences,
    chart_table,
    components_table,
    limit_sentences,
    limits_table,
    signal_table,
    step_size,
    step_table,
    wear_table,
)
from hbench.report.fleet.row import kind_difference
from hbench.report.json_documents.values import json_value
from hbench.report.render.numbers import (
    NONE,
    alike,
    half_width,
    number,
    short,
    significant,
    with_ends,
)
from hbench.report.render.symbols import capital
from hbench.report.render.terminal_table import table_lines

SCHEMA = "hbench.fleet/1"
_FEW = 5
_NAMED = 3  # outliers in the verdict
_MOST_ROWS = 50  # campaigns that are listed on a terminal


def fleet_text(fleet: Fleet) -> str:
    """Return the summary and the tables, for a terminal."""
    failed = f", {fleet.failed} failed" if fleet.failed else ""
    lines = [f"{fleet.campaigns} campaigns: {fleet.campaigns - fleet.failed} analyzed{failed}"]
    lines += [f"  {count} failed: {reason}" for reason, count in fleet.reasons]
    if len(fleet.protocols) > 1:
        lines.append(
            f"{fleet.compared} of the most frequent kind are evaluated: {fleet.protocols[0][0]}"
        )
    if fleet.other_speeds:
        lines.append(f"{fleet.other_speeds} of them at other speeds are left out")
    tables = (
        *([campaign_table(fleet)] if len(fleet.rows) <= _MOST_ROWS else []),
        spread_table(fleet),
        trend_table(fleet),
        worst_table(fleet, _FEW),
        limits_table(fleet),
        components_table(fleet),
        capability_table(fleet),
        chart_table(fleet),
        signal_table(fleet),
        step_table(fleet),
        wear_table(fleet),
    )
    for table in tables:
        if table.rows:
            lines += ["", *table_lines(table)]
    if fleet.decisions:
        lines += ["", f"decisions of hbench accept: {decision_words(fleet)}"]
    notes = [f"plan: {note}" for note in fleet.plan_notes]
    lines += ["", *notes, *capability_notes(fleet), *limit_sentences(fleet)]
    lines += [*finding_sentences(fleet), fleet_verdict(fleet)]
    text = "\n".join(lines).replace("±", "+-").replace("²", "^2").replace("σ", "s.d.")
    text = text.replace("×", "x").replace("λ", "lambda")
    return text.replace("−", "-").replace("–", "-").replace("…", "...")


def decision_words(fleet: Fleet) -> str:
    """Write how many campaigns have each decision of acceptance."""
    return ", ".join(f"{count} {name}" for name, count in fleet.decisions)


def fleet_json(fleet: Fleet) -> str:
    """Return the text of ``fleet.json``."""
    document = {"schema": SCHEMA, **asdict(fleet)}
    for shown, spread in zip(document["spreads"], fleet.spreads, strict=True):
        if spread.trend is not None:
            shown["trend"]["real"] = spread.trend.real
    for shown, study in zip(document["precision"], fleet.precision, strict=True):
        shown["limit_r"], shown["limit_R"] = study.limits
        for name in ("critical_difference", "share_of_tolerance", "distinct_categories"):
            shown[name] = getattr(study, name)
    for shown, chart in zip(document["charts"], fleet.charts, strict=True):
        shown["limits"] = chart.limits
        if chart.step is not None:
            shown["step"]["real"] = chart.step.real
    for shown, wear in zip(document["wear"], fleet.wear, strict=True):
        shown["real"] = wear.real
    for shown, suspect in zip(document["worst"], fleet.worst, strict=True):
        shown["outlier"] = suspect.deviations[0].outlier
    return json.dumps(json_value(document), indent=1, allow_nan=False) + "\n"


def fleet_verdict(fleet: Fleet) -> str:
    """Return decisions, failures, friction and what is conspicuous, in a few short sentences."""
    sentences = [f"Decisions: {decision_words(fleet)}."] if fleet.decisions else []
    if fleet.decisions == (("PASS", fleet.campaigns),):
        sentences = [f"All {fleet.campaigns} campaigns have the decision PASS."]
    if fleet.failed:
        sentences.append(f"{fleet.failed} of {fleet.campaigns} campaigns could not be analyzed.")
    analyzed = fleet.campaigns - fleet.failed
    poor = dict(fleet.qualities).get("poor", 0)
    if fleet.incomplete:
        verb = "is" if fleet.incomplete == 1 else "are"
        sentences.append(f"{fleet.incomplete} of {analyzed} analyzed campaigns {verb} incomplete.")
    if poor:
        verb = "has" if poor == 1 else "have"
        sentences.append(f"{poor} of {analyzed} analyzed campaigns {verb} poor data.")
    if not fleet.spreads:
        sentences.append("No campaign has a number to compare.")
        return " ".join(sentences)
    return " ".join([*sentences, *_friction_words(fleet), *_conspicuous_words(fleet)])


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
        name = without_condition(shown[0].quantity)
        of = f"{range_words(same[0].n)}{_largest_interval(fleet, same)}"
        yield f"{name} is {' and '.join(parts)} ({of})."


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


def _conspicuous_words(fleet: Fleet) -> Iterator[str]:
    """Yield what is to be looked into: steps with their first size, outliers and drifts."""
    steps: dict[str, dict[str, str]] = {}
    stepped = set()  # a step appears as a drift too
    for chart in fleet.charts:
        if chart.step is not None and chart.step.real:
            stepped.add((chart.quantity, chart.direction))
            title = without_condition(chart.quantity)
            title = f"{title[:1].lower()}{title[1:]}"
            size = f"{step_size(chart.step, chart.quantity.scale)} {of_change(chart.quantity.unit)}"
            sizes = steps.setdefault(chart.step.name, {})
            sizes.setdefault(title, f"{title}{of_side(chart.direction)}, by {size}")
    for at, sizes in list(steps.items())[:_NAMED]:
        first = next(iter(sizes.values()))
        yield capital(f"{' and '.join(sizes)} changed from {at} on ({first}).")
    if fleet.outliers:
        verb = "is an outlier" if fleet.outliers == 1 else "are outliers"
        yield f"{fleet.outliers} of {fleet.compared} campaigns {verb}."
    elif any(suspect.deviations for suspect in fleet.worst):
        yield "No campaign is an outlier."
    known = [spread for spread in fleet.spreads if spread.trend is not None]
    known = [spread for spread in known if (spread.quantity, spread.direction) not in stepped]
    drifts = sum(spread.trend is not None and spread.trend.real for spread in known)
    if drifts:
        others = "other " if stepped else ""
        verb = "drifts" if drifts == 1 else "drift"
        yield f"{drifts} of {len(known)} {others}numbers {verb} significantly."


def finding_sentences(fleet: Fleet) -> Iterator[str]:
    """Yield steps, wear, outliers and drifts with their numbers."""
    if not fleet.spreads:
        return
    yield from change_sentences(fleet)
    if any(suspect.deviations for suspect in fleet.worst):
        verb = "is an outlier" if fleet.outliers == 1 else "are outliers"
        names = [_outlier_words(suspect) for suspect in fleet.worst[: fleet.outliers]]
        more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        some = f"{fleet.outliers} of {fleet.compared} campaigns {verb}: "
        some += f"{'; '.join(names[:_NAMED])}{more}."
        yield some if fleet.outliers else "No campaign is an outlier."
    else:
        yield "Outliers are not identified: that takes at least 10 campaigns of the same kind."
    drifts = [
        _drift(spread, spread.trend)
        for spread in fleet.spreads
        if spread.trend is not None and spread.trend.real
    ]
    if drifts:
        more = f"; and {len(drifts) - _NAMED} more" if len(drifts) > _NAMED else ""
        yield f"Significant drift: {'; '.join(drifts[:_NAMED])}{more}.{_step_instead(fleet)}"
    elif any(spread.trend is not None for spread in fleet.spreads):
        yield "No drift is significant."


def _step_instead(fleet: Fleet) -> str:
    """Remark that the drifting numbers also have a step, if all of them do."""
    steps = {(c.quantity, c.direction) for c in fleet.charts if c.step is not None and c.step.real}
    drifts = {(s.quantity, s.direction) for s in fleet.spreads if s.trend and s.trend.real}
    return " A step, as above, appears as a drift too." if drifts <= steps else ""


def _outlier_words(suspect: Suspect) -> str:
    """Return a campaign with the number that deviates most, such as friction, extending +4.2 σ."""
    deviation = suspect.deviations[0]
    title = without_condition(deviation.quantity)
    number = f"{title[:1].lower()}{title[1:]}{of_side(deviation.direction)}"
    return f"{folder_name(suspect.path)} ({number} {signed(significant(deviation.z, 2))} σ)"


ROW_WORDS = ("Campaign", "Cylinder", "Date", "Label", "Decision")


def main_spreads(fleet: Fleet) -> list[Spread]:
    """Return the numbers to show first: those of friction bands, or else of each direction."""
    listed = [spread for spread in fleet.spreads if spread.quantity.listed]
    return [spread for spread in listed if spread.direction is None] or listed


def campaign_table(fleet: Fleet) -> WordTable:
    """Return a row a campaign of a small fleet: label, speed, and the main numbers."""
    shown = main_spreads(fleet)
    rows = []
    for campaign in fleet.rows:
        speed = "" if campaign.v_m_s is None else short(1e3 * campaign.v_m_s)
        numbers = (campaign.numbers.get(s.quantity.column(s.direction)) for s in shown)
        cells = [_with_ends(n, s.quantity.scale) for n, s in zip(numbers, shown, strict=True)]
        remark = "; ".join(_remarks(campaign, fleet))
        name = folder_name(campaign.path)
        day = "" if campaign.started is None else f"{campaign.started:%Y-%m-%d}"
        about = (name, campaign.specimen, day, campaign.label, campaign.decision)
        rows.append((*about, speed, *cells, remark))
    head = (*ROW_WORDS, "Speed (mm/s)", *map(name_of, shown), "Remark")
    kept = [i for i in range(len(head)) if i == 0 or any(row[i] for row in rows)]
    return WordTable(
        "Campaigns",
        tuple(head[i] for i in kept),
        tuple(tuple(row[i] for i in kept) for row in rows),
    )


def _remarks(campaign: FleetCampaign, fleet: Fleet) -> Iterator[str]:
    if not campaign.compared:
        evaluated = fleet.protocols[0][0] if fleet.protocols else ""
        other = campaign.protocol and campaign.protocol != evaluated
        why = kind_difference(campaign.protocol, evaluated) if other else "other speed"
        yield f"not compared: {why}"
    if campaign.quality == "poor":
        yield "data: poor"
    if campaign.missing:
        yield f"incomplete: {campaign.missing}"


def _with_ends(number: FleetNumber | None, scale: float) -> str:
    if number is None:
        return NONE
    if number.low is None or number.high is None:
        return significant(scale * number.value, 3)
    value, low, high = (scale * each for each in (number.value, number.low, number.high))
    shown, _, interval = with_ends(value, low, high).partition(" ")
    if value and (high - low) / 2 >= 10 ** math.floor(math.log10(abs(value))):
        shown = significant(value, 3)  # rows differ by less than what their intervals share
    return f"{shown} {interval}"


def spread_table(fleet: Fleet) -> WordTable:
    """Return the middle and the spread of each number."""
    rows = []
    several = (spread for spread in fleet.spreads if spread.n > 1 or fleet.compared == 1)
    for spread in several:
        scale = spread.quantity.scale
        between = "not significant" if spread.n > 1 else NONE
        if spread.between > 0:
            between = significant(scale * spread.between, 2)
        rows.append(
            (
                name_of(spread),
                str(spread.n),
                _resolved(spread, spread.median),
                f"{_resolved(spread, spread.low)} to {_resolved(spread, spread.high)}",
                between,
                NONE if spread.se_trials is None else significant(scale * spread.se_trials, 2),
            )
        )
    few = all(spread.n < FEWEST_CAMPAIGNS for spread in fleet.spreads)
    ends = "Smallest to largest" if few else "5 to 95 %"
    head = ("Number", "Campaigns", "Median", ends, "σ between campaigns", "σ of own trials")
    return WordTable("Distributions", head, tuple(rows))


def _resolved(spread: Spread, value: float) -> str:
    """Write a value to the first significant digit of the trials' standard error, or the spread."""
    scale, error = spread.quantity.scale, spread.se_trials or spread.between
    if not error > 0:
        return significant(scale * value, 4)
    return number(scale * value, max(0, -math.floor(math.log10(scale * error))))


def trend_table(fleet: Fleet) -> WordTable:
    """Return the trend of each number over the whole span, and its slope, with 95 % intervals."""
    rows = []
    span = float(max(fleet.compared - 1, 1))
    if fleet.by_date and fleet.first is not None and fleet.last is not None:
        span = (fleet.last - fleet.first).total_seconds() / 86_400
    for spread in fleet.spreads:
        if spread.trend is not None:
            p = spread.trend.p_holm
            rows.append(
                (
                    name_of(spread),
                    _change(spread, spread.trend),
                    _slope(spread, spread.trend, span),
                    "< 0.0001" if p < 1e-4 else significant(p, 2),
                    "drifts" if spread.trend.real else "not significant",
                )
            )
    unit = "a day" if fleet.by_date else "a campaign"
    head = ("Number", "Change over the span", f"Slope {unit}", "p (Holm)", "Verdict")
    return WordTable("Drifts", head, tuple(rows))


def worst_table(fleet: Fleet, most: int) -> WordTable:
    """Return the campaigns that deviate most, a row each."""
    rows = tuple((shown.path, *cells(shown)) for shown in fleet.worst[:most])
    return WordTable("Largest deviations", ("Campaign", *WORST_HEAD), rows)


WORST_HEAD = ("Number", "Value", "Usual", "Deviation (σ)", "p", "Verdict")


def cells(shown: Suspect) -> tuple[str, ...]:
    """Return the worst number of a campaign, in the columns ``WORST_HEAD``."""
    deviation = shown.deviations[0]
    scale, p = deviation.quantity.scale, deviation.p_bonferroni
    return (
        name_of(deviation),
        significant(scale * deviation.value, 4),
        significant(scale * deviation.median, 4),
        signed(significant(deviation.z, 2)),
        "< 0.0001" if p < 1e-4 else significant(p, 2),
        "outlier" if deviation.outlier else "not significant",
    )


def others(shown: Suspect) -> Iterator[str]:
    """Yield the further numbers in which a campaign is an outlier."""
    for deviation in shown.deviations[1:]:
        if deviation.outlier:
            yield f"{name_of(deviation)} {signed(significant(deviation.z, 2))} σ"


def _change(spread: Spread, trend: Trend) -> str:
    scale = spread.quantity.scale
    return signed(with_ends(scale * trend.change, scale * trend.low, scale * trend.high))


def _slope(spread: Spread, trend: Trend, span: float) -> str:
    scale = spread.quantity.scale / span
    return signed(with_ends(scale * trend.change, scale * trend.low, scale * trend.high))


def _drift(spread: Spread, trend: Trend) -> str:
    title = f"{spread.quantity.words[0].lower()}{spread.quantity.words[1:]}"
    change = f"{_change(spread, trend)} {of_change(spread.quantity.unit)}"
    return f"{title}{of_side(spread.direction)}, by {change} over the span"
