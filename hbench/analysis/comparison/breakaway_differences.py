"""Differences between the breakaway of two campaigns.

Breakaway is compared in the same direction, at the same load, after the same time at rest and with
the same rate of the force. Labels must agree if either campaign has several.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import isclose

from hbench.analysis.comparison.difference_tests import (
    NO_SCATTER,
    CampaignValue,
    Contributions,
    InstrumentPair,
    corrected,
    tested,
    untested,
    welch,
)
from hbench.analysis.uncertainty.budget import friction_contributions
from hbench.config.sensors import Instruments
from hbench.records import (
    DIRECTION_WORDS,
    SIGNS,
    Breakaway,
    BreakawayDifference,
    CurvePoint,
    Difference,
    Results,
    Specimen,
)

_SAME = 0.05  # largest relative difference of two times at rest or rates that count as the same


def breakaway_differences(
    a: Results, b: Results, instruments: InstrumentPair
) -> tuple[tuple[BreakawayDifference, ...], tuple[str, ...]]:
    """Compare breakaway that both campaigns have, in the order of A; return notes on the other."""
    labels = any(len({each.series.label for each in _all(x)}) > 1 for x in (a, b))
    left, found, notes = list(_all(b)), [], []
    for one in _all(a):
        other = next((each for each in left if _match(one, each, labels)), None)
        if other is None:
            notes.append(f"{_name(one)}: only in A")
            continue
        left.remove(other)
        values = _value(one, a, instruments.a), _value(other, b, instruments.b)
        difference = _difference(one, other, *values, instruments)
        found.append(BreakawayDifference(one, other, difference))
    notes += [f"{_name(each)}: only in B" for each in left]
    differences = corrected([each.breakaway_n for each in found])
    return tuple(replace(each, breakaway_n=next(differences)) for each in found), tuple(notes)


def _all(results: Results) -> Sequence[Breakaway]:
    return results.motions.breakaways


def _match(a: Breakaway, b: Breakaway, labels: bool) -> bool:
    """Return whether two rows have the same set-up; the rod-side pressure where both state one."""
    pressures = a.series.p_lr_ref_pa, b.series.p_lr_ref_pa
    return (
        (a.kind, a.direction, a.series.f_load_n) == (b.kind, b.direction, b.series.f_load_n)
        and (None in pressures or pressures[0] == pressures[1])
        and (not labels or a.series.label == b.series.label)
        and _alike(a.dwell_s, b.dwell_s)
        and _alike(a.rate_n_s, b.rate_n_s)
    )


def _alike(a: float | None, b: float | None) -> bool:
    if a is None or b is None:
        return a is b
    return isclose(a, b, rel_tol=_SAME)


def _difference(
    a: Breakaway,
    b: Breakaway,
    of_a: CampaignValue,
    of_b: CampaignValue,
    instruments: InstrumentPair,
) -> Difference:
    error = welch([(-1.0, a.trials_n), (1.0, b.trials_n)])
    if error is None:
        return untested(a.breakaway_n, b.breakaway_n, NO_SCATTER)
    return tested(of_a, of_b, *error, instruments)


def _value(each: Breakaway, results: Results, instruments: Instruments | None) -> CampaignValue:
    """Return one campaign's breakaway with the errors of its instruments, if they are known."""
    specimen = next(run.run.plan.specimen for run in results.runs if run.run.plan.run in each.runs)
    return CampaignValue(
        each.breakaway_n,
        None if instruments is None else _contributions(each, specimen, instruments),
        trials=welch([(1.0, each.trials_n)]),
    )


def _contributions(
    each: Breakaway, specimen: Specimen, instruments: Instruments
) -> Contributions | None:
    """Return the instruments' parts [N] in a breakaway, positive against the motion."""
    sign = SIGNS[each.direction]
    friction_n = sign * each.breakaway_n
    point = CurvePoint(
        v_m_s=0.0,
        friction_n=friction_n,
        ci95_n=each.ci95_n,
        n=each.n,
        f_test_n=friction_n + each.f_applied_n,  # (5.1)
        f_applied_n=each.f_applied_n,
        p_tp_pa=each.p_tp_pa,
        p_tr_pa=each.p_tr_pa,
        trials=(),
        trials_n=each.trials_n,
        trials_f_test_n=(),
        runs=each.runs,
    )
    parts = friction_contributions(point, specimen, instruments)
    return {name: part._replace(value=sign * part.value) for name, part in parts.items()} or None


def _name(each: Breakaway) -> str:
    """Return direction, load, rest and rate of a breakaway."""
    return " ".join(_words(each))


def _words(each: Breakaway) -> Iterator[str]:
    if each.series.label:
        yield each.series.label
    yield f"breakaway {DIRECTION_WORDS[each.direction]}"
    if each.series.f_load_n is not None:
        yield f"{each.series.f_load_n:.5g} N"
    if each.dwell_s is not None:
        yield f"after {each.dwell_s:.4g} s"
    if each.rate_n_s is not None:
        yield f"at {each.rate_n_s:.4g} N/s"
