"""Differences between two campaigns, with their significance.

Trials are independent, so a difference d = sum_i w_i m_i of means over trials has

    se^2 = sum_i w_i^2 s_i^2 / n_i,    dof = se^4 / sum_i (w_i^2 s_i^2 / n_i)^2 / (n_i - 1)

(Welch, Satterthwaite). For the instruments: if both campaigns were measured with the same ones,
their errors are in both, and only the difference of the contributions counts; with different ones
both contributions count. Curves are compared at A's speeds within B's range.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtr, stdtr

from hbench.analysis.curves.ramps import sliding
from hbench.analysis.fitting.fit_data import sign
from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.holm import holm
from hbench.analysis.statistics.student import student_factor
from hbench.analysis.uncertainty.budget import (
    expanded,
    friction_contributions,
    mean_contributions,
    root_sum_square,
)
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

SPEED_TOLERANCE = 0.02  # largest relative difference of two speeds with the same reference
Contributions = dict[str, float]  # of instruments
Weights = Mapping[int, float]  # of a curve's points, by their numbers
Terms = Sequence[tuple[float, Sequence[float]]]  # weight of a mean, and its trials


def welch(terms: Terms) -> tuple[float, float] | None:
    """Return standard error and degrees of freedom of sum_i w_i mean(trials_i).

    None if a mean has fewer than two trials, or if no trials differ by more than rounding.
    """
    if any(len(trials) < 2 for _, trials in terms):
        return None
    variances = np.array([w**2 * np.var(trials, ddof=1) / len(trials) for w, trials in terms])
    total = float(variances.sum())
    if np.sqrt(total) <= ROUNDING * sum(abs(w) * np.abs(trials).max() for w, trials in terms):
        return None
    dof = np.array([len(trials) - 1 for _, trials in terms])
    return float(np.sqrt(total)), float(total**2 / np.sum(variances**2 / dof))


def campaign_differences(
    a: Results,
    b: Results,
    instruments: tuple[Instruments | None, Instruments | None],
    same_instruments: bool,
) -> tuple[tuple[CurveDifference, ...], tuple[str, ...]]:
    """Compare the curves that both campaigns have; return them, and notes on the other curves.

    Curves are matched by kind, direction, load and rod-side pressure; also by label if either
    campaign has several.
    """
    labels = any(len({curve.label for curve in results.curves}) > 1 for results in (a, b))
    curves_a, curves_b = (
        {_key(curve, labels): sliding(curve) for curve in results.curves} for results in (a, b)
    )
    etas = [{_key(curve, labels): curve for curve in results.efficiency} for results in (a, b)]
    compared, notes = [], []
    for key, curve in curves_a.items():
        if key not in curves_b:
            continue
        difference = _curves(curve, curves_b[key], instruments, same_instruments)
        if not difference.points:
            notes.append(f"{_name(curve)}: the campaigns have no speeds in common")
            continue
        if all(key in curves for curves in etas) and KINDS[curve.kind].has_constant_speed:
            pair = (curve, etas[0][key]), (curves_b[key], etas[1][key])
            difference = replace(difference, efficiency=_efficiency(*pair, same_instruments))
        compared.append(difference)
    for name, curves, others in (("A", curves_a, curves_b), ("B", curves_b, curves_a)):
        notes += [f"{_name(c)}: only in {name}" for key, c in curves.items() if key not in others]
    return _corrected(compared), tuple(notes)


def _key(curve: Curve | EfficiencyCurve, labels: bool) -> tuple:
    reference = curve.kind, curve.direction, curve.f_load_n, curve.p_lr_ref_pa, curve.a_ref_m_s2
    return (*reference, curve.label) if labels else reference


def _name(curve: Curve) -> str:
    a = "" if curve.a_ref_m_s2 is None else f"{curve.a_ref_m_s2:.3g} m/s^2"
    load = "" if curve.f_load_n is None else f"{curve.f_load_n:g} N"
    return " ".join(filter(None, (curve.label, curve.kind, a, curve.direction, load)))


def _curves(
    a: Curve, b: Curve, instruments: tuple[Instruments | None, Instruments | None], same: bool
) -> CurveDifference:
    weights = [({i: 1.0}, _weights(abs(point.v_m_s), b)) for i, point in enumerate(a.points)]
    weights = [(weights_a, weights_b) for weights_a, weights_b in weights if weights_b]
    points = tuple(
        FrictionDifference(
            v_m_s=a.points[next(iter(weights_a))].v_m_s,
            friction_n=_friction((a, weights_a), (b, weights_b), instruments, same),
            between=len(weights_b) > 1,
        )
        for weights_a, weights_b in weights
    )
    means = tuple(_mean_weights([pair[side] for pair in weights]) for side in (0, 1))
    return CurveDifference(
        a=a,
        b=b,
        points=points,
        mean_n=_friction((a, means[0]), (b, means[1]), instruments, same) if points else None,
        efficiency=None,
        parameters=tuple(_parameters(a, b)),
    )


def _weights(speed: float, curve: Curve) -> Weights:
    """Return the weights of the point at a speed, or of its two neighbours, by their numbers."""
    v = [abs(point.v_m_s) for point in curve.points]
    near = min(range(len(v)), key=lambda i: abs(v[i] - speed))
    if abs(v[near] - speed) <= SPEED_TOLERANCE * speed:
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
    terms, sums, contributions = [], [], []
    for (curve, weights), side, known in zip((a, b), (-1.0, 1.0), instruments, strict=True):
        curve_terms = _terms(curve, weights)
        terms += [(side * w, trials) for w, trials in curve_terms]
        sums.append(sum(w * float(np.mean(trials)) for w, trials in curve_terms))
        if known is not None:
            points = [
                (w, friction_contributions(curve.points[i], curve.specimen, known))
                for i, w in weights.items()
            ]
            names = points[0][1]
            contributions.append({n: sum(w * point[n] for w, point in points) for n in names})
    mean_a, mean_b = sums
    error = welch(terms)
    if error is None:
        return _untested(mean_a, mean_b, "no scatter: a single trial")
    both = (contributions[0], contributions[1]) if len(contributions) == 2 else None
    return _tested(mean_a, mean_b, *error, both, same)


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


def _untested(a: float, b: float, reason: str) -> Difference:
    return Difference(a, b, None, None, None, None, untested=reason)


def _tested(
    a: float,
    b: float,
    se: float,
    dof: float,
    contributions: tuple[Contributions, Contributions] | None,
    same: bool,
) -> Difference:
    ci95 = student_factor(dof) * se
    return Difference(
        a=a,
        b=b,
        se=se,
        ci95=float(ci95),
        u95=None
        if contributions is None
        else expanded(float(ci95), _instruments_sigma(*contributions, same)),
        p_value=float(2 * stdtr(dof, -abs(b - a) / se)),
    )


def _instruments_sigma(a: Contributions, b: Contributions, same: bool) -> float:
    if not same:
        return float(np.hypot(root_sum_square(a), root_sum_square(b)))
    names = {*a, *b}
    return root_sum_square({name: b.get(name, 0.0) - a.get(name, 0.0) for name in names})


def _efficiency(
    a: tuple[Curve, EfficiencyCurve], b: tuple[Curve, EfficiencyCurve], same: bool
) -> Difference | None:
    """Return the difference of the means over the speeds at which both efficiencies are defined."""
    pairs = []
    for point, eta in _with_efficiency(*a):
        for other, eta_b in _with_efficiency(*b):
            if abs(other.v_m_s - point.v_m_s) <= SPEED_TOLERANCE * abs(point.v_m_s):
                pairs.append(((point, eta), (other, eta_b)))
    if not pairs:
        return None
    mean_a, mean_b = (
        float(np.mean([pair[side][1].efficiency for pair in pairs])) for side in (0, 1)
    )
    points = [point for pair in pairs for point in pair]
    errors = [eta.sigma_trials for _, eta in points if eta.sigma_trials is not None]
    if len(errors) < len(points):
        return _untested(mean_a, mean_b, "no scatter: a single trial")
    variance = np.array([(error / len(pairs)) ** 2 for error in errors])
    total = float(variance.sum())
    if np.sqrt(total) <= ROUNDING * max(abs(mean_a), abs(mean_b)):
        return _untested(mean_a, mean_b, "no scatter between the trials")
    dof = total**2 / np.sum(variance**2 / np.array([point.n - 1 for point, _ in points]))
    of_a, of_b = (mean_contributions([pair[side][1].parts for pair in pairs]) for side in (0, 1))
    both = (of_a, of_b) if of_a and of_b else None
    return _tested(mean_a, mean_b, float(np.sqrt(total)), float(dof), both, same)


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
                difference = _untested(p.value, other.value, reason)
            yield FitDifference(fit_a.law, name, p.unit, difference)


def _parameter_difference(a: FitParameter, b: FitParameter) -> Difference:
    """Compare two fitted parameters; at a bound or without a standard error there is no test.

    p is that of a normal distribution with the difference's 95 % interval.
    """
    if a.at_bound or b.at_bound:
        return _untested(a.value, b.value, "at a bound")
    if a.ci95 is None or b.ci95 is None or not np.isfinite([*a.ci95, *b.ci95]).all():
        return _untested(a.value, b.value, "not determined in both")
    half = float(np.hypot((a.ci95[1] - a.ci95[0]) / 2, (b.ci95[1] - b.ci95[0]) / 2))
    if half <= ROUNDING * max(abs(a.value), abs(b.value)):
        return _untested(a.value, b.value, "no scatter")
    p_value = float(2 * ndtr(-NORMAL_95 * abs(b.value - a.value) / half))
    return Difference(a.value, b.value, half / NORMAL_95, half, None, p_value)


def _corrected(curves: Sequence[CurveDifference]) -> tuple[CurveDifference, ...]:
    """Correct the p values of each kind for their number: points, means, efficiencies, fits."""
    points = _holm([point.friction_n for curve in curves for point in curve.points])
    means = _holm([curve.mean_n for curve in curves if curve.mean_n])
    etas = _holm([curve.efficiency for curve in curves if curve.efficiency])
    fits = _holm([p.value for curve in curves for p in curve.parameters])
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


def _holm(differences: Sequence[Difference]) -> Iterator[Difference]:
    """Yield the differences with corrected p values, if they have one."""
    p_values = [difference.p_value for difference in differences]
    corrected = iter(holm([p for p in p_values if p is not None]).tolist())
    for difference, p in zip(differences, p_values, strict=True):
        yield difference if p is None else replace(difference, p_holm=next(corrected))
