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
from hbench.report.render.numbers import NONE, significant, with_interval

_REAL, _NOT = "differs", "not significant"
_INSTRUMENTS = "U of B\N{NO-BREAK SPACE}−\N{NO-BREAK SPACE}A"
HEAD = ("B − A ± trials", _INSTRUMENTS, "Verdict", "p (Holm)", "A", "B")


def difference_table(
    title: str, head: tuple[str, ...], rows: Iterable[tuple[str, ...]]
) -> WordTable:
    """Return a table whose rows end with ``cells``; without U where no row has one."""
    rows = tuple(rows)
    head = (*head, *HEAD)
    u95 = head.index(_INSTRUMENTS)
    if any(row[u95] != NONE for row in rows):
        return WordTable(title, head, rows)
    kept = [i for i in range(len(head)) if i != u95]
    return WordTable(
        title, tuple(head[i] for i in kept), tuple(tuple(row[i] for i in kept) for row in rows)
    )


def cells(difference: Difference, scale: float) -> tuple[str, ...]:
    """Return the cells below ``HEAD``, in a unit that is ``scale`` of the SI's."""
    half = None if difference.ci95 is None else scale * difference.ci95
    u95 = None if difference.u95 is None else scale * difference.u95
    return (
        with_interval(scale * difference.value, half),
        NONE if u95 is None else significant(u95, 2),
        difference.untested or (_REAL if difference.real else _NOT),
        NONE if difference.p_holm is None else _p(difference.p_holm),
        significant(scale * difference.a, 4),
        significant(scale * difference.b, 4),
    )


def _p(value: float) -> str:
    return "< 0.0001" if value < 1e-4 else significant(value, 2)


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
