"""Weights of two curves' points in the differences at A's speeds, and in their mean.

B's friction at a speed of A is that of its point there, or linearly interpolated between the two
points around it.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence

from hbench.analysis.comparison.matching import SPEED_TOLERANCE
from hbench.records import Curve

Weights = Mapping[int, float]  # of a curve's points, by their numbers


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
