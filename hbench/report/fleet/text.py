"""A fleet in words and numbers: tables for the terminal and the page, and as JSON."""

import json
from collections.abc import Iterator
from dataclasses import asdict

from hbench.records import Deviation, Fleet, Spread, Suspect, Trend, WordTable
from hbench.report.json_documents.values import json_value
from hbench.report.render.numbers import NONE, significant, with_ends
from hbench.report.render.style import TITLES
from hbench.report.render.terminal_table import table_lines

SCHEMA = "hbench.fleet/1"
_FEW = 5


def fleet_text(fleet: Fleet) -> str:
    """Return the summary and the tables, for a terminal."""
    failed = f", {fleet.failed} failed" if fleet.failed else ""
    lines = [f"{fleet.campaigns} campaigns: {fleet.campaigns - fleet.failed} analyzed{failed}"]
    lines += [f"  {count} failed: {reason}" for reason, count in fleet.reasons]
    if len(fleet.protocols) > 1:
        lines.append(
            f"{fleet.compared} of the most frequent kind are evaluated: {fleet.protocols[0][0]}"
        )
    for table in (spread_table(fleet), trend_table(fleet), worst_table(fleet, _FEW)):
        if table.rows:
            lines += ["", *table_lines(table)]
    lines += ["", fleet_verdict(fleet)]
    text = "\n".join(lines).replace("±", "+-").replace("²", "^2").replace("σ", "s.d.")
    return text.replace("−", "-").replace("–", "-").replace("…", "...")


def fleet_json(fleet: Fleet) -> str:
    """Return the text of ``fleet.json``."""
    document = {"schema": SCHEMA, **asdict(fleet)}
    for shown, spread in zip(document["spreads"], fleet.spreads, strict=True):
        if spread.trend is not None:
            shown["trend"]["real"] = spread.trend.real
    for shown, suspect in zip(document["worst"], fleet.worst, strict=True):
        shown["outlier"] = suspect.deviations[0].outlier
    return json.dumps(json_value(document), indent=1, allow_nan=False) + "\n"


def fleet_verdict(fleet: Fleet) -> str:
    """Return failures, outliers and drifts in a few sentences."""
    sentences = []
    if fleet.failed:
        sentences.append(f"{fleet.failed} of {fleet.campaigns} campaigns could not be analyzed.")
    if not fleet.spreads:
        sentences.append("No campaign has a number to compare.")
        return " ".join(sentences)
    if any(suspect.deviations for suspect in fleet.worst):
        verb = "is an outlier" if fleet.outliers == 1 else "are outliers"
        some = f"{fleet.outliers} of {fleet.compared} campaigns {verb}."
        sentences.append(some if fleet.outliers else "No campaign is an outlier.")
    else:
        sentences.append("Too few campaigns of the same kind to identify outliers.")
    drifts = [
        _drift(spread, spread.trend)
        for spread in fleet.spreads
        if spread.trend is not None and spread.trend.real
    ]
    if drifts:
        sentences.append(f"Drifts: {'; '.join(drifts)}.")
    elif any(spread.trend is not None for spread in fleet.spreads):
        sentences.append("No drift is significant.")
    return " ".join(sentences)


def spread_table(fleet: Fleet) -> WordTable:
    """Return the middle and the spread of each number."""
    rows = []
    for spread in fleet.spreads:
        scale = spread.quantity.scale
        between = (
            significant(scale * spread.between, 2) if spread.between > 0 else "not significant"
        )
        rows.append(
            (
                name_of(spread),
                str(spread.n),
                significant(scale * spread.median, 4),
                f"{significant(scale * spread.low, 4)} to {significant(scale * spread.high, 4)}",
                between,
                NONE if spread.se_trials is None else significant(scale * spread.se_trials, 2),
            )
        )
    head = ("Number", "Campaigns", "Median", "5 to 95 %", "σ between cylinders", "σ of own trials")
    return WordTable("Distributions", head, tuple(rows))


def trend_table(fleet: Fleet) -> WordTable:
    """Return the trend of each number over the whole span."""
    rows = []
    for spread in fleet.spreads:
        if spread.trend is not None:
            p = spread.trend.p_holm
            rows.append(
                (
                    name_of(spread),
                    _change(spread, spread.trend),
                    "< 0.0001" if p < 1e-4 else significant(p, 2),
                    "drifts" if spread.trend.real else "not significant",
                )
            )
    head = ("Number", "Change over the span", "p (Holm)", "Verdict")
    return WordTable("Drifts", head, tuple(rows))


def worst_table(fleet: Fleet, most: int) -> WordTable:
    """Return the campaigns that deviate most, a row each."""
    rows = tuple((shown.path, *cells(shown)) for shown in fleet.worst[:most])
    return WordTable("Worst campaigns", ("Campaign", *WORST_HEAD), rows)


WORST_HEAD = ("Number", "Value", "Usual", "Deviation (σ)", "p", "Verdict")


def cells(shown: Suspect) -> tuple[str, ...]:
    """Return the worst number of a campaign, in the columns ``WORST_HEAD``."""
    deviation = shown.deviations[0]
    scale, p = deviation.quantity.scale, deviation.p_bonferroni
    return (
        name_of(deviation),
        significant(scale * deviation.value, 4),
        significant(scale * deviation.median, 4),
        _signed(significant(deviation.z, 2)),
        "< 0.0001" if p < 1e-4 else significant(p, 2),
        "outlier" if deviation.outlier else "not significant",
    )


def others(shown: Suspect) -> Iterator[str]:
    """Yield the further numbers in which a campaign is an outlier."""
    for deviation in shown.deviations[1:]:
        if deviation.outlier:
            yield f"{name_of(deviation)} {_signed(significant(deviation.z, 2))} σ"


def name_of(number: Spread | Deviation) -> str:
    """Return the number's words with direction and unit."""
    title = number.quantity.words.removesuffix(" at the working speed")
    return f"{title}, {TITLES[number.direction].lower()} ({number.quantity.unit})"


def _change(spread: Spread, trend: Trend) -> str:
    scale = spread.quantity.scale
    return _signed(with_ends(scale * trend.change, scale * trend.low, scale * trend.high))


def _drift(spread: Spread, trend: Trend) -> str:
    title = f"{spread.quantity.words[0].lower()}{spread.quantity.words[1:]}"
    change = f"{_change(spread, trend)} {spread.quantity.unit}"
    return f"{title}, {TITLES[spread.direction].lower()}: {change}"


def _signed(text: str) -> str:
    return text if text.startswith(("−", "0", NONE)) and not text.startswith("0.") else f"+{text}"
