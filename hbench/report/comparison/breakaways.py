"""Breakaway of a comparison: table, JSON and verdict."""

from collections.abc import Sequence
from typing import Any

from hbench.records import (
    DIRECTION_WORDS,
    BreakawayDifference,
    CampaignDifferences,
    Difference,
    WordTable,
)
from hbench.report.campaign.series_words import load_words
from hbench.report.comparison.cells import cells, difference_table, numbers
from hbench.report.comparison.difference_words import by_chance, sizes, widest, with_uncertainty
from hbench.report.render.numbers import percent_span, short
from hbench.report.render.word_tables import with_columns


def breakaway_verdict(differences: CampaignDifferences) -> str:
    """Return the significant differences of breakaway; empty without breakaway."""
    every = [each.breakaway_n for each in differences.breakaways]
    if not every:
        return ""
    real = [each for each in every if each.real]
    if not real:
        largest = max(every, key=lambda each: abs(each.value))
        where = f"any of {len(every)} cases" if len(every) > 1 else "the only case"
        return (
            f"No difference of breakaway is significant in {where}; the largest is "
            f"{with_uncertainty(largest)}{by_chance(largest, len(every))}."
        )
    a, b = differences.names
    count = f"{len(real)} of {len(every)} cases"
    parts = [
        f"{way} than that of {a} by {_sizes(some)}"
        for way, some in (
            ("higher", [each for each in real if each.value > 0]),
            ("lower", [each for each in real if each.value < 0]),
        )
        if some
    ]
    return f"In {count}, breakaway of {b} is {' and in the others '.join(parts)}."


def _sizes(real: list[Difference]) -> str:
    """Write the sizes of differences with the largest of their uncertainties."""
    shares = [100 * abs(each.value / each.a) for each in real if each.a]
    share = f", or {percent_span(shares)}" if shares else ""
    return f"{sizes(real)} N{share} ({widest(real)})"


def breakaway_table(differences: CampaignDifferences) -> WordTable:
    """Return breakaway of both by direction, load, time at rest and rate, as far as known."""
    table = difference_table(
        "Breakaway (N)",
        ("Direction", "Load", "At rest (s)", "Rate (N/s)"),
        [
            (
                ", ".join(filter(None, (_label(each), DIRECTION_WORDS[each.a.direction]))),
                load_words(each.a.series.f_load_n, each.a.series.p_lr_ref_pa),
                "" if each.a.dwell_s is None else short(each.a.dwell_s),
                "" if each.a.rate_n_s is None else short(each.a.rate_n_s),
                *cells(each.breakaway_n, 1.0),
            )
            for each in differences.breakaways
        ],
    )
    known = [i for i in range(len(table.head)) if any(row[i] for row in table.rows)]
    return with_columns(table, known)


def breakaway_names(rows: Sequence[BreakawayDifference]) -> list[str]:
    """Return the direction of each case, with what else distinguishes it from the others."""
    columns = zip(*map(_set_up, rows), strict=True)
    kept: list[tuple[str, ...]] = []
    for number, column in enumerate(columns):
        finer = len(set(zip(*kept, column, strict=True))) > len(set(zip(*kept, strict=True)))
        if number == 0 or finer:
            kept.append(column)
    return [", ".join(filter(None, name)) for name in zip(*kept, strict=True)]


def _set_up(each: BreakawayDifference) -> tuple[str, ...]:
    a, load = each.a, each.a.series
    return (
        DIRECTION_WORDS[a.direction],
        load_words(load.f_load_n, None),
        load_words(None, load.p_lr_ref_pa),
        "" if a.dwell_s is None else f"{short(a.dwell_s)} s",
        "" if a.rate_n_s is None else f"{short(a.rate_n_s)} N/s",
        _label(each),
    )


def _label(each: BreakawayDifference) -> str:
    """Return the label of both; empty where the campaigns have different ones."""
    label = each.a.series.label
    return label if label == each.b.series.label else ""


def breakaways_document(differences: CampaignDifferences) -> list[dict[str, Any]]:
    """Return the section of breakaway in ``comparison.json``."""
    return [
        {
            "kind": each.a.kind,
            "direction": each.a.direction,
            "f_load_n": each.a.series.f_load_n,
            "p_lr_ref_pa": each.a.series.p_lr_ref_pa,
            "label_a": each.a.series.label,
            "label_b": each.b.series.label,
            "dwell_s": each.a.dwell_s,
            "rate_n_s": each.a.rate_n_s,
            "breakaway_n": numbers(each.breakaway_n),
        }
        for each in differences.breakaways
    ]
