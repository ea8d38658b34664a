"""Verdict on a campaign's data: a few checks, of which the worst counts.

Fits are not among them: good data at few speeds can leave a law's parameters undetermined. The
limits are hbench's own; no standard sets them.
"""

from collections.abc import Iterable, Iterator, Sequence
from statistics import median
from typing import NamedTuple

from hbench.analysis.curves.ramps import sliding
from hbench.analysis.summary.completeness import PlannedRuns, completeness
from hbench.analysis.summary.drift import drift_checks
from hbench.analysis.summary.force_checks import (
    constant_force,
    equal_directions,
    load_balance,
    load_direction,
    load_share,
)
from hbench.analysis.summary.plausibility import implausible_points
from hbench.analysis.summary.unlike_trials import unlike_check
from hbench.analysis.summary.zero_drift import ZeroDrift
from hbench.analysis.uncertainty.budget import StandardUncertainty, of_instruments
from hbench.records import (
    KINDS,
    Breakaway,
    Completeness,
    Curve,
    CurvePoint,
    Drift,
    EfficiencyCurve,
    Grade,
    ImplausiblePoint,
    Loop,
    Quality,
    QualityCheck,
    ScreenedRun,
    Zero,
    ZeroCheck,
)

GRADES: tuple[Grade, ...] = ("good", "with care", "poor")

_COMPLETE_GOOD, _COMPLETE_POOR = 100.0, 80.0  # % of the planned runs
_ACCEPTED_GOOD, _ACCEPTED_POOR = 95.0, 80.0  # % of the runs
_TRIALS_GOOD, _TRIALS_POOR = 3, 1  # of the point with the fewest
_SCATTER_GOOD, _SCATTER_POOR = 5.0, 15.0  # half of the 95 % interval, % of friction, median
# Difference of the measured loads of a point, % of the load or of friction, whichever is larger.
_LOAD_GOOD, _LOAD_POOR = 10.0, 50.0
_NOMINAL_LOAD_GOOD = 50.0  # difference of the measured load from the nominal one, % of it
_INSTRUMENTS_GOOD = 10.0  # half of the instruments' 95 % interval, % of friction, median


class _Friction(NamedTuple):
    """Friction of a point of a curve, or a breakaway: what the checks of trials grade."""

    friction_n: float
    ci95_n: float | None
    n: int  # trials
    instruments: StandardUncertainty | None


def quality(
    runs: Iterable[ScreenedRun],
    curves: Iterable[Curve],
    efficiency: Iterable[EfficiencyCurve] = (),
    planned: PlannedRuns | None = None,
    drift: Drift | None = None,
    of_force: ZeroDrift | None = None,
    zeros: Sequence[ZeroCheck] = (),
    loops: Sequence[Loop] = (),
    breakaways: Sequence[Breakaway] = (),
) -> Quality:
    """Return the checks that apply, and the worst of their grades.

    Steady curves count; without any, all others do; without these, the ``breakaways`` and the
    ``loops`` of triangles. ``planned`` is None where the plan is not known, as for imported logs.
    """
    runs, curves = tuple(runs), tuple(curves)
    chosen = [curve for curve in curves if KINDS[curve.kind].has_constant_speed] or list(curves)
    complete = completeness(runs, planned)
    implausible = implausible_points(chosen, efficiency)
    checks = (
        *_checks(runs, chosen, complete, implausible),
        *(() if chosen else _without_curves(breakaways, loops, complete)),
        *drift_checks(drift),
        *([of_force.check] if of_force else []),
        *_zeros(zeros),
    )
    worst = max((check.grade for check in checks), key=GRADES.index)
    return Quality(worst, checks, complete, implausible)


def _checks(
    runs: Sequence[ScreenedRun],
    curves: Sequence[Curve],
    complete: Completeness,
    implausible: Sequence[ImplausiblePoint],
) -> Iterator[QualityCheck]:
    if complete.planned is not None:
        yield _complete(complete, complete.planned)
    yield _runs_accepted(runs)
    points = [point for curve in curves for point in curve.points]
    if not points:
        return
    frictions = [_Friction(p.friction_n, p.ci95_n, p.n, of_instruments(p)) for p in points]
    yield from _trials(frictions, complete, {curve.kind for curve in curves})
    yield from unlike_check(curves)
    yield from _load_spread(runs, points)
    yield from _nominal_load(runs)
    yield _plausible_signs(implausible, len(points))
    moving = [*map(sliding, curves)]
    yield from load_direction(moving)
    yield from load_balance(moving)
    yield from load_share(moving)
    found = [*equal_directions(moving)]
    yield from found or constant_force(moving)
    yield _instruments(frictions)


def _without_curves(
    breakaways: Sequence[Breakaway], loops: Sequence[Loop], complete: Completeness
) -> Iterator[QualityCheck]:
    if breakaways:
        frictions = [
            _Friction(each.breakaway_n, each.ci95_n, each.n, of_instruments(each))
            for each in breakaways
        ]
        yield from _trials(frictions, complete, {each.kind for each in breakaways})
        yield _instruments(frictions)
    yield from equal_directions((), loops)


def _complete(complete: Completeness, planned: int) -> QualityCheck:
    made = planned - len(complete.not_completed)
    share = 100 * made / planned if planned else 100.0
    empty = any(point.accepted == 0 for point in complete.short_points)
    grade = _grade(-share, -_COMPLETE_GOOD, -_COMPLETE_POOR)
    if empty and grade == "good":
        grade = "with care"
    return QualityCheck(
        "complete", grade, share, "%", _COMPLETE_GOOD, _COMPLETE_POOR, made, planned
    )


def _runs_accepted(runs: Sequence[ScreenedRun]) -> QualityCheck:
    accepted, total = sum(run.accepted for run in runs), len(runs)
    share = 100 * accepted / total if total else 0.0
    grade = _grade(-share, -_ACCEPTED_GOOD, -_ACCEPTED_POOR)
    return QualityCheck(
        "runs_accepted", grade, share, "%", _ACCEPTED_GOOD, _ACCEPTED_POOR, accepted, total
    )


def _trials(
    frictions: Sequence[_Friction], complete: Completeness, kinds: set[str]
) -> Iterator[QualityCheck]:
    """Grade the number of trials and their scatter."""
    yield _trials_per_point(frictions, complete, kinds)
    scatter = [100 * f.ci95_n / abs(f.friction_n) for f in frictions if f.ci95_n and f.friction_n]
    if scatter:
        value = median(scatter)
        grade = _grade(value, _SCATTER_GOOD, _SCATTER_POOR)
        yield QualityCheck("repeatability", grade, value, "%", _SCATTER_GOOD, _SCATTER_POOR)


def _trials_per_point(
    frictions: Sequence[_Friction], complete: Completeness, kinds: set[str]
) -> QualityCheck:
    """Grade the fewest trials of a point; a point of the plan that no curve contains has none."""
    empty = sum(
        point.accepted == 0 and (point.kind in kinds or KINDS[point.kind].has_constant_speed)
        for point in complete.short_points
    )
    fewest = 0 if empty else min(each.n for each in frictions)
    grade = _grade(-fewest, -_TRIALS_GOOD, -_TRIALS_POOR - 1)
    return QualityCheck(
        "trials_per_point",
        grade,
        fewest,
        "trials",
        _TRIALS_GOOD,
        _TRIALS_POOR,
        empty,
    )


def _zeros(checks: Sequence[ZeroCheck]) -> Iterator[QualityCheck]:
    """Grade the largest zero error and the largest drift of one, in % of the sensor's class.

    A zero beyond the class is corrected; the sensor is to be used with care. One that is not known,
    or drifts by more than the class during the campaign, is poor.
    """
    of_channels: dict[str, list[Zero]] = {}
    for zero in (zero for check in checks for zero in check.zeros):
        of_channels.setdefault(zero.channel, []).append(zero)
    if not of_channels:
        return
    channels = of_channels.values()
    errors = [max(abs(z.error) for z in zeros) / zeros[0].limit for zeros in channels]
    beyond = sum(error > 1 for error in errors)
    unknown = any(zero.clipped for zeros in channels for zero in zeros)
    grade: Grade = "poor" if unknown else "with care" if beyond else "good"
    value = None if unknown else 100 * max(errors)
    yield QualityCheck("zeros", grade, value, "%", 100.0, None, beyond, len(errors))
    if len(checks) > 1:
        drifts = [(max(e) - min(e)) / z.limit for z, e in _errors(channels)]
        beyond = sum(drift > 1 for drift in drifts)
        grade, value = "poor" if beyond else "good", 100 * max(drifts)
        yield QualityCheck("zero_drift", grade, value, "%", 100.0, 100.0, beyond, len(drifts))


def _errors(channels: Iterable[Sequence[Zero]]) -> Iterator[tuple[Zero, list[float]]]:
    return ((zeros[0], [zero.error for zero in zeros]) for zeros in channels)


def _load_spread(
    runs: Sequence[ScreenedRun], points: Sequence[CurvePoint]
) -> Iterator[QualityCheck]:
    """Grade the largest difference of the loads of a point's runs, where it is not small.

    Only runs without a nominal load can have different loads unnoticed: it separates the others.
    """
    loads = {
        run.run.plan.run: run.means.f_applied_n
        for run in runs
        if run.run.plan.f_load_n is None and run.means and run.means.f_applied_n is not None
    }
    spreads = []
    for point in points:
        of_point = [loads[run] for run in point.runs if run in loads]
        if len(of_point) > 1:
            scale = max(abs(point.friction_n), *map(abs, of_point))
            spreads.append(100 * (max(of_point) - min(of_point)) / (scale or 1.0))
    mixed = sum(spread > _LOAD_GOOD for spread in spreads)
    if mixed:
        grade = _grade(max(spreads), _LOAD_GOOD, _LOAD_POOR)
        limits = _LOAD_GOOD, _LOAD_POOR
        yield QualityCheck("load_spread", grade, max(spreads), "%", *limits, mixed, len(points))


def _nominal_load(runs: Iterable[ScreenedRun]) -> Iterator[QualityCheck]:
    """Grade the largest difference of a run's load from its nominal one, where it is not small.

    Signs don't count: the names of files often have none. Nor do loads that a load cylinder sets
    with its pressures (``p_lr_ref_pa``): its friction is the difference.
    """
    found = []
    for run in runs:
        nominal_n, means = run.run.plan.f_load_n, run.means
        if nominal_n and run.accepted and run.run.plan.p_lr_ref_pa is None and means is not None:
            if means.f_applied_n is not None:
                found.append(100 * abs(abs(means.f_applied_n / nominal_n) - 1))
    beyond = sum(difference > _NOMINAL_LOAD_GOOD for difference in found)
    if beyond:
        limits = _NOMINAL_LOAD_GOOD, None
        yield QualityCheck(
            "nominal_load", "with care", max(found), "%", *limits, beyond, len(found)
        )


def _plausible_signs(implausible: Sequence[ImplausiblePoint], points: int) -> QualityCheck:
    """Grade the number of points with an implausible sign; beyond their interval they are poor."""

    number = len({point.where for point in implausible})
    beyond = len({point.where for point in implausible if point.beyond})
    grade: Grade = "poor" if beyond else "with care" if number else "good"
    return QualityCheck("plausible_signs", grade, number, "points", 0, None, beyond, points)


def _instruments(frictions: Sequence[_Friction]) -> QualityCheck:
    halves = [
        100 * each.instruments.expanded() / abs(each.friction_n)
        for each in frictions
        if each.instruments is not None and each.friction_n
    ]
    value = median(halves) if halves else None
    known_good = value is not None and value <= _INSTRUMENTS_GOOD
    grade: Grade = "good" if known_good else "with care"
    points_of = len(halves) or None
    return QualityCheck("instruments", grade, value, "%", _INSTRUMENTS_GOOD, None, of=points_of)


def _grade(value: float, good: float, poor: float) -> Grade:
    return "good" if value <= good else "poor" if value > poor else "with care"
