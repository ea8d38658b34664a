"""Verdict on a campaign's data: a few checks, of which the worst counts.

Fits are not among them: good data at few speeds can leave a law's parameters open. The limits are hbench's own; no standard sets them.
"""

from collections.abc import Iterable, Iterator
from statistics import median

from hbench.records import KINDS, Curve, CurvePoint, Grade, Quality, QualityCheck, ScreenedRun
from hbench.records.numbers import NORMAL_95

GRADES: tuple[Grade, ...] = ("good", "with care", "poor")

_ACCEPTED_GOOD, _ACCEPTED_POOR = 95.0, 80.0  # % of the runs
_TRIALS_GOOD, _TRIALS_POOR = 3, 1  # of the point with the fewest
_SCATTER_GOOD, _SCATTER_POOR = 5.0, 15.0  # half of the 95 % interval, % of friction, median
_INSTRUMENTS_GOOD = 10.0  # half of the instruments' 95 % interval, % of friction, median


def quality(runs: Iterable[ScreenedRun], curves: Iterable[Curve]) -> Quality:
    """Return the checks that apply, and the worst of their grades.

    Steady curves count; without any, all others do.
    """
    curves = tuple(curves)
    chosen = [curve for curve in curves if KINDS[curve.kind].has_constant_speed] or list(curves)
    checks = tuple(_checks(tuple(runs), chosen))
    return Quality(max((check.grade for check in checks), key=GRADES.index), checks)


def _checks(runs: tuple[ScreenedRun, ...], curves: list[Curve]) -> Iterator[QualityCheck]:
    yield _runs_accepted(runs)
    points = [point for curve in curves for point in curve.points]
    if not points:
        return
    yield _trials_per_point(points)
    scatter = [100 * p.ci95_n / abs(p.friction_n) for p in points if p.ci95_n and p.friction_n]
    if scatter:
        value = median(scatter)
        grade = _grade(value, _SCATTER_GOOD, _SCATTER_POOR)
        yield QualityCheck("repeatability", grade, value, "%", _SCATTER_GOOD, _SCATTER_POOR)
    yield _instruments(points)


def _runs_accepted(runs: tuple[ScreenedRun, ...]) -> QualityCheck:
    accepted, total = sum(run.accepted for run in runs), len(runs)
    share = 100 * accepted / total if total else 0.0
    grade = _grade(-share, -_ACCEPTED_GOOD, -_ACCEPTED_POOR)
    return QualityCheck(
        "runs_accepted", grade, share, "%", _ACCEPTED_GOOD, _ACCEPTED_POOR, accepted, total
    )


def _trials_per_point(points: list[CurvePoint]) -> QualityCheck:
    fewest = min(point.n for point in points)
    grade = _grade(-fewest, -_TRIALS_GOOD, -_TRIALS_POOR - 1)
    return QualityCheck("trials_per_point", grade, fewest, "trials", _TRIALS_GOOD, _TRIALS_POOR)


def _instruments(points: list[CurvePoint]) -> QualityCheck:
    halves = [
        100 * NORMAL_95 * p.sigma_instruments_n / abs(p.friction_n)
        for p in points
        if p.sigma_instruments_n is not None and p.friction_n
    ]
    value = median(halves) if halves else None
    known_good = value is not None and value <= _INSTRUMENTS_GOOD
    grade: Grade = "good" if known_good else "with care"
    return QualityCheck("instruments", grade, value, "%", _INSTRUMENTS_GOOD, None)


def _grade(value: float, good: float, poor: float) -> Grade:
    return "good" if value <= good else "poor" if value > poor else "with care"
