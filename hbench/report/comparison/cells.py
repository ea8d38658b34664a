"""Cells of a comparison: both numbers, their difference and its verdict."""

from collections.abc import Iterable
from dataclasses import asdict, replace
from typing import Any

from hbench.records import (
    BandDifference,
    BandTrendDifference,
    CampaignDifferences,
    CurveDifference,
    Difference,
    WordTable,
)
from hbench.records.rod_pressure import without_common_rod_pressure
from hbench.report.render.numbers import NONE, p_words, significant, with_interval
from hbench.report.render.word_tables import with_columns

SIGNIFICANT, NOT_SIGNIFICANT = "significant", "not significant"
MAY_BE_DRIFT = "may be drift"
WITH_U, TRIALS = "B − A ± U", "B − A ± trials"
P_TRIALS = "p, trials"
HEAD = ("A", "B", WITH_U, TRIALS, "Verdict", P_TRIALS)


def difference_table(
    title: str,
    head: tuple[str, ...],
    rows: Iterable[tuple[str, ...]],
    behind: tuple[str, ...] = (),
) -> WordTable:
    """Return a table whose rows have ``cells`` between those of ``head`` and ``behind``.

    The difference is with its U; where no row has one, with the interval of the trials.
    """
    rows = tuple(rows)
    first = len(head)
    own = " ± U" if any("±" in cell for row in rows for cell in row[first : first + 2]) else ""
    head = (*head, f"A{own}", f"B{own}", *HEAD[2:], *behind)
    with_u = any("±" in row[head.index(WITH_U)] for row in rows)
    left_out = head.index(TRIALS if with_u else WITH_U)
    kept = [i for i in range(len(head)) if i != left_out]
    return with_columns(WordTable(title, head, rows), kept)


def cells(difference: Difference, scale: float, mixed: bool = False) -> tuple[str, ...]:
    """Return the cells below ``HEAD``, in a unit that is ``scale`` of the SI's.

    ``mixed`` is a difference that a drift may account for.
    """
    real = MAY_BE_DRIFT if mixed else SIGNIFICANT
    u95, trials = (
        with_interval(scale * difference.value, None if half is None else scale * half)
        for half in (difference.u95, difference.ci95)
    )
    return (
        with_u95(scale * difference.a, difference.u95_a, scale),
        with_u95(scale * difference.b, difference.u95_b, scale),
        u95,
        trials,
        difference.untested or (real if difference.real else NOT_SIGNIFICANT),
        NONE if difference.p_holm is None else p_words(difference.p_holm),
    )


def with_u95(value: float, u95: float | None, scale: float = 1.0) -> str:
    """Write A's or B's number with its own U; without one, with four digits."""
    return significant(value, 4) if u95 is None else with_interval(value, scale * u95)


def signed(difference: Difference, scale: float = 1.0) -> str:
    """Write the difference with its sign and its interval, with the instruments if known."""
    half = difference.u95 or difference.ci95
    text = with_interval(scale * difference.value, None if half is None else scale * half)
    return f"+{text}" if difference.value > 0 else text


def percent(difference: Difference) -> str:
    """Write the difference as a share of A's number."""
    if difference.a == 0:
        return NONE
    share = 100 * difference.value / abs(difference.a)
    return f"{'+' if share > 0 else ''}{significant(share, 2)} %"


def numbers(difference: Difference | None) -> Any:
    """Return a difference with its verdict as JSON values."""
    if difference is None:
        return None
    return {**asdict(difference), "difference": difference.value, "real": difference.real}


def with_names(differences: CampaignDifferences) -> CampaignDifferences:
    """Return differences whose curves have a rod-side pressure only where they differ in it."""
    a = without_common_rod_pressure(curve.a for curve in differences.curves)
    curves = zip(differences.curves, a, strict=True)
    return replace(differences, curves=tuple(replace(curve, a=named) for curve, named in curves))


def label_of(pair: BandDifference | BandTrendDifference | CurveDifference) -> str:
    """Return the label of both; empty where the campaigns have different ones."""
    return pair.a.label if pair.a.label == pair.b.label else ""
