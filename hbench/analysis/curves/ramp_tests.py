"""Tests of the effect of a ramp's acceleration, and of ramps against steady runs.

The unit is the trial, not the sample: each trial counts with its mean |F| over a range of speeds
that all compared curves have. There are two ranges, the lower and the upper half, since lag acts
where friction still changes with travel or speed, and an error of the inertia everywhere.

    accelerations    F test of one-way analysis of variance over the groups; the effect is the
                     largest acceleration less the smallest, with the pooled scatter
    steady, ramp     Welch's t test

Student's and Fisher's distributions assume independent, normal trials. p values of the same kind
are corrected for their number after Holm (1979).
"""

import warnings
from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.rounding import ROUNDING, exceeds
from hbench.analysis.statistics.holm import holm
from hbench.analysis.statistics.student import student_factor
from hbench.records import KINDS, Comparison, Curve

_GRID = 10  # speeds of a half at which ramps are compared
_LEAST = 2  # steady speeds in a range


def ramp_comparisons(curves: Iterable[Curve]) -> tuple[Comparison, ...]:
    """Test all ramps of the same load, direction and label, and against steady runs."""
    groups: dict[tuple, list[Curve]] = defaultdict(list)
    for curve in curves:
        if KINDS[curve.kind].is_ramp or KINDS[curve.kind].has_constant_speed:
            key = curve.label, curve.f_load_n, curve.p_lr_ref_pa, curve.direction, curve.specimen
            groups[key].append(curve)
    accelerations: list[Comparison] = []
    steady: list[Comparison] = []
    for group in groups.values():
        ramps = [curve for curve in group if KINDS[curve.kind].is_ramp and len(curve.points) > 1]
        ramps.sort(key=lambda curve: curve.a_ref_m_s2 or 0.0)
        if len(ramps) > 1:
            accelerations += _accelerations(ramps)
        for ramp in ramps:
            for other in group:
                if KINDS[other.kind].has_constant_speed:
                    steady += _steady(ramp, other)
    return (*_corrected(accelerations), *_corrected(steady))


def _accelerations(ramps: list[Curve]) -> Iterable[Comparison]:
    low = max(abs(ramp.points[0].v_m_s) for ramp in ramps)
    high = min(abs(ramp.points[-1].v_m_s) for ramp in ramps)
    for a, b in _halves(low, high):
        groups = [_levels(ramp, np.linspace(a, b, _GRID)) for ramp in ramps]
        yield _anova(ramps, groups, a, b)


def _anova(ramps: list[Curve], groups: list[np.ndarray], low: float, high: float) -> Comparison:
    effect = float(groups[-1].mean() - groups[0].mean())
    dof = sum(map(len, groups)) - len(groups)
    half = p_value = None
    message = "no test: there is only one trial at each acceleration"
    if dof > 0:
        within = sum(float(np.sum((group - group.mean()) ** 2)) for group in groups) / dof
        error = np.sqrt(within * (1 / len(groups[0]) + 1 / len(groups[-1])))
        half = float(student_factor(dof) * error)
        from scipy.stats import f_oneway  # slow import

        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # groups without scatter give nan
            p_value = float(f_oneway(*groups).pvalue)
        message = ""
    return Comparison(
        what="acceleration",
        series=ramps[0].series,
        direction=ramps[0].direction,
        a_m_s2=tuple(ramp.a_ref_m_s2 or 0.0 for ramp in ramps),
        v_low_m_s=low,
        v_high_m_s=high,
        effect_n=effect,
        ci95_n=half,
        p_value=p_value,
        p_holm=None,
        n=sum(map(len, groups)),
        message=message,
        kind=ramps[0].kind,
    )


def _steady(ramp: Curve, steady: Curve) -> Iterable[Comparison]:
    trials = {trial for point in steady.points for trial in point.trials}
    low, high = (abs(ramp.points[i].v_m_s) for i in (0, -1))
    points = [
        point
        for point in steady.points
        if _within(abs(point.v_m_s), low, high) and set(point.trials) == trials
    ]
    for a, b in _halves(low, high):
        chosen = [point for point in points if _within(abs(point.v_m_s), a, b)]
        if len(chosen) < _LEAST:
            continue
        speeds = np.abs([point.v_m_s for point in chosen])
        steady_n = np.mean([_by_trial(point.trials, point.trials_n) for point in chosen], axis=0)
        ramp_n = _levels(ramp, speeds)
        steady_n = steady_n if steady.direction == "extend" else -steady_n
        half = p_value = None
        message = "no test: there is only one trial"
        if min(len(ramp_n), len(steady_n)) > 1:
            from scipy.stats import ttest_ind

            test = ttest_ind(ramp_n, steady_n, equal_var=False)
            interval = test.confidence_interval()
            half, p_value = float(interval.high - interval.low) / 2, float(test.pvalue)
            message = ""
        yield Comparison(
            what="steady",
            series=ramp.series,
            direction=ramp.direction,
            a_m_s2=(ramp.a_ref_m_s2 or 0.0,),
            v_low_m_s=float(speeds.min()),
            v_high_m_s=float(speeds.max()),
            effect_n=float(ramp_n.mean() - steady_n.mean()),
            ci95_n=half,
            p_value=p_value,
            p_holm=None,
            n=len(ramp_n) + len(steady_n),
            message=message,
            kind=ramp.kind,
        )


def _halves(low: float, high: float) -> list[tuple[float, float]]:
    middle = 0.5 * (low + high)
    return [(low, middle), (middle, high)] if exceeds(high, low) else []


def _within(speed: float, low: float, high: float) -> bool:
    nothing = ROUNDING * high
    return low - nothing <= speed <= high + nothing


def _by_trial(trials: Sequence[int], values: Sequence[float]) -> list[float]:
    return [value for _, value in sorted(zip(trials, values, strict=True))]


def _levels(curve: Curve, speeds_m_s: np.ndarray) -> np.ndarray:
    """Return each trial's mean |F| over ``speeds_m_s``, straight between its points."""
    v = np.abs([point.v_m_s for point in curve.points])
    of_trials = curve.against_motion * np.array([point.trials_n for point in curve.points]).T
    return np.array([np.interp(speeds_m_s, v, trial).mean() for trial in of_trials])


def _corrected(comparisons: list[Comparison]) -> list[Comparison]:
    p_values = [comparison.p_value for comparison in comparisons]
    corrected = iter(holm([p for p in p_values if p is not None]).tolist())
    return [
        comparison if p is None else replace(comparison, p_holm=next(corrected))
        for comparison, p in zip(comparisons, p_values, strict=True)
    ]
