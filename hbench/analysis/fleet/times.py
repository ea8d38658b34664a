"""Times of the campaigns of a fleet: dates, or else their order."""

from dataclasses import dataclass

import numpy as np

_DAY_S = 86_400.0


@dataclass(frozen=True)
class Times:
    """Times of the campaigns; arrays (rows,)."""

    by_date: bool  # whether all compared campaigns have dates, which differ
    first: float  # moment [s] of the first and the last compared campaign; 0 without dates
    last: float
    at: np.ndarray  # days since the first, or without dates the number in the order of paths
    days: np.ndarray  # days since the first one with a date; NaN for those without


def times_of(moments: np.ndarray, compared: np.ndarray) -> Times:
    """Return the times of the campaigns from their moments (rows,) in s."""
    known = moments[compared]
    earliest = np.min(known, initial=np.inf, where=np.isfinite(known))
    days = (moments - earliest) / _DAY_S
    if not len(known) or not np.isfinite(known).all() or not np.ptp(known) > 0:
        return Times(False, 0.0, 0.0, np.cumsum(compared).astype(float), days)
    first, last = float(known.min()), float(known.max())
    return Times(True, first, last, (moments - first) / _DAY_S, days)
