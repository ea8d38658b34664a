"""Where in the bench's operation a balance lacks something: gaps by region, one axis at a time.

Axes are direction, speed, load, position and time in the run. Speed, load, position and time are
cut where a quarter of the windows lies, equal values staying together. With the direction a
chamber's flow tells its metering edge, for a valve's spool stands to one side of its middle:

              Tp             Tr             Lp             Lr
    extend    from supply    to tank        to tank        from supply
    retract   to tank        from supply    from supply    to tank
"""

import numpy as np

from hbench.analysis.rounding import merged
from hbench.reconcile.gap import GapMap
from hbench.records import Region

REST_M_S = 2e-3
_PARTS = 4


def regions(found: GapMap) -> tuple[Region, ...]:
    """Return the regions of all axes, each by rising values."""
    speed = np.abs(found.v_m_s)
    sign = np.where(speed < REST_M_S, 0, np.sign(found.v_m_s)).astype(int)
    ways = [
        Region("direction", label, *_region(found, found.v_m_s, sign == side))
        for side, label in ((-1, "retract"), (0, "rest"), (1, "extend"))
        if np.any(sign == side)
    ]
    axes = {
        "speed_m_s": speed,
        "load_n": found.load_n,
        "position_m": found.x_m,
        "time_s": found.t_s,
    }
    stretches = [
        Region(axis, "", *_region(found, values, part))
        for axis, values in axes.items()
        if np.isfinite(values).any()
        for part in _parts(values)
    ]
    return (*ways, *stretches)


def _parts(values: np.ndarray) -> list[np.ndarray]:
    """Return masks (w,) of up to four stretches with about as many windows each."""
    values = np.where(np.isfinite(values), merged(np.nan_to_num(values)), np.nan)
    cuts = np.nanquantile(values, np.arange(1, _PARTS) / _PARTS)
    place = np.where(np.isfinite(values), np.searchsorted(np.unique(cuts), values), -1)
    return [place == number for number in np.unique(place[place >= 0])]


def _region(
    found: GapMap, values: np.ndarray, own: np.ndarray
) -> tuple[float, float, int, dict[str, float]]:
    gaps = found.over(np.where(own, 0, -1))[0].tolist()
    low, high = float(values[own].min()), float(values[own].max())
    return low, high, int(own.sum()), dict(zip(found.names, gaps, strict=True))
