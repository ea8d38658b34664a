"""Drift of steady friction over a campaign: its test, its estimate, and its grade.

Friction y_ij of trial j of point i (direction, load, speed) at run time t_ij is

    y_ij = a_i + d t_ij + e_ij

with a level a_i of each point (fixed effects), so that only deviations from the point's own means
count (within estimator; W. H. Greene, Econometric Analysis, 7th ed., 11.4.1):

    d = sum tau_ij (y_ij - y_i) / S,   tau_ij = t_ij - t_i,   S = sum tau_ij^2
    se^2 = sum (y_ij - y_i - d tau_ij)^2 / (N - G - 1) / S

for N trials of G points, with Student's t for N - G - 1 degrees of freedom. Of trials with a common
set-up (``setups.py``) tau and y - y_i are the means, with their number as the weight; N and G are
then the numbers of set-ups and of sets of points that they link. y is |F| in N, or its
share of the point's mean if the scatter of the trials is proportional to friction rather than the
same everywhere: of these two models without drift, the one with the larger likelihood.

Two numbers of the plan say whether it separates drift from speed. The first is the variance
inflation factor of run time by the speeds of its curve, the second the part of the drift that
appears between the slowest and the fastest speed, by the slope of run time over speed:

    VIF = sum (t_ij - t_curve)^2 / S
    share = (v_max - v_min) / span  sum (|v_ij| - v_curve) t_ij / sum (|v_ij| - v_curve)^2

One curve of eight rising speeds with three trials has 72 and 1 in rows, 1.1 and 1/3 in passes, and
1 and about 0 in a random order. Above a factor of 5, speed explains more than 80 % of the variance
of run time, and the trials hardly show a drift (D. C. Montgomery et al., Introduction to Linear
Regression Analysis, 5th ed., 9.4.2: factors above 5 to 10 mean that coefficients are poorly
estimated). Above a share of 1/4, hbench's own limit, the effect of speed is biased.

A drift is a straight line over time here, and trials count as independent: one that levels off is
described by its mean rate, and friction that wanders slowly appears as drift too often.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from statistics import fmean

import numpy as np
from scipy.special import stdtr

from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.student import student_factor
from hbench.analysis.statistics.within import group_means, is_proportional, within
from hbench.analysis.summary.run_clock import RunClock
from hbench.analysis.summary.setups import means_of_setups, sizes_and_sets
from hbench.records import Curve, Drift, Grade, QualityCheck, ScreenedRun
from hbench.records.summary import LARGE_DRIFT, SEPARATED_VIF

LARGEST_SHARE = 0.25  # of a plan that separates drift from speed
_GOOD = 5.0  # change over the campaign, % of friction; as for repeatability, as is LARGE_DRIFT
_LEAST_DOF = 2
_HOUR_S = 3600.0


@dataclass(frozen=True)
class Trials:
    """Trials of all points with two or more; arrays (n,)."""

    curve: np.ndarray  # number of the curve
    point: np.ndarray  # number of the point
    speed_m_s: np.ndarray
    t: np.ndarray
    friction_n: np.ndarray  # positive against the motion
    temp_k: np.ndarray  # NaN where it was not measured
    setup: np.ndarray  # number of the set-up
    direction: np.ndarray  # 1 where the cylinder extends, else -1


def friction_drift(
    curves: Sequence[Curve], runs: Iterable[ScreenedRun], clock: RunClock
) -> Drift | None:
    """Test and estimate the drift of steady friction, pooled over the points of ``curves``.

    ``runs`` gives the trial of each run; runs of one trial of a point are averaged, as in the
    point. None if there are fewer than two degrees of freedom, all trials of each point have one
    time, or most points have no friction.
    """
    trials = trials_of(curves, {run.run.plan.run: run.run.plan.trial for run in runs}, clock)
    if not len(trials.t):
        return None
    tau = within(trials.t, trials.point)
    spread, points = float(tau @ tau), len(np.unique(trials.point))
    size, sets = sizes_and_sets(trials.setup, trials.point)
    dof = len(size) - sets - 1
    if dof < _LEAST_DOF or spread == 0.0:
        return None
    mean_n = np.abs(group_means(trials.friction_n, trials.point))
    if not np.median(mean_n) > 0.0:
        return None
    deviation = within(trials.friction_n, trials.point)
    relative = _is_relative(deviation, mean_n)
    y = deviation / mean_n if relative else deviation
    tau_k, y_k = (means_of_setups(values, trials.setup) for values in (tau, y))
    of_setups = float(size @ tau_k**2)
    if of_setups <= ROUNDING * spread:
        return None
    rate = float((size * tau_k) @ y_k) / of_setups
    residual = y_k - rate * tau_k
    se = float(np.sqrt(size @ residual**2 / dof / of_setups))
    half = student_factor(dof) * se
    span = clock.span(curves)
    percent = 100.0 if relative else 100.0 / float(np.median(mean_n))
    hour = _HOUR_S if clock.known else None
    in_curve = within(trials.t, trials.curve)
    vif = float(in_curve @ in_curve) / spread
    share = _speed_share(trials, span)
    warming, correlation, temp_p = _with_temperature(trials, y, span, dof)
    return Drift(
        basis="time" if clock.known else "order",
        scale="relative" if relative else "absolute",
        change=rate * span,
        change_ci95=half * span,
        change_percent=percent * rate * span,
        change_percent_ci95=percent * half * span,
        per_hour=None if hour is None else hour * rate,
        per_hour_ci95=None if hour is None else hour * half,
        span_s=span if clock.known else None,
        p=p_value(rate, se, dof),
        points=points,
        trials=len(tau),
        dof=dof,
        speed_vif=vif,
        speed_share=share,
        separated=vif <= SEPARATED_VIF and abs(share) <= LARGEST_SHARE,
        several_speeds=points > len(np.unique(trials.curve)),
        temp_change_k=warming,
        temp_correlation=correlation,
        temp_p=temp_p,
    )


def drift_checks(drift: Drift | None) -> tuple[QualityCheck, ...]:
    """Return the grade of a drift's size, and of whether the plan can show one; empty without.

    A significant drift of more than 5 % of friction is to be used with care; if it is not separated
    from speed, more than 15 % is poor. A plan that does not separate them, and would not show 15 %,
    is to be used with care too. If only the order is known, which may be that of file names, a
    significant drift that is not separated from speed is to be used with care, and others pass.
    """
    if drift is None:
        return ()
    size = abs(drift.change_percent)
    if drift.hidden and drift.basis == "order":
        return ()
    if not drift.has_size:
        return (QualityCheck("drift", "with care", None, "%", _GOOD, LARGE_DRIFT, drift=drift),)
    poor = drift.significant and not drift.separated and size > LARGE_DRIFT
    care = size > _GOOD if drift.significant else drift.hidden
    grade: Grade = "poor" if poor else "with care" if care else "good"
    return (QualityCheck("drift", grade, size, "%", _GOOD, LARGE_DRIFT, drift=drift),)


def trials_of(curves: Sequence[Curve], trial_of: Mapping[str, int], clock: RunClock) -> Trials:
    """Return the trials of all points of ``curves``; ``trial_of`` has the trial of each run."""
    rows = []
    setups: dict[str, int] = {}
    number = 0
    for i, curve in enumerate(curves):
        for point in curve.points:
            number += 1
            if point.n < 2:
                continue
            times, setup = defaultdict(list), {}
            for run in point.runs:
                times[trial_of[run]].append(clock.times[run])
                setup[trial_of[run]] = clock.setups.get(run, f"run {run}")
            temps = point.trials_temp_k or (np.nan,) * point.n
            for trial, friction, temp in zip(point.trials, point.trials_n, temps, strict=True):
                speed = abs(point.v_m_s)
                of_trial = setups.setdefault(setup[trial], len(setups))
                at = fmean(times[trial])
                sign = curve.against_motion
                rows.append((i, number, speed, at, sign * friction, temp, of_trial, sign))
    return Trials(*np.array(rows, dtype=float).reshape(-1, len(fields(Trials))).T)


def _with_temperature(
    trials: Trials, y: np.ndarray, span: float, dof: int
) -> tuple[float | None, float | None, float | None]:
    """Return the oil's linear change over ``span`` [K], its correlation with friction, and p.

    ``y`` (n,) are the trials' deviations from their points; temperature is taken as these.
    """
    if not np.isfinite(trials.temp_k).all():
        return None, None, None
    t = trials.t - trials.t.mean()
    change = float(t @ trials.temp_k / (t @ t)) * span
    deviation = within(trials.temp_k, trials.point)
    size = float(np.sqrt((deviation @ deviation) * (y @ y)))
    if size == 0.0:
        return change, None, None
    r = min(max(float(deviation @ y) / size, -1.0), 1.0)
    return change, r, p_value(r, float(np.sqrt((1.0 - r**2) / dof)), dof)


def _speed_share(trials: Trials, span: float) -> float:
    """Return the share of ``span`` between the slowest and the fastest speed of a curve."""
    v = within(trials.speed_m_s, trials.curve)
    if not v.any():
        return 0.0
    reach = max(np.ptp(trials.speed_m_s[trials.curve == i]) for i in np.unique(trials.curve))
    return float(reach * (v @ trials.t) / (v @ v) / span)


def _is_relative(deviation_n: np.ndarray, mean_n: np.ndarray) -> bool:
    """Return whether the scatter is proportional to friction; not where a point has none."""
    if not mean_n.min() > 0.0:
        return False
    share = deviation_n / mean_n
    return is_proportional(deviation_n @ deviation_n, share @ share, mean_n)


def p_value(rate: float, se: float, dof: int) -> float:
    """Return the probability of a rate beyond this one without a drift, by Student's t."""
    if se == 0.0:
        return 1.0 if rate == 0.0 else 0.0
    return float(2.0 * stdtr(dof, -abs(rate / se)))
