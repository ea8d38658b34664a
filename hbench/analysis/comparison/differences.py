"""Two campaigns side by side: which differences are real, and how large they are.

Trials are independent, so a difference d = sum_i w_i m_i of means over trials has

    se^2 = sum_i w_i^2 s_i^2 / n_i,    dof = se^4 / sum_i (w_i^2 s_i^2 / n_i)^2 / (n_i - 1)

(Welch, Satterthwaite). Instruments are another matter: where both campaigns were measured with the
same ones, an error of theirs is in both and only the difference of its parts stays; with others
both parts count. Curves are compared at A's speeds, where B reaches them.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import ndtr, stdtr

from hbench.analysis.curves.ramps import slid
from hbench.analysis.fitting.fit_data import sign
from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.holm import holm
from hbench.analysis.statistics.student import student_factor
from hbench.analysis.uncertainty.budget import (
    NORMAL_95,
    expanded,
    friction_parts,
    parts_of_mean,
    together,
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

SAME_SPEED = 0.02  # relative difference of two speeds that are the same reference
Parts = dict[str, float]
Weights = Mapping[int, float]  # of a curve's points, by their numbers
Terms = Sequence[tuple[float, Sequence[float]]]  # weight of a mean, and its trials


def welch(terms: Terms) -> tuple[float, float] | None:
    """Return standard error and degrees of freedom of sum_i w_i mean(trials_i).

    None where a mean has fewer than two trials, or where no trials differ by more than rounding.
    """
    if any(len(trials) < 2 for _, trials in terms):
        return None
    of_means = np.array([w**2 * np.var(trials, ddof=1) / len(trials) for w, trials in terms])
    total = float(of_means.sum())
    if np.sqrt(total) <= ROUNDING * sum(abs(w) * np.abs(trials).max() for w, trials in terms):
        return None
    dof = np.array([len(trials) - 1 for _, trials in terms])
    return float(np.sqrt(total)), float(total**2 / np.sum(of_means**2 / dof))


def differences(
    a: Results,
    b: Results,
    instruments: tuple[Instruments | None, Instruments | None],
    same_instruments: bool,
) -> tuple[tuple[CurveDifference, ...], tuple[str, ...]]:
    """Compare the curves that both campaigns have; return them, and notes on what has no rival.

    Curves belong together by kind, direction, load and rod-side pressure; by label where either
    campaign has several.
    """
    labels = any(len({curve.label for curve in one.curves}) > 1 for one in (a, b))
    ours, theirs = ({_key(curve, labels): slid(curve) for curve in one.curves} for one in (a, b))
    etas = [{_key(curve, labels): curve for curve in one.efficiency} for one in (a, b)]
    compared, notes = [], []
    for key, curve in ours.items():
        if key not in theirs:
            continue
        found = _curves(curve, theirs[key], instruments, same_instruments)
        if not found.points:
            notes.append(f"{_words(curve)}: the two campaigns have no speeds in common")
            continue
        if all(key in one for one in etas) and KINDS[curve.kind].has_constant_speed:
            pair = (curve, etas[0][key]), (theirs[key], etas[1][key])
            found = replace(found, efficiency=_efficiency(*pair, same_instruments))
        compared.append(found)
    for name, own, other in (("A", ours, theirs), ("B", theirs, ours)):
        notes += [f"{_words(c)}: only in {name}" for key, c in own.items() if key not in other]
    return _corrected(compared), tuple(notes)


def _key(curve: Curve | EfficiencyCurve, labels: bool) -> tuple:
    own = curve.kind, curve.direction, curve.f_load_n, curve.p_lr_ref_pa, curve.a_ref_m_s2
    return (*own, curve.label) if labels else own


def _words(curve: Curve) -> str:
    a = "" if curve.a_ref_m_s2 is None else f"{curve.a_ref_m_s2:.3g} m/s^2"
    load = "" if curve.f_load_n is None else f"{curve.f_load_n:g} N"
    return " ".join(filter(None, (curve.label, curve.kind, a, curve.direction, load)))


def _curves(
    a: Curve, b: Curve, known: tuple[Instruments | None, Instruments | None], same: bool
) -> CurveDifference:
    weights = [({i: 1.0}, _weights(abs(point.v_m_s), b)) for i, point in enumerate(a.points)]
    weights = [(of_a, of_b) for of_a, of_b in weights if of_b]
    points = tuple(
        FrictionDifference(
            v_m_s=a.points[next(iter(of_a))].v_m_s,
            friction_n=_friction((a, of_a), (b, of_b), known, same),
            between=len(of_b) > 1,
        )
        for of_a, of_b in weights
    )
    means = tuple(_mean_weights([pair[side] for pair in weights]) for side in (0, 1))
    return CurveDifference(
        a=a,
        b=b,
        points=points,
        mean_n=_friction((a, means[0]), (b, means[1]), known, same) if points else None,
        efficiency=None,
        parameters=tuple(_parameters(a, b)),
    )


def _weights(speed: float, curve: Curve) -> Weights:
    """Return the point of a curve at a speed, or the two around it, by number with weights."""
    v = [abs(point.v_m_s) for point in curve.points]
    near = min(range(len(v)), key=lambda i: abs(v[i] - speed))
    if abs(v[near] - speed) <= SAME_SPEED * speed:
        return {near: 1.0}
    low = max((i for i in range(len(v)) if v[i] < speed), key=lambda i: v[i], default=None)
    high = min((i for i in range(len(v)) if v[i] > speed), key=lambda i: v[i], default=None)
    if low is None or high is None:
        return {}
    share = (speed - v[low]) / (v[high] - v[low])
    return {low: 1.0 - share, high: share}


def _mean_weights(found: Sequence[Weights]) -> Weights:
    """Return the weights of the mean of weighted sums."""
    total: dict[int, float] = defaultdict(float)
    for weights in found:
        for i, weight in weights.items():
            total[i] += weight / len(found)
    return total


def _friction(
    a: tuple[Curve, Weights],
    b: tuple[Curve, Weights],
    known: tuple[Instruments | None, Instruments | None],
    same: bool,
) -> Difference:
    """Return the difference of weighted sums of |F|."""
    terms, sums, parts = [], [], []
    for (curve, weights), side, instruments in zip((a, b), (-1.0, 1.0), known, strict=True):
        own = _terms(curve, weights)
        terms += [(side * w, trials) for w, trials in own]
        sums.append(sum(w * float(np.mean(trials)) for w, trials in own))
        if instruments is not None:
            each = [
                (w, friction_parts(curve.points[i], curve.specimen, instruments))
                for i, w in weights.items()
            ]
            names = each[0][1]
            parts.append({name: sum(w * one[name] for w, one in each) for name in names})
    mean_a, mean_b = sums
    found = welch(terms)
    if found is None:
        return _untested(mean_a, mean_b, "no scatter: a single trial")
    both = (parts[0], parts[1]) if len(parts) == 2 else None
    return _tested(mean_a, mean_b, *found, both, same)


def _terms(curve: Curve, weights: Weights) -> list[tuple[float, list[float]]]:
    """Return the means, with weights, that a weighted sum of |F| over points is made of.

    Steady runs are made one by one, so each point's trials are a mean of their own. The points of
    any other curve share their strokes: there a trial's sum over the points is one value.
    """
    points = [(w, curve.points[i]) for i, w in weights.items()]
    if KINDS[curve.kind].has_constant_speed or len(points) == 1:
        return [(w, [sign(curve) * trial for trial in p.trials_n]) for w, p in points]
    of_trials = [dict(zip(p.trials, p.trials_n, strict=True)) for _, p in points]
    common = set.intersection(*map(set, of_trials))
    if not common:
        return [(w, [sign(curve) * p.friction_n]) for w, p in points]
    sums = [
        sign(curve) * sum(w * found[trial] for (w, _), found in zip(points, of_trials, strict=True))
        for trial in sorted(common)
    ]
    return [(1.0, sums)]


def _untested(a: float, b: float, why: str) -> Difference:
    return Difference(a, b, None, None, None, None, untested=why)


def _tested(
    a: float, b: float, se: float, dof: float, parts: tuple[Parts, Parts] | None, same: bool
) -> Difference:
    ci95 = student_factor(dof) * se
    return Difference(
        a=a,
        b=b,
        se=se,
        ci95=float(ci95),
        u95=None if parts is None else expanded(float(ci95), _of_instruments(*parts, same)),
        p_value=float(2 * stdtr(dof, -abs(b - a) / se)),
    )


def _of_instruments(a: Parts, b: Parts, same: bool) -> float:
    if not same:
        return float(np.hypot(together(a), together(b)))
    names = {*a, *b}
    return together({name: b.get(name, 0.0) - a.get(name, 0.0) for name in names})


def _efficiency(
    a: tuple[Curve, EfficiencyCurve], b: tuple[Curve, EfficiencyCurve], same: bool
) -> Difference | None:
    """Return the difference of the means over the speeds at which both have an efficiency."""
    pairs = []
    for point, eta in _with_efficiency(*a):
        for other, eta_b in _with_efficiency(*b):
            if abs(other.v_m_s - point.v_m_s) <= SAME_SPEED * abs(point.v_m_s):
                pairs.append(((point, eta), (other, eta_b)))
    if not pairs:
        return None
    mean_a, mean_b = (
        float(np.mean([pair[side][1].efficiency for pair in pairs])) for side in (0, 1)
    )
    each = [one for pair in pairs for one in pair]
    if any(eta.sigma_trials is None for _, eta in each):
        return _untested(mean_a, mean_b, "no scatter: a single trial")
    variance = np.array([(eta.sigma_trials / len(pairs)) ** 2 for _, eta in each])
    total = float(variance.sum())
    if np.sqrt(total) <= ROUNDING * max(abs(mean_a), abs(mean_b)):
        return _untested(mean_a, mean_b, "no scatter between the trials")
    dof = total**2 / np.sum(variance**2 / np.array([point.n - 1 for point, _ in each]))
    parts_a, parts_b = (parts_of_mean([pair[side][1].parts for pair in pairs]) for side in (0, 1))
    both = (parts_a, parts_b) if parts_a and parts_b else None
    return _tested(mean_a, mean_b, float(np.sqrt(total)), float(dof), both, same)


def _with_efficiency(
    curve: Curve, found: EfficiencyCurve
) -> list[tuple[CurvePoint, EfficiencyPoint]]:
    pairs = zip(curve.points, found.points, strict=True)
    return [(point, eta) for point, eta in pairs if eta.efficiency is not None]


def _parameters(a: Curve, b: Curve) -> Iterable[FitDifference]:
    for ours in a.fits:
        theirs = next((fit for fit in b.fits if fit.law == ours.law), None)
        if theirs is None:
            continue
        for name, p in ours.parameters.items():
            other = theirs.parameters.get(name)
            if other is None:
                continue
            if KINDS[a.kind].has_constant_speed:
                found = _of_fits(p, other)
            else:
                found = _untested(p.value, other.value, "the points of a fit share their strokes")
            yield FitDifference(ours.law, name, p.unit, found)


def _of_fits(a: FitParameter, b: FitParameter) -> Difference:
    """Compare two fitted numbers; at a bound or without a standard error there is no test.

    p is that of a normal distribution whose 95 % interval is that of the difference.
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


def _corrected(found: Sequence[CurveDifference]) -> tuple[CurveDifference, ...]:
    """Correct the p values of each kind for their number: points, means, efficiencies, fits."""
    points = _holm([point.friction_n for one in found for point in one.points])
    means = _holm([one.mean_n for one in found])
    etas = _holm([one.efficiency for one in found])
    fits = _holm([p.value for one in found for p in one.parameters])
    return tuple(
        replace(
            one,
            points=tuple(replace(p, friction_n=next(points)) for p in one.points),
            mean_n=next(means),
            efficiency=next(etas),
            parameters=tuple(replace(p, value=next(fits)) for p in one.parameters),
        )
        for one in found
    )


def _holm(found: Sequence[Difference | None]) -> Iterator[Difference | None]:
    """Yield the differences with corrected p values; those without a test as they are."""
    tested = [d is not None and d.p_value is not None for d in found]
    p_holm = iter(holm([d.p_value for d, test in zip(found, tested, strict=True) if test]))
    for difference, test in zip(found, tested, strict=True):
        yield replace(difference, p_holm=float(next(p_holm))) if test else difference
