"""Trials that contradict the others of their point: a wrong channel or file among good ones.

Each trial is compared with the mean of the other trials of its point, for all points at once:

    e = F - mean(others),    s^2 = Var(e) / (1 + 1 / (n - 1)),    n trials of the point

in shares of the point's median friction. The standard deviation s of a trial is robust, so that a
minority of wrong trials does not widen it. A trial is unlike if it is the furthest of its point and

    |e| > t_(1 - alpha / 2N) s sqrt(1 + 1 / (n - 1)),    |e| > 15 %

with Student's factor for 0.37 times the N trials less the points (Bonferroni), at alpha = 5 %,
for normal scatter; with heavy tails there are more such trials. An unlike trial is not rejected: it
is part of its point's mean and interval.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from statistics import fmean, median

import numpy as np
from scipy.special import stdtrit

from hbench.motion.noise import robust_sigma
from hbench.records import DIRECTION_WORDS, Curve, CurvePoint, QualityCheck

_ALPHA = 0.05
_EFFICIENCY = 0.37  # of the median of |e| as an estimate of s, relative to least squares
_SMALL = 0.15  # of friction: repeatability that is poor
_LEAST = 3  # trials of a point: the others show their scatter
_LISTED = 10  # in the note


@dataclass(frozen=True)
class UnlikeTrial:
    """A trial far from the others of its point."""

    curve: Curve
    point: CurvePoint
    index: int  # in the point's trials
    others_n: float  # mean friction of the others

    @property
    def words(self) -> str:
        """The trial with its point, its friction and that of the others."""
        curve, point = self.curve, self.point
        single = len(point.runs) == point.n
        name = f"run {point.runs[self.index]}" if single else f"trial {point.trials[self.index]}"
        load = "" if curve.f_load_n is None else f"{curve.f_load_n:g} N"
        speed = f"{1e3 * abs(point.v_m_s):.3g} mm/s"
        where = ", ".join(
            filter(None, (curve.label, DIRECTION_WORDS[curve.direction], load, speed))
        )
        found, others = (_digits(f) for f in (point.trials_n[self.index], self.others_n))
        return f"{name} ({where}): {found} N, the others {others} N"


def _digits(value: float) -> str:
    return f"{float(f'{value:.3g}'):g}"


def unlike_trials(curves: Iterable[Curve]) -> list[UnlikeTrial]:
    """Return the trials of points with three or more that contradict the others."""
    points = [
        (curve, point)
        for curve in curves
        for point in curve.points
        if point.n >= _LEAST and median(point.trials_n) != 0
    ]
    shares = [_from_others(point) for _, point in points]
    count = sum(map(len, shares))
    dof = _EFFICIENCY * (count - len(points))
    if len(points) < 2:
        return []
    scaled = np.concatenate([e / np.sqrt(1 + 1 / (len(e) - 1)) for e in shares])
    limit = float(stdtrit(dof, 1 - _ALPHA / count / 2)) * robust_sigma(scaled)
    found = []
    for (curve, point), e in zip(points, shares, strict=True):
        furthest = int(np.abs(e).argmax())
        if abs(e[furthest]) > max(limit * np.sqrt(1 + 1 / (len(e) - 1)), _SMALL):
            others = [f for i, f in enumerate(point.trials_n) if i != furthest]
            found.append(UnlikeTrial(curve, point, furthest, fmean(others)))
    return found


def _from_others(point: CurvePoint) -> np.ndarray:
    """Return the deviations (n,) of trials from the mean of the others, in shares of friction."""
    friction = np.array(point.trials_n)
    n = len(friction)
    others = (friction.sum() - friction) / (n - 1)
    return (friction - others) / abs(float(np.median(friction)))


def unlike_check(curves: Iterable[Curve]) -> Iterator[QualityCheck]:
    """Yield a check with their number, where there are such trials."""
    curves = tuple(curves)
    if count := len(unlike_trials(curves)):
        of = sum(point.n for curve in curves for point in curve.points)
        yield QualityCheck("unlike_trials", "with care", count, "trials", 0, None, count, of)


def unlike_notes(curves: Iterable[Curve]) -> Iterator[str]:
    """Yield a note that lists these trials."""
    found = [trial.words for trial in unlike_trials(curves)]
    if found:
        more = f"; {len(found) - _LISTED} more" if len(found) > _LISTED else ""
        yield (
            f"trials: friction contradicts the other trials of the same point: "
            f"{'; '.join(found[:_LISTED])}{more}. They are part of the means and of U. Look for "
            "a wrong sign, scale or channel in the file, and leave it out if there is one"
        )
