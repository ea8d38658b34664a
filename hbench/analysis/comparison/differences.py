"""Differences between the friction curves of two campaigns.

Curves are compared at A's speeds within B's range. Curves with few speeds, which are points over
pressure, also match at equal pressures, such as those of another bore.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from statistics import fmean

import numpy as np
from scipy.special import ndtr

from hbench.analysis.comparison.difference_tests import (
    NO_SCATTER,
    corrected,
    tested,
    untested,
    weighted,
    welch,
)
from hbench.analysis.comparison.matching import (
    SPEED_TOLERANCE,
    Distinction,
    SetPoint,
    distinction,
    nearest_set_point,
    series_key,
)
from hbench.analysis.curves.ramps import sliding
from hbench.analysis.fitting.fit_data import sign
from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.student import satterthwaite
from hbench.analysis.summary.drift_uncertainty import efficiency_drift
from hbench.analysis.uncertainty.budget import errors_of, friction_contributions, with_dof
from hbench.config.sensors import Instruments
from hbench.records import (
    KINDS,
    Curve,
    CurveDifference,
    CurvePoint,
    Difference,
    EfficiencyCurve,
    EfficiencyPoint,
    FitDifference,
    FitParameter,
    FrictionDifference,
    Results,
)
from hbench.records.numbers import NORMAL_95

CurveKey = tuple
Weights = Mapping[int, float]  # of a curve's points, by their numbers


def campaign_differences(
    a: Results,
    b: Results,
    instruments: tuple[Instruments | None, Instruments | None],
    same_instruments: bool,
    tolerance: float = SPEED_TOLERANCE,
) -> tuple[tuple[CurveDifference, ...], tuple[str, ...]]:
    """Compare the curves that both campaigns have; return them, and notes on the other curves.

    Curves are matched by kind, direction, load and rod-side pressure; also by label and factors
    if either campaign has several. ``tolerance`` is the largest relative difference of two speeds
    of points over pressure.
    """
    distinct = distinction(a, b)
    curves_a, curves_b = (
        {_key(curve, distinct): sliding(curve) for curve in results.curves} for results in (a, b)
    )
    etas = [{_key(curve, distinct): curve for curve in results.efficiency} for results in (a, b)]
    compared, notes = [], []
    partners = {key: _partner(curve, key, curves_b) for key, curve in curves_a.items()}
    for key, curve in curves_a.items():
        partner = partners[key]
        if partner is None:
            notes.append(f"{_name(curve)}: only in A")
            continue
        other = curves_b[partner]
        difference = _curves(curve, other, instruments, same_instruments, tolerance)
        if not difference.points:
            notes.append(
                f"{_name(curve)}: no speeds in common; {_speeds(curve)} in A and "
                f"{_speeds(other)} in B"
            )
            continue
        if key in etas[0] and partner in etas[1] and KINDS[curve.kind].has_constant_speed:
            pair = (curve, etas[0][key]), (other, etas[1][partner])
            efficiency = _efficiency(*pair, instruments, same_instruments, tolerance)
            difference = replace(difference, efficiency=efficiency)
        compared.append(difference)
    paired = set(partners.values())
    notes += [f"{_name(curve)}: only in B" for key, curve in curves_b.items() if key not in paired]
    return _corrected(compared), tuple(notes)


def _key(curve: Curve | EfficiencyCurve, distinct: Distinction) -> CurveKey:
    return (*series_key(curve, distinct), curve.direction, curve.a_ref_m_s2, curve.f_load_n)


def _partner(curve: Curve, key: CurveKey, others: Mapping[CurveKey, Curve]) -> CurveKey | None:
    """Return the key of the curve at the same load, or of few points at the same pressure."""
    if key in others or curve.over_velocity:
        return key if key in others else None
    alike = {
        other_key: _set_point(other)
        for other_key, other in others.items()
        if other_key[:-1] == key[:-1] and not other.over_velocity
    }
    return nearest_set_point(_set_point(curve), alike)


def _set_point(curve: Curve) -> SetPoint:
    pressures = [point.p_tp_pa for point in curve.points if point.p_tp_pa is not None]
    return SetPoint(curve.f_load_n, fmean(pressures) if pressures else None)


def _speeds(curve: Curve) -> str:
    ends = {abs(curve.points[i].v_m_s): None for i in (0, -1)}
    return " to ".join(f"{1e3 * v:.3g}" for v in ends) + " mm/s"


def _name(curve: Curve) -> str:
    a = "" if curve.a_ref_m_s2 is None else f"{curve.a_ref_m_s2:.3g} m/s^2"
    load = "" if curve.f_load_n is None else f"{curve.f_load_n:.5g} N"
    return " ".join(filter(None, (curve.label, curve.kind, a, curve.direction, load)))


def _curves(
    a: Curve,
    b: Curve,
    instruments: tuple[Instruments | None, Instruments | None],
    same: bool,
    tolerance: float,
) -> CurveDifference:
    weights = paired_weights(a, b, tolerance)
    points = tuple(
        FrictionDifference(
            v_m_s=a.points[next(iter(weights_a))].v_m_s,
            friction_n=_friction((a, weights_a), (b, weights_b), instruments, same),
            between=len(weights_b) > 1,
        )
        for weights_a, weights_b in weights
    )
    means = mean_weights(a, b, tolerance)
    return CurveDifference(
        a=a,
        b=b,
        points=points,
        mean_n=_friction((a, means[0]), (b, means[1]), instruments, same) if points else None,
        efficiency=None,
        parameters=tuple(_parameters(a, b)),
    )


def paired_weights(a: Curve, b: Curve, tolerance: float) -> list[tuple[Weights, Weights]]:
    """Return the weights of A's and B's points at each speed of A that B has too."""
    speeds = [abs(point.v_m_s) for point in a.points]
    weights = [({i: 1.0}, _weights(speed, b, tolerance)) for i, speed in enumerate(speeds)]
    return [(weights_a, weights_b) for weights_a, weights_b in weights if weights_b]


def mean_weights(a: Curve, b: Curve, tolerance: float) -> tuple[Weights, Weights]:
    """Return the weights of A's and of B's points in the means over the speeds of both."""
    pairs = paired_weights(a, b, tolerance)
    of_a, of_b = (_mean_weights([pair[side] for pair in pairs]) for side in (0, 1))
    return of_a, of_b


def _weights(speed: float, curve: Curve, tolerance: float) -> Weights:
    """Return the weights of the point at a speed, or of its two neighbours, by their numbers."""
    v = [abs(point.v_m_s) for point in curve.points]
    near = min(range(len(v)), key=lambda i: abs(v[i] - speed))
    limit = SPEED_TOLERANCE if curve.over_velocity else tolerance
    if abs(v[near] - speed) <= limit * speed:
        return {near: 1.0}
    low = max((i for i in range(len(v)) if v[i] < speed), key=lambda i: v[i], default=None)
    high = min((i for i in range(len(v)) if v[i] > speed), key=lambda i: v[i], default=None)
    if low is None or high is None:
        return {}
    share = (speed - v[low]) / (v[high] - v[low])
    return {low: 1.0 - share, high: share}


def _mean_weights(sums: Sequence[Weights]) -> Weights:
    """Return the weights of the mean of weighted sums."""
    total: dict[int, float] = defaultdict(float)
    for weights in sums:
        for i, weight in weights.items():
            total[i] += weight / len(sums)
    return total


def _friction(
    a: tuple[Curve, Weights],
    b: tuple[Curve, Weights],
    instruments: tuple[Instruments | None, Instruments | None],
    same: bool,
) -> Difference:
    """Return the difference of weighted sums of |F|."""
    terms, sums, contributions, drifts, errors = [], [], [], [], []
    for (curve, weights), side, known in zip((a, b), (-1.0, 1.0), instruments, strict=True):
        curve_terms = _terms(curve, weights)
        terms += [(side * w, trials) for w, trials in curve_terms]
        errors.append(welch(curve_terms))
        sums.append(sum(w * float(np.mean(trials)) for w, trials in curve_terms))
        drifts.append(sum(w * (curve.points[i].sigma_drift_n or 0.0) for i, w in weights.items()))
        if known is not None:
            points = [
                (w, friction_contributions(curve.points[i], curve.specimen, known))
                for i, w in weights.items()
            ]
            if points[0][1]:
                contributions.append(weighted(points))
    mean_a, mean_b = sums
    error = welch(terms)
    if error is None:
        return untested(mean_a, mean_b, NO_SCATTER)
    both = (contributions[0], contributions[1]) if len(contributions) == 2 else None
    return tested(mean_a, mean_b, *error, both, same, drifts, errors)


def _terms(curve: Curve, weights: Weights) -> list[tuple[float, list[float]]]:
    """Return the independent means, with weights, of a weighted sum of |F| over points.

    Steady runs are independent, so each point's trials form a mean. The points of any other curve
    share their strokes: a trial's sum over the points is then one value.
    """
    points = [(w, curve.points[i]) for i, w in weights.items()]
    if KINDS[curve.kind].has_constant_speed or len(points) == 1:
        return [(w, [sign(curve) * trial for trial in p.trials_n]) for w, p in points]
    by_trial = [dict(zip(p.trials, p.trials_n, strict=True)) for _, p in points]
    common = set.intersection(*map(set, by_trial))
    if not common:
        return [(w, [sign(curve) * p.friction_n]) for w, p in points]
    sums = [
        sign(curve)
        * sum(w * values[trial] for (w, _), values in zip(points, by_trial, strict=True))
        for trial in sorted(common)
    ]
    return [(1.0, sums)]


def _efficiency(
    a: tuple[Curve, EfficiencyCurve],
    b: tuple[Curve, EfficiencyCurve],
    instruments: tuple[Instruments | None, Instruments | None],
    same: bool,
    tolerance: float,
) -> Difference | None:
    """Return the difference of the means over the speeds at which both efficiencies are defined."""
    limit = SPEED_TOLERANCE if b[0].over_velocity else tolerance
    pairs = []
    for point, eta in _with_efficiency(*a):
        for other, eta_b in _with_efficiency(*b):
            if abs(other.v_m_s - point.v_m_s) <= limit * abs(point.v_m_s):
                pairs.append(((point, eta), (other, eta_b)))
    if not pairs:
        return None
    mean_a, mean_b = (
        float(np.mean([pair[side][1].efficiency for pair in pairs])) for side in (0, 1)
    )
    sides = [[pair[side] for pair in pairs] for side in (0, 1)]
    points = sides[0] + sides[1]
    if any(eta.sigma_trials is None for _, eta in points):
        return untested(mean_a, mean_b, NO_SCATTER)
    (se, dof), *errors = (
        satterthwaite(
            [((eta.sigma_trials or 0.0) / len(pairs)) ** 2 for _, eta in some],
            [point.n - 1 for point, _ in some],
        )
        for some in (points, *sides)
    )
    if se <= ROUNDING * max(abs(mean_a), abs(mean_b)):
        return untested(mean_a, mean_b, "no scatter between the trials")
    of_a, of_b = (
        weighted(
            (1 / len(pairs), with_dof(eta.parts, errors_of(point, curve.specimen, known)))
            for point, eta in (pair[side] for pair in pairs)
        )
        if known is not None
        else {}
        for side, curve, known in zip((0, 1), (a[0], b[0]), instruments, strict=True)
    )
    both = (of_a, of_b) if of_a and of_b else None
    drifts = [
        sum(efficiency_drift(eta, point) for point, eta in (pair[side] for pair in pairs))
        / len(pairs)
        for side in (0, 1)
    ]
    return tested(mean_a, mean_b, se, dof, both, same, drifts, errors)


def _with_efficiency(
    curve: Curve, efficiencies: EfficiencyCurve
) -> list[tuple[CurvePoint, EfficiencyPoint]]:
    pairs = zip(curve.points, efficiencies.points, strict=True)
    return [(point, eta) for point, eta in pairs if eta.efficiency is not None]


def _parameters(a: Curve, b: Curve) -> Iterable[FitDifference]:
    for fit_a in a.fits:
        fit_b = next((fit for fit in b.fits if fit.law == fit_a.law), None)
        if fit_b is None:
            continue
        for name, p in fit_a.parameters.items():
            other = fit_b.parameters.get(name)
            if other is None:
                continue
            if KINDS[a.kind].has_constant_speed:
                difference = _parameter_difference(p, other)
            else:
                reason = "the points of a fit share their strokes"
                difference = untested(p.value, other.value, reason)
            yield FitDifference(fit_a.law, name, p.unit, difference)


def _parameter_difference(a: FitParameter, b: FitParameter) -> Difference:
    """Compare two fitted parameters; at a bound or without a standard error there is no test.

    p is that of a normal distribution with the difference's 95 % interval.
    """
    if a.at_bound or b.at_bound:
        return untested(a.value, b.value, "at a bound")
    if a.ci95 is None or b.ci95 is None or not np.isfinite([*a.ci95, *b.ci95]).all():
        return untested(a.value, b.value, "not determined in both")
    half = float(np.hypot((a.ci95[1] - a.ci95[0]) / 2, (b.ci95[1] - b.ci95[0]) / 2))
    if half <= ROUNDING * max(abs(a.value), abs(b.value)):
        return untested(a.value, b.value, "no scatter")
    p_value = float(2 * ndtr(-NORMAL_95 * abs(b.value - a.value) / half))
    return Difference(a.value, b.value, half / NORMAL_95, half, None, p_value)


def _corrected(curves: Sequence[CurveDifference]) -> tuple[CurveDifference, ...]:
    """Correct the p values of each kind for their number: points, means, efficiencies, fits."""
    points = corrected([point.friction_n for curve in curves for point in curve.points])
    means = corrected([curve.mean_n for curve in curves if curve.mean_n])
    etas = corrected([curve.efficiency for curve in curves if curve.efficiency])
    fits = corrected([p.value for curve in curves for p in curve.parameters])
    return tuple(
        replace(
            curve,
            points=tuple(replace(p, friction_n=next(points)) for p in curve.points),
            mean_n=next(means) if curve.mean_n else None,
            efficiency=next(etas) if curve.efficiency else None,
            parameters=tuple(replace(p, value=next(fits)) for p in curve.parameters),
        )
        for curve in curves
    )
