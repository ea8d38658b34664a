"""The steady section of a run: the samples at the reference, and the window to average."""

import numpy as np

from hbench.analysis.rounding import ROUNDING
from hbench.analysis.screening.steadiness import BLOCK_S, BlockSpeeds, block_speeds
from hbench.config.schedule import Screening
from hbench.records import Run

NOTHING = slice(0, 0)
_SETTLED = 0.10  # of its median speed: tolerance for a settled stroke without reference


def at_reference(run: Run) -> slice:
    """Return the samples at the reference speed.

    The board marks them. In an imported log they extend from the first to the last 0.1 s in which
    the speed is within 10 % of the stroke's median (of its middle half), so that acceleration and
    deceleration are cut off.
    """
    if run.at_reference is None:
        return _settled(run)
    marked = np.flatnonzero(run.at_reference)
    return slice(marked[0], marked[-1] + 1) if len(marked) else NOTHING


def steady_window(run: Run, section: slice, rules: Screening) -> slice:
    """Return the window: ``section`` after ``settle_time`` and after ``settle_travel``.

    Both are needed, because pressures settle in time but the seals' presliding settles in travel.
    """
    t, x = run.t_s[section], run.x_m[section]
    if not len(t):
        return NOTHING
    in_time = t - t[0] >= rules.settle_time - ROUNDING
    settled = in_time & (np.abs(x - x[0]) >= rules.settle_travel - ROUNDING)
    if not settled.any():
        return NOTHING
    return slice(section.start + int(np.argmax(settled)), section.stop)


def window_length_s(run: Run, window: slice) -> float:
    """Return the time that a window's samples cover: n sampling intervals."""
    t = run.t_s[window]
    return float((t[-1] - t[0]) * len(t) / (len(t) - 1)) if len(t) > 1 else 0.0


def standstill_s(run: Run, section: slice) -> float:
    """Return the time [s] that the piston is at rest at the end of ``section``, after motion.

    It is zero if the piston moves at the end, or was at rest in between (stick-slip).
    """
    v_ref = abs(run.plan.v_ref_m_s)
    speeds = block_speeds(run.t_s[: section.stop], run.x_m[: section.stop])
    slow = max(0.1 * v_ref, 3 * speeds.noise_m_s)
    moving = np.flatnonzero(np.abs(speeds.v_m_s) > max(0.5 * v_ref, slow))
    if not len(moving):
        return 0.0
    at_rest = np.abs(speeds.v_m_s) < slow
    tail = len(at_rest) if at_rest.all() else int(np.argmin(at_rest[::-1]))
    before = at_rest[moving[0] : len(at_rest) - tail]
    return 0.0 if before.any() else tail * BLOCK_S


def _settled(run: Run) -> slice:
    speeds = block_speeds(run.t_s, run.x_m)
    steady = np.flatnonzero(_near_median(speeds))
    if not len(steady):
        return NOTHING
    first, last = speeds.t_s[steady[[0, -1]]]
    # Deceleration can begin within the two blocks of the last speed, so both are left out.
    start, stop = np.searchsorted(run.t_s, [first, last - BLOCK_S])
    return slice(int(start), int(stop))


def _near_median(speeds: BlockSpeeds) -> np.ndarray:
    v = speeds.v_m_s
    if not len(v):
        return np.zeros(0, dtype=bool)
    quarter = len(v) // 4
    median = np.median(v[quarter : len(v) - quarter])
    near = max(_SETTLED * abs(median), 3 * speeds.noise_m_s)
    return np.abs(v - median) <= near + ROUNDING * abs(median)
