"""Where in a run the motion is steady: the part at the reference, and the window to average."""

import numpy as np

from hbench.analysis.rounding import ROUNDING
from hbench.analysis.screening.steadiness import BLOCK_S, BlockSpeeds, block_speeds
from hbench.config.schedule import Screening
from hbench.records import Run

NOTHING = slice(0, 0)
_SETTLED = 0.10  # a stroke without reference has settled within this share of its usual speed


def at_reference(run: Run) -> slice:
    """Return the samples that were made at the reference speed.

    The board marks them. In a foreign log they reach from the first to the last 0.1 s in which
    the speed is within 10 % of the stroke's usual one (the median of its middle half), so that
    acceleration and deceleration are cut.
    """
    if run.at_reference is None:
        return _settled(run)
    marked = np.flatnonzero(run.at_reference)
    return slice(marked[0], marked[-1] + 1) if len(marked) else NOTHING


def steady_window(run: Run, part: slice, rules: Screening) -> slice:
    """Return the window: ``part`` after ``settle_time`` and after ``settle_travel``.

    Both, because pressures settle in time but the seals' presliding settles in travel.
    """
    t, x = run.t_s[part], run.x_m[part]
    if not len(t):
        return NOTHING
    in_time = t - t[0] >= rules.settle_time - ROUNDING
    settled = in_time & (np.abs(x - x[0]) >= rules.settle_travel - ROUNDING)
    if not settled.any():
        return NOTHING
    return slice(part.start + int(np.argmax(settled)), part.stop)


def window_length_s(run: Run, window: slice) -> float:
    """Return the time that a window's samples stand for: n sampling intervals."""
    t = run.t_s[window]
    return float((t[-1] - t[0]) * len(t) / (len(t) - 1)) if len(t) > 1 else 0.0


def stands_still(run: Run, part: slice) -> float:
    """Return how long [s] the piston stands at the end of ``part``, after having moved.

    Zero where it moves to the end, and where it had stood before and moved on (stick-slip).
    """
    v_ref = abs(run.plan.v_ref_m_s)
    speeds = block_speeds(run.t_s[: part.stop], run.x_m[: part.stop])
    slow = max(0.1 * v_ref, 3 * speeds.noise_m_s)
    moving = np.flatnonzero(np.abs(speeds.v_m_s) > max(0.5 * v_ref, slow))
    if not len(moving):
        return 0.0
    standing = np.abs(speeds.v_m_s) < slow
    tail = len(standing) if standing.all() else int(np.argmin(standing[::-1]))
    before = standing[moving[0] : len(standing) - tail]
    return 0.0 if before.any() else tail * BLOCK_S


def _settled(run: Run) -> slice:
    speeds = block_speeds(run.t_s, run.x_m)
    steady = np.flatnonzero(_near_usual(speeds))
    if not len(steady):
        return NOTHING
    first, last = speeds.t_s[steady[[0, -1]]]
    # Deceleration may begin within the two blocks of the last speed, so both are left out.
    start, stop = np.searchsorted(run.t_s, [first, last - BLOCK_S])
    return slice(int(start), int(stop))


def _near_usual(speeds: BlockSpeeds) -> np.ndarray:
    v = speeds.v_m_s
    if not len(v):
        return np.zeros(0, dtype=bool)
    quarter = len(v) // 4
    usual = np.median(v[quarter : len(v) - quarter])
    near = max(_SETTLED * abs(usual), 3 * speeds.noise_m_s)
    return np.abs(v - usual) <= near + ROUNDING * abs(usual)
