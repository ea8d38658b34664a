"""Differences between the friction curves of two campaigns.

Curves are compared at A's speeds within B's range. Curves with few speeds, which are points over
pressure, also match at equal pressures, such as those of another bore.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from statistics import fmean
from typing import NamedTuple

import numpy as np
from scipy.special import ndtr

from hbench.analysis.comparison.difference_tests import (
    NO_SCATTER,
    CampaignValue,
    Contributions,
    InstrumentPair,
    Terms,
    corrected,
    tested,
    untested,
    weighted,
    welch,
)
from hbench.analysis.comparison.efficiency_differences import efficiency_difference
from hbench.analysis.comparison.matching import (
    SPEED_TOLERANCE,
    Distinction,
    SetPoint,
    distinction,
    matching_key,
    nearest_set_point,
)
from hbench.analysis.comparison.point_weights import Weights, mean_weights, paired_weights
from hbench.analysis.curves.ramps import sliding
from hbench.analysis.rounding import ROUNDING
from hbench.analysis.uncertainty.budget import friction_contributions
from hbench.config.sensors import Instruments
from hbench.records import (
    DIRECTION_WORDS,
    KINDS,
    Curve,
    CurveDifference,
    Difference,
    EfficiencyCurve,
    FitDifference,
    FitParameter,
    FrictionDifference,
    Results,
)
from hbench.records.numbers import NORMAL_95
from hbench.records.rod_pressure import differs_in_rod_pressure

CurveKey = tuple


class WeightedPoints(NamedTuple):
    """Weighted sum of the points of one campaign's curve."""

    curve: Curve
    weights: Weights  # by the points' numbers


def campaign_differences(
    a: Results,
    b: Results,
    instruments: InstrumentPair,
    tolerance: float = SPEED_TOLERANCE,
) -> tuple[tuple[CurveDifference, ...], tuple[str, ...]]:
    """Compare the curves that both campaigns have; return them, and notes on the other curves.

    Curves are matched by kind, direction, load and rod-side pressure, unless one campaign states
    none; also by label and factors if either campaign has several. ``tolerance`` is the largest
    relative difference of two speeds of points over pressure.
    """
    distinct = distinction(a, b)
    curves_a, curves_b = (
        {_key(curve, distinct): sliding(curve) for curve in results.curves} for results in (a, b)
    )
    etas = [{_key(curve, distinct): curve for curve in results.efficiency} for results in (a, b)]
    rod_pressure = differs_in_rod_pressure((*a.curves, *b.curves)) and distinct.rod_pressures
    compared, notes = [], []
    partners = {key: _partner(curve, key, curves_b) for key, curve in curves_a.items()}
    for key, curve in curves_a.items():
        partner = partners[key]
        if partner is None:
            notes.append(f"{_name(curve, rod_pressure)}: only in A")
            continue
        other = curves_b[partner]
        difference = _curve_difference(curve, other, instruments, tolerance)
        if not difference.points:
            notes.append(
                f"{_name(curve, rod_pressure)}: no speeds in common; {_speeds(curve)} in A and "
                f"{_speeds(other)} in B"
            )
            continue
        if key in etas[0] and partner in etas[1] and KINDS[curve.kind].has_constant_speed:
            pair = (curve, etas[0][key]), (other, etas[1][partner])
            efficiency = efficiency_difference(*pair, instruments, tolerance)
            difference = replace(difference, efficiency=efficiency)
        compared.append(difference)
    paired = set(partners.values())
    unpaired = [curve for key, curve in curves_b.items() if key not in paired]
    notes += [f"{_name(curve, rod_pressure)}: only in B" for curve in unpaired]
    return _corrected(compared), tuple(notes)


def _key(curve: Curve | EfficiencyCurve, distinct: Distinction) -> CurveKey:
    return (*matching_key(curve, distinct), curve.direction, curve.a_ref_m_s2, curve.f_load_n)


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


def _name(curve: Curve, rod_pressure: bool) -> str:
    """Return kind, direction and load of a curve; with the rod-side pressure where it matters."""
    a = "" if curve.a_ref_m_s2 is None else f"{curve.a_ref_m_s2:.3g} m/s^2"
    load = "" if curve.f_load_n is None else f"{curve.f_load_n:.5g} N"
    p_lr = curve.p_lr_ref_pa if rod_pressure else None
    at = "" if p_lr is None else f"at {p_lr / 1e5:.5g} bar"
    return " ".join(
        filter(None, (curve.label, curve.kind, a, DIRECTION_WORDS[curve.direction], load, at))
    )


def _curve_difference(
    a: Curve, b: Curve, instruments: InstrumentPair, tolerance: float
) -> CurveDifference:
    """Compare two curves at A's speeds, in the mean over these, and in their fitted parameters."""

    def difference(weights_a: Weights, weights_b: Weights) -> Difference:
        points = WeightedPoints(a, weights_a), WeightedPoints(b, weights_b)
        return _friction_difference(*points, instruments)

    points = tuple(
        FrictionDifference(
            v_m_s=a.points[next(iter(weights_a))].v_m_s,
            friction_n=difference(weights_a, weights_b),
            between=len(weights_b) > 1,
        )
        for weights_a, weights_b in paired_weights(a, b, tolerance)
    )
    return CurveDifference(
        a=a,
        b=b,
        points=points,
        mean_n=difference(*mean_weights(a, b, tolerance)) if points else None,
        efficiency=None,
        parameters=tuple(_parameters(a, b)),
    )


def _friction_difference(
    a: WeightedPoints, b: WeightedPoints, instruments: InstrumentPair
) -> Difference:
    """Return the difference of weighted sums of |F|."""
    terms_a, terms_b = _terms(a), _terms(b)
    value_a, value_b = (
        _friction_value(points, terms, known)
        for points, terms, known in zip((a, b), (terms_a, terms_b), instruments.both, strict=True)
    )
    error = welch([*((-w, trials) for w, trials in terms_a), *terms_b])
    if error is None:
        return untested(value_a.value, value_b.value, NO_SCATTER)
    return tested(value_a, value_b, *error, instruments)


def _friction_value(
    points: WeightedPoints, terms: Terms, instruments: Instruments | None
) -> CampaignValue:
    """Return one campaign's weighted sum of |F|, with its errors; ``terms`` are its means."""
    curve, weights = points
    return CampaignValue(
        value=sum(w * float(np.mean(trials)) for w, trials in terms),
        instruments=_contributions(points, instruments),
        drift=sum(w * (curve.points[i].sigma_drift_n or 0.0) for i, w in weights.items()),
        trials=welch(terms),
    )


def _contributions(points: WeightedPoints, instruments: Instruments | None) -> Contributions | None:
    """Return the contributions of the instruments; None where they are not known."""
    if instruments is None:
        return None
    curve, weights = points
    parts = [
        (w, friction_contributions(curve.points[i], curve.specimen, instruments))
        for i, w in weights.items()
    ]
    return weighted(parts) if parts[0][1] else None


def _terms(weighted_points: WeightedPoints) -> list[tuple[float, list[float]]]:
    """Return the independent means, with weights, of a weighted sum of |F| over points.

    Steady runs are independent, so each point's trials form a mean. The points of any other curve
    share their strokes: a trial's sum over the points is then one value.
    """
    curve, weights = weighted_points
    points = [(w, curve.points[i]) for i, w in weights.items()]
    if KINDS[curve.kind].has_constant_speed or len(points) == 1:
        return [(w, [curve.against_motion * trial for trial in p.trials_n]) for w, p in points]
    by_trial = [dict(zip(p.trials, p.trials_n, strict=True)) for _, p in points]
    common = set.intersection(*map(set, by_trial))
    if not common:
        return [(w, [curve.against_motion * p.friction_n]) for w, p in points]
    sums = [
        curve.against_motion
        * sum(w * values[trial] for (w, _), values in zip(points, by_trial, strict=True))
        for trial in sorted(common)
    ]
    return [(1.0, sums)]


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
