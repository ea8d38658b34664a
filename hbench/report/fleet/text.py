"""Tables of a fleet for the terminal and the page, and the fleet as JSON."""

import math
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple

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
    campaign_names,
    main_spreads,
    name_of,
    signed,
    working_speed,
)
from hbench.report.fleet.row import kind_difference
from hbench.report.fleet.verdict import (
    change_words,
    steady_spreads,
)
from hbench.report.json_documents.values import json_text, json_value
from hbench.report.render.numbers import (
    NONE,
    number,
    short,
    significant,
    with_ends,
)
from hbench.report.render.word_tables import with_columns

SCHEMA = "hbench.fleet/1"


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
    return json_text(json_value(document))


_SPEED, _ALIKE = "Speed (mm/s)", 1.1
ROW_WORDS = ("Campaign", "Cylinder", "Date", "Label", "Decision")


def campaign_table(fleet: Fleet) -> WordTable:
    """Return a row a campaign of a small fleet: label, speed, and the main numbers.

    Intervals that hardly differ from row to row are those of ``shared_intervals``.
    """
    columns, rows = list(_columns(fleet)), []
    folders = campaign_names(fleet)
    for at, campaign in enumerate(fleet.rows):
        speed = "" if campaign.v_m_s is None else short(1e3 * campaign.v_m_s)
        numbers = [column.cells[at] for column in columns]
        remark = "; ".join(_remarks(campaign, fleet))
        day = "" if campaign.started is None else f"{campaign.started:%Y-%m-%d}"
        about = (folders[campaign.path], campaign.specimen, day, campaign.label, campaign.decision)
        rows.append((*about, speed, *numbers, remark))
    head = (*ROW_WORDS, _SPEED, *(column.head for column in columns), "Remark")
    kept = [i for i in range(len(head)) if i == 0 or any(row[i] for row in rows)]
    if working_speed(fleet) and len(rows) > 1:
        kept = [i for i in kept if head[i] != _SPEED]
    if all(row[1] == row[0] for row in rows):  # folders have the cylinders' names
        kept = [i for i in kept if i != 1]
    return with_columns(WordTable("Campaigns", head, tuple(rows)), kept)


def shared_intervals(fleet: Fleet) -> str:
    """Return the intervals that the table of campaigns leaves out, and the speed of its values."""
    stated = []
    for column in _columns(fleet):
        name, _, unit = column.head.rpartition(" (")
        if column.shared:
            stated.append(f"{name.lower()} {column.shared} {unit.rstrip(')')}")
    speed = working_speed(fleet)
    at = f"Values at {speed}." if speed and len(fleet.rows) > 1 else ""
    intervals = f"95 % intervals: {'; '.join(stated)}." if stated else ""
    return " ".join(filter(None, (at, intervals)))


class _Column(NamedTuple):
    """A main number of all campaigns."""

    head: str
    cells: list[str]  # by campaign
    shared: str  # interval of all cells, which they leave out; empty where each has its own


def _columns(fleet: Fleet) -> Iterator[_Column]:
    for spread in main_spreads(fleet):
        name, scale = spread.quantity.column(spread.direction), spread.quantity.scale
        numbers = [campaign.numbers.get(name) for campaign in fleet.rows]
        full = [_with_ends(each, scale, rounded=False) for each in numbers]
        if shared := _shared(full):
            cells = [cell.partition(" ")[0] for cell in full]
        else:
            cells = [_with_ends(each, scale, rounded=True) for each in numbers]
        yield _Column(name_of(spread), cells, shared)


def _shared(cells: list[str]) -> str:
    """Return the interval that several cells have, within a tenth; empty where they differ."""
    ends = [cell.partition(" ")[2] for cell in cells]
    if len(cells) < 2 or not all(end.startswith("± ") for end in ends):
        return ""
    shown = sorted({end.removeprefix("± ") for end in ends}, key=float)
    if float(shown[-1]) > _ALIKE * float(shown[0]):
        return ""
    return f"±{'–'.join(dict.fromkeys((shown[0], shown[-1])))}"


def _remarks(campaign: FleetCampaign, fleet: Fleet) -> Iterator[str]:
    if campaign.copy_of:
        yield f"not compared: a copy, its logs are those of {Path(campaign.copy_of).name}"
    elif not campaign.compared:
        evaluated = fleet.protocols[0][0] if fleet.protocols else ""
        other = campaign.protocol and campaign.protocol != evaluated
        why = kind_difference(campaign.protocol, evaluated) if other else "other speed"
        yield f"not compared: {why}"
    if campaign.quality == "poor":
        yield "data: poor"
    if campaign.missing:
        yield f"incomplete: {campaign.missing}"


def _with_ends(number: FleetNumber | None, scale: float, rounded: bool) -> str:
    """Write a number with its interval, ``rounded`` by the interval.

    Else a number whose interval is large has four digits, since rows may differ by less than what
    their intervals share.
    """
    if number is None:
        return NONE
    if number.low is None or number.high is None:
        return significant(scale * number.value, 3)
    value, low, high = (scale * each for each in (number.value, number.low, number.high))
    shown, _, interval = with_ends(value, low, high).partition(" ")
    coarse = value and (high - low) / 2 >= 10 ** (math.floor(math.log10(abs(value))) - 2)
    if coarse and not rounded:
        shown = significant(value, 4)
    return f"{shown} {interval}"


def spread_table(fleet: Fleet) -> WordTable:
    """Return the middle and the spread of each number."""
    rows = []
    several = (spread for spread in fleet.spreads if spread.n > 1 or fleet.compared == 1)
    for spread in several:
        scale = spread.quantity.scale
        rows.append(
            (
                name_of(spread),
                str(spread.n),
                resolved(spread, spread.median),
                f"{resolved(spread, spread.low)} to {resolved(spread, spread.high)}",
                _between(spread),
                NONE if spread.se_trials is None else significant(scale * spread.se_trials, 2),
            )
        )
    few = [spread.n < FEWEST_CAMPAIGNS for spread in fleet.spreads]
    ends = "Smallest to largest" if all(few) else "5 to 95 %"
    if any(few) and not all(few):
        ends += f", or all of fewer than {FEWEST_CAMPAIGNS}"
    between = "σ between campaigns, without steps and drifts (95 %)"
    head = ("Quantity", "Campaigns", "Median", ends, between, "σ by the trials")
    kept = [i for i in range(len(head)) if head[i] != between or not all(few)]
    return with_columns(WordTable("Distributions", head, tuple(rows)), kept)


def _between(spread: Spread) -> str:
    """Write the standard deviation between campaigns and its interval, which few do not have."""
    if spread.n < FEWEST_CAMPAIGNS:
        return NONE
    ends = spread.between, spread.between_low, spread.between_high
    between, low, high = (spread.quantity.scale * value for value in ends)
    if not between > 0:
        return f"not resolved, up to {significant(high, 2)}"
    return with_ends(between, low, high)


def resolved(spread: Spread, value: float) -> str:
    """Write a value to the first significant digit of the trials' standard error, or the spread."""
    scale, error = spread.quantity.scale, spread.se_trials or spread.between
    if not error > 0:
        return significant(scale * value, 4)
    return number(scale * value, max(0, -math.floor(math.log10(scale * error))))


def trend_table(fleet: Fleet) -> WordTable:
    """Return trends over the whole span, and their slopes, with 95 % intervals.

    A number whose mean has a step has no row: the table of change points contains it. Campaigns of
    less than a day have no slope a day.
    """
    rows = []
    span = float(max(fleet.compared - 1, 1))
    if fleet.by_date and fleet.first is not None and fleet.last is not None:
        span = (fleet.last - fleet.first).total_seconds() / 86_400
    for spread, trend in steady_spreads(fleet):
        p = trend.p_holm
        rows.append(
            (
                name_of(spread),
                change_words(spread, trend),
                _slope(spread, trend, span),
                "< 0.0001" if p < 1e-4 else significant(p, 2),
                "drifts" if trend.real else "not significant",
            )
        )
    unit = "a day" if fleet.by_date else "a campaign"
    head = ("Quantity", "Change over the span", f"Slope {unit}", "p (Holm)", "Verdict")
    kept = [i for i in range(len(head)) if i != 2 or span >= 1]
    return with_columns(WordTable("Drifts", head, tuple(rows)), kept)


def worst_table(fleet: Fleet, most: int) -> WordTable:
    """Return the campaigns that deviate most, a row each."""
    names = campaign_names(fleet)
    rows = tuple((names[shown.path], *cells(shown)) for shown in fleet.worst[:most])
    return WordTable("Largest deviations", ("Campaign", *WORST_HEAD), rows)


WORST_HEAD = (
    "Quantity",
    "Value",
    "Expected",
    "Deviation (σ)",
    "Outlier beyond (σ)",
    "p",
    "Verdict",
)


def cells(shown: Suspect) -> tuple[str, ...]:
    """Return the worst number of a campaign, in the columns ``WORST_HEAD``."""
    deviation = shown.deviations[0]
    scale, p = deviation.quantity.scale, deviation.p_bonferroni
    return (
        name_of(deviation),
        significant(scale * deviation.value, 4),
        significant(scale * deviation.median, 4),
        signed(significant(deviation.z, 2)),
        significant(deviation.limit, 2),
        "< 0.0001" if p < 1e-4 else significant(p, 2),
        "outlier" if deviation.outlier else "not significant",
    )


def others(shown: Suspect) -> Iterator[str]:
    """Yield the further numbers in which a campaign is an outlier."""
    for deviation in shown.deviations[1:]:
        if deviation.outlier:
            yield f"{name_of(deviation)} {signed(significant(deviation.z, 2))} σ"


def _slope(spread: Spread, trend: Trend, span: float) -> str:
    scale = spread.quantity.scale / span
    return signed(with_ends(scale * trend.change, scale * trend.low, scale * trend.high))
