"""Groups of similar values: the speeds or the lengths of strokes that one setting produced."""

import numpy as np

SAME_SPEED = 0.05  # relative gap between measured speeds of one nominal speed


def similar_values(values: np.ndarray, tolerance: float) -> list[np.ndarray]:
    """Return the indices of each group of similar positive ``values`` (n,), rising.

    Neighbours in a group differ by at most ``tolerance``, as a share of the larger one, and are
    not distinct: two values are distinct if they differ by more than 5 %, both were repeated, and
    they differ by more than their repetitions.
    """
    order = np.argsort(values, kind="stable")
    return np.split(order, _gaps(values[order], tolerance))


def _gaps(values: np.ndarray, tolerance: float) -> list[int]:
    """Return the indices at which a new group begins among rising ``values`` (n,)."""
    larger = np.flatnonzero(np.diff(values) > SAME_SPEED * values[1:]) + 1
    ends = [0, *larger.tolist(), len(values)]
    found = []
    for start, at, stop in zip(ends, ends[1:], ends[2:], strict=False):
        gap = values[at] - values[at - 1]
        smaller, greater = values[start:at], values[at:stop]
        distinct = min(len(smaller), len(greater)) > 1 and gap > max(
            np.ptp(smaller), np.ptp(greater)
        )
        if distinct or gap > tolerance * values[at]:
            found.append(at)
    return found
