"""Part of a difference of mean friction that the campaigns' own drifts account for.

A drift is a straight line over a campaign's time, with the change D from its first run to its last.
The point i of a campaign, measured at the time t_i, deviates from its friction at the campaign's
mean time t by s_i D F_i, with s_i = (t_i - t) / span, and F_i = 1 for a drift in N. In a difference
of means with the weights w_i, summed over the curves,

    c = sum_i w_i s_i F_i,   e = c_B D_B - c_A D_A,   h^2 = (c_B h_B)^2 + (c_A h_A)^2

h being half-widths of 95 % intervals; the two estimates are independent. If both campaigns have the
same order of runs, c_A = c_B nearly, and a drift common to both cancels. Over all curves the sum of
s_i is zero, so that a drift cancels within each campaign.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import hypot
from statistics import fmean

from hbench.analysis.comparison.difference_tests import (
    InstrumentPair,
    WeightedCurve,
    mean_difference_u95,
    mean_u95,
    mean_with_test,
)
from hbench.analysis.comparison.point_weights import Weights, mean_weights, paired_weights
from hbench.analysis.summary.run_clock import RunClock, campaign_place
from hbench.records import (
    KINDS,
    Curve,
    CurveDifference,
    Drift,
    DriftEffect,
    MeanAtSpeed,
    MeanOfCurves,
    Results,
)

_SAME_SPEED = 0.02  # relative, as of two points that are compared


def with_drift_effects(
    curves: Sequence[CurveDifference],
    results: tuple[Results, Results],
    clocks: tuple[RunClock, RunClock],
    instruments: InstrumentPair,
    tolerance: float,
) -> tuple[tuple[CurveDifference, ...], MeanOfCurves | None]:
    """Return the steady curves' differences with their ``drift_n``, and the mean of these curves.

    ``results``, ``clocks`` and ``instruments`` are those of A and B, the others as in
    ``campaign_differences``.
    The drift is left out where that of a campaign is not known, or is extrapolated from neighbours
    in an order of the runs that may be that of their files.
    """
    steady = [curve for curve in curves if _is_steady(curve.a) and curve.mean_n is not None]
    drift_a, drift_b = (each.drift for each in results)
    if not steady:
        return tuple(curves), None
    others = clocks, instruments, tolerance
    if drift_a is None or drift_b is None or drift_a.of_unknown_size or drift_b.of_unknown_size:
        return tuple(curves), _mean_of_curves(steady, None, *others)
    places = [
        campaign_place(filter(_is_steady, each.curves), clock)
        for each, clock in zip(results, clocks, strict=True)
    ]

    def coefficient(side: int, drift: Drift, members: Sequence[CurveDifference]) -> float:
        total = 0.0
        for member in members:
            curve = (member.a, member.b)[side]
            for i, weight in mean_weights(member.a, member.b, tolerance)[side].items():
                point = curve.points[i]
                force = abs(point.friction_n) if drift.scale == "relative" else 1.0
                total += weight * places[side](point) * force / len(members)
        return total

    def effect(members: Sequence[CurveDifference]) -> DriftEffect:
        c_a, c_b = coefficient(0, drift_a, members), coefficient(1, drift_b, members)
        value = c_b * drift_b.change - c_a * drift_a.change
        return DriftEffect(value, hypot(c_b * drift_b.change_ci95, c_a * drift_a.change_ci95))

    changed = tuple(
        replace(curve, drift_n=effect([curve])) if curve in steady else curve for curve in curves
    )
    return changed, _mean_of_curves(steady, effect(steady), *others)


def _mean_of_curves(
    curves: Sequence[CurveDifference],
    drift_n: DriftEffect | None,
    clocks: tuple[RunClock, RunClock],
    instruments: InstrumentPair,
    tolerance: float,
) -> MeanOfCurves | None:
    """Return the mean difference; None for one curve, or without an interval by the trials."""
    means = [curve.mean_n for curve in curves if curve.mean_n is not None]
    if len(means) < 2:
        return None
    value, a_n = fmean(mean.value for mean in means), fmean(mean.a for mean in means)
    members = [mean_weights(curve.a, curve.b, tolerance) for curve in curves]
    both = list(_both(curves, members, clocks))
    test = mean_with_test(value, both)
    if test is None:
        return None
    ci95_n, p_value = test
    u95 = mean_difference_u95(both, instruments)
    u95_a, u95_b = (
        mean_u95([each for each in both if sign * each.factor > 0], known)
        for sign, known in zip((-1, 1), instruments.both, strict=True)
    )
    speeds = tuple(_at_speeds(curves, clocks, instruments, tolerance))
    half = ci95_n if u95 is None else u95
    return MeanOfCurves(
        value, half, a_n, len(means), ci95_n, p_value, drift_n, speeds, u95_a, u95_b
    )


def _both(
    curves: Sequence[CurveDifference],
    members: Sequence[tuple[Weights, Weights]],
    clocks: tuple[RunClock, RunClock],
) -> Iterator[WeightedCurve]:
    """Yield the curves of A and of B with their weights in the mean difference over all."""
    for curve, (of_a, of_b) in zip(curves, members, strict=True):
        yield WeightedCurve(-1 / len(curves), curve.a, of_a, clocks[0].setups)
        yield WeightedCurve(1 / len(curves), curve.b, of_b, clocks[1].setups)


def _at_speeds(
    curves: Sequence[CurveDifference],
    clocks: tuple[RunClock, RunClock],
    instruments: InstrumentPair,
    tolerance: float,
) -> Iterator[MeanAtSpeed]:
    """Yield the mean over the curves at each speed; none where their speeds are not the same."""
    if len({len(curve.points) for curve in curves}) > 1:
        return
    weights = (paired_weights(curve.a, curve.b, tolerance) for curve in curves)
    of_speeds = zip(*weights, strict=True)
    all_points = zip(*(curve.points for curve in curves), strict=True)
    for points, members in zip(all_points, of_speeds, strict=False):
        speeds = [abs(point.v_m_s) for point in points]
        value = fmean(point.friction_n.value for point in points)
        both = list(_both(curves, members, clocks))
        mean = mean_with_test(value, both)
        if mean is None or max(speeds) > (1 + _SAME_SPEED) * min(speeds):
            return
        u95 = mean_difference_u95(both, instruments)
        yield MeanAtSpeed(fmean(speeds), value, mean[0], u95)


def _is_steady(curve: Curve) -> bool:
    return KINDS[curve.kind].has_constant_speed
