"""Difference between the efficiencies of two campaigns, as means over the speeds of both."""

import numpy as np

from hbench.analysis.comparison.difference_tests import (
    NO_SCATTER,
    CampaignValue,
    InstrumentPair,
    tested,
    untested,
    weighted,
)
from hbench.analysis.comparison.matching import SPEED_TOLERANCE
from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.student import satterthwaite
from hbench.analysis.summary.drift_uncertainty import efficiency_drift
from hbench.analysis.uncertainty.budget import errors_of, with_dof
from hbench.config.sensors import Instruments
from hbench.records import Curve, CurvePoint, Difference, EfficiencyCurve, EfficiencyPoint

MeasuredEfficiency = tuple[Curve, EfficiencyCurve]  # of one campaign; their points correspond
Points = list[tuple[CurvePoint, EfficiencyPoint]]


def efficiency_difference(
    a: MeasuredEfficiency,
    b: MeasuredEfficiency,
    instruments: InstrumentPair,
    tolerance: float,
) -> Difference | None:
    """Return the difference of the means over the speeds at which both efficiencies are defined.

    None without such speeds. ``tolerance`` is the largest relative difference of two speeds of
    points over pressure.
    """
    points_a, points_b = _at_common_speeds(a, b, tolerance)
    if not points_a:
        return None
    value_a, value_b = (
        _mean_value(points, curve, known)
        for points, (curve, _), known in zip(
            (points_a, points_b), (a, b), instruments.both, strict=True
        )
    )
    if value_a.trials is None or value_b.trials is None:
        return untested(value_a.value, value_b.value, NO_SCATTER)
    se, dof = _error_of_means(points_a + points_b, len(points_a))
    if se <= ROUNDING * max(abs(value_a.value), abs(value_b.value)):
        return untested(value_a.value, value_b.value, "no scatter between the trials")
    return tested(value_a, value_b, se, dof, instruments)


def _at_common_speeds(
    a: MeasuredEfficiency, b: MeasuredEfficiency, tolerance: float
) -> tuple[Points, Points]:
    """Return the points of A and of B with one speed, which correspond."""
    limit = SPEED_TOLERANCE if b[0].over_velocity else tolerance
    pairs = [
        (point_a, point_b)
        for point_a in _with_efficiency(*a)
        for point_b in _with_efficiency(*b)
        if abs(point_b[0].v_m_s - point_a[0].v_m_s) <= limit * abs(point_a[0].v_m_s)
    ]
    return [point_a for point_a, _ in pairs], [point_b for _, point_b in pairs]


def _with_efficiency(curve: Curve, efficiencies: EfficiencyCurve) -> Points:
    pairs = zip(curve.points, efficiencies.points, strict=True)
    return [(point, eta) for point, eta in pairs if eta.efficiency is not None]


def _mean_value(points: Points, curve: Curve, instruments: Instruments | None) -> CampaignValue:
    """Return the mean efficiency of one campaign's points, each with the same weight."""
    n = len(points)
    contributions = None
    if instruments is not None:
        contributions = weighted(
            (1 / n, with_dof(eta.parts, errors_of(point, curve.specimen, instruments)))
            for point, eta in points
        )
    has_scatter = all(eta.sigma_trials is not None for _, eta in points)
    return CampaignValue(
        value=float(np.mean([eta.efficiency for _, eta in points])),
        instruments=contributions or None,
        drift=sum(efficiency_drift(eta, point) for point, eta in points) / n,
        trials=_error_of_means(points, n) if has_scatter else None,
    )


def _error_of_means(points: Points, n: int) -> tuple[float, float]:
    """Return standard error and degrees of freedom of means over n points each, by the trials."""
    variances = [((eta.sigma_trials or 0.0) / n) ** 2 for _, eta in points]
    return satterthwaite(variances, [point.n - 1 for point, _ in points])
