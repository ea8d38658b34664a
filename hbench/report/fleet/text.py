"""A fleet in words and numbers: tables for the terminal and the page, and as JSON."""

import json
from collections.abc import Iterator
from dataclasses import asdict

from hbench.records import Deviation, Fleet, Spread, Suspect, WordTable
from hbench.report.json_documents.values import plain
from hbench.report.render.numbers import NONE, significant, with_ends
from hbench.report.render.style import TITLES
from hbench.report.render.terminal_table import aligned

SCHEMA = "hbench.fleet/1"
_FEW = 5


def fleet_text(found: Fleet) -> str:
    """Return what a terminal shows."""
    failed = f", {found.failed} failed" if found.failed else ""
    parts = [f"{found.campaigns} campaigns: {found.campaigns - found.failed} analyzed{failed}"]
    parts += [f"  {count} failed: {words}" for words, count in found.reasons]
    if len(found.protocols) > 1:
        parts.append(
            f"{found.judged} of the most frequent kind are judged: {found.protocols[0][0]}"
        )
    for table in (spread_table(found), trend_table(found), worst_table(found, _FEW)):
        if table.rows:
            parts += ["", *aligned(table)]
    parts += ["", verdict(found)]
    text = "\n".join(parts).replace("±", "+-").replace("²", "^2").replace("σ", "s.d.")
    return text.replace("−", "-").replace("–", "-").replace("…", "...")


def fleet_json(found: Fleet) -> str:
    """Return the text of ``fleet.json``."""
    document = {"schema": SCHEMA, **asdict(found)}
    for shown, one in zip(document["spreads"], found.spreads, strict=True):
        if one.trend is not None:
            shown["trend"]["real"] = one.trend.real
    for shown, suspect in zip(document["worst"], found.worst, strict=True):
        shown["outlier"] = suspect.deviations[0].outlier
    return json.dumps(plain(document), indent=1, allow_nan=False) + "\n"


def verdict(found: Fleet) -> str:
    """Return in a few sentences what matters."""
    words = []
    if found.failed:
        words.append(f"{found.failed} of {found.campaigns} campaigns could not be analyzed.")
    if not found.spreads:
        words.append("No campaign has a number to compare.")
        return " ".join(words)
    if any(suspect.deviations for suspect in found.worst):
        stand = "stands" if found.outliers == 1 else "stand"
        stand = f"{found.outliers} of {found.judged} {stand} out from the others."
        words.append(stand if found.outliers else "No campaign stands out from the others.")
    else:
        words.append("Too few campaigns of the same kind to tell which stand out.")
    drifts = [one for one in found.spreads if one.trend is not None and one.trend.real]
    if drifts:
        words.append(f"Drifts: {'; '.join(map(_drift, drifts))}.")
    elif any(one.trend is not None for one in found.spreads):
        words.append("No drift is shown.")
    return " ".join(words)


def spread_table(found: Fleet) -> WordTable:
    """Return the middle and the spread of each number."""
    rows = []
    for one in found.spreads:
        scale = one.quantity.scale
        between = significant(scale * one.between, 2) if one.between > 0 else "not shown"
        rows.append(
            (
                name_of(one),
                str(one.n),
                significant(scale * one.median, 4),
                f"{significant(scale * one.low, 4)} to {significant(scale * one.high, 4)}",
                between,
                NONE if one.own is None else significant(scale * one.own, 2),
            )
        )
    head = ("Number", "Campaigns", "Median", "5 to 95 %", "σ between cylinders", "σ of own trials")
    return WordTable("Distributions", head, tuple(rows))


def trend_table(found: Fleet) -> WordTable:
    """Return the trend of each number over the whole span."""
    rows = []
    for one in found.spreads:
        if one.trend is not None:
            p = one.trend.p_holm
            rows.append(
                (
                    name_of(one),
                    _change(one),
                    "< 0.0001" if p < 1e-4 else significant(p, 2),
                    "drifts" if one.trend.real else "not shown",
                )
            )
    head = ("Number", "Change over the span", "p (Holm)", "Verdict")
    return WordTable("Drifts", head, tuple(rows))


def worst_table(found: Fleet, most: int) -> WordTable:
    """Return the campaigns that deviate most, a row each."""
    rows = tuple((shown.path, *cells(shown)) for shown in found.worst[:most])
    return WordTable("Worst campaigns", ("Campaign", *WORST_HEAD), rows)


WORST_HEAD = ("Number", "Value", "Usual", "Deviation (σ)", "p", "Verdict")


def cells(shown: Suspect) -> tuple[str, ...]:
    """Return the worst number of a campaign, in the columns ``WORST_HEAD``."""
    one = shown.deviations[0]
    scale, p = one.quantity.scale, one.p_bonferroni
    return (
        name_of(one),
        significant(scale * one.value, 4),
        significant(scale * one.median, 4),
        _signed(significant(one.z, 2)),
        "< 0.0001" if p < 1e-4 else significant(p, 2),
        "outlier" if one.outlier else "not told from others",
    )


def others(shown: Suspect) -> Iterator[str]:
    """Yield the further numbers in which a campaign is an outlier."""
    for one in shown.deviations[1:]:
        if one.outlier:
            yield f"{name_of(one)} {_signed(significant(one.z, 2))} σ"


def name_of(one: Spread | Deviation) -> str:
    """Return the number's words with direction and unit."""
    words = one.quantity.words.removesuffix(" at the working speed")
    return f"{words}, {TITLES[one.direction].lower()} ({one.quantity.unit})"


def _change(one: Spread) -> str:
    trend, scale = one.trend, one.quantity.scale
    return _signed(with_ends(scale * trend.change, scale * trend.low, scale * trend.high))


def _drift(one: Spread) -> str:
    words = f"{one.quantity.words[0].lower()}{one.quantity.words[1:]}"
    return f"{words}, {TITLES[one.direction].lower()}: {_change(one)} {one.quantity.unit}"


def _signed(text: str) -> str:
    return text if text.startswith(("−", "0", NONE)) and not text.startswith("0.") else f"+{text}"
