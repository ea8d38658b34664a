"""Gaps by region of the bench's operation, one axis at a time.

Axes are direction, speed, load, position and time in the run. Speed, load, position and time are
divided at the quartiles of the windows; equal values stay together. For a chamber's flow the
direction determines the metering edge, since the spool is on one side of its centre:

              Tp             Tr             Lp             Lr
    extend    from supply    to tank        to tank        from supply
    retract   to tank        from supply    from supply    to tank
"""

import numpy as np

from hbench.analysis.rounding import merged
from hbench.reconcile.gaps.gap_map import GapMap, gap_of
from hbench.records import Region
from hbench.records.reconcile.diagnosis import REST_M_S

_QUARTERS = 4


def regions(differences: GapMap) -> tuple[Region, ...]:
    """Return the regions of all axes, each in ascending order."""
    speed = np.abs(differences.v_m_s)
    sign = np.where(speed < REST_M_S, 0, np.sign(differences.v_m_s)).astype(int)
    directions = [
        Region("direction", label, *_region(differences, differences.v_m_s, sign == side))
        for side, label in ((-1, "retract"), (0, "rest"), (1, "extend"))
        if np.any(sign == side)
    ]
    axes = {
        "speed_m_s": speed,
        "load_n": differences.load_n,
        "position_m": differences.x_m,
        "time_s": differences.t_s,
    }
    ranges = [
        Region(axis, "", *_region(differences, values, quarter))
        for axis, values in axes.items()
        if np.isfinite(values).any()
        for quarter in _quarters(values)
    ]
    return (*directions, *ranges)


def _quarters(values: np.ndarray) -> list[np.ndarray]:
    """Return masks (w,) of up to four ranges with about equal numbers of windows."""
    values = np.where(np.isfinite(values), merged(np.nan_to_num(values)), np.nan)
    cuts = np.nanquantile(values, np.arange(1, _QUARTERS) / _QUARTERS)
    quarter = np.where(np.isfinite(values), np.searchsorted(np.unique(cuts), values), -1)
    return [quarter == number for number in np.unique(quarter[quarter >= 0])]


def _region(
    differences: GapMap, values: np.ndarray, inside: np.ndarray
) -> tuple[float, float, int, dict[str, float]]:
    gaps = {
        name: float(gap_of(differences.mean_excess((name,), inside))) for name in differences.names
    }
    low, high = float(values[inside].min()), float(values[inside].max())
    return low, high, int(inside.sum()), gaps
