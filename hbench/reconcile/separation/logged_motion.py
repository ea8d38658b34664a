"""Motion that logs contain: directions, reversals, fast changes and speeds.

The kind of an imported run is what its map states. One kind can contain several motions: steps in
both directions reverse, and a sum of sines covers speeds.
"""

from dataclasses import dataclass

import numpy as np

from hbench.records import Run
from hbench.records.reconcile.diagnosis import REST_M_S

_WIDTH_S = 0.1  # of a velocity; a change of speed within twice as long is fast
_SLOW = 0.05  # of the run's largest speed: below it the sign is not counted
_FAST = 0.5  # of the run's largest speed
_BOTH = 0.05  # share of the moving time
_FEWEST_REVERSALS = 2  # of a run: a stroke and its return have one
_FEWEST_CHANGES = 3  # of a run: a stroke has two, its start and its stop
_LEVEL = 1.25  # ratio of the limits of a level of speed
_FEWEST_LEVELS = 3


@dataclass(frozen=True)
class LoggedMotion:
    """Motion of one run."""

    has_both_directions: bool
    reverses: bool  # repeatedly
    has_fast_changes: bool  # repeatedly
    has_several_speeds: bool  # three or more


def velocity_m_s(run: Run) -> np.ndarray:
    """Return the velocity (n,) of the position over 0.1 s; 0 of a log that is as short."""
    t_s, half = run.t_s, 0.5 * _WIDTH_S
    if len(t_s) < 2 or t_s[-1] - t_s[0] < 2 * _WIDTH_S:
        return np.zeros(len(t_s))
    after, before = np.minimum(t_s + half, t_s[-1]), np.maximum(t_s - half, t_s[0])
    x_m = np.interp(np.concatenate([after, before]), t_s, run.x_m)
    travelled: np.ndarray = x_m[: len(t_s)] - x_m[len(t_s) :]
    return travelled / (after - before)


def moving_direction(v_m_s: np.ndarray) -> np.ndarray:
    """Return the sign (n,) of the motion; 0 at rest and at low speed."""
    limit = max(REST_M_S, _SLOW * float(np.abs(v_m_s).max(initial=0.0)))
    sign: np.ndarray = np.sign(v_m_s) * (np.abs(v_m_s) > limit)
    return sign


def logged_motion(run: Run) -> LoggedMotion:
    """Return what the motion of a run contains."""
    t_s, v = run.t_s, velocity_m_s(run)
    if not moving_direction(v).any():
        return LoggedMotion(False, False, False, False)
    at = np.arange(t_s[0], t_s[-1], _WIDTH_S)  # evenly, whatever the log's samples
    v = np.interp(at, t_s, v)
    way = moving_direction(v)
    way, speed = way[way != 0], np.abs(v[way != 0])
    fast = np.abs(v[2:] - v[:-2]) > _FAST * np.abs(v).max()
    changes = np.count_nonzero(np.diff(fast.astype(int), prepend=0) > 0)
    levels = np.floor(np.log(speed) / np.log(_LEVEL))
    counts = np.unique(levels, return_counts=True)[1]
    return LoggedMotion(
        bool(len(way) and min(np.mean(way > 0), np.mean(way < 0)) > _BOTH),
        bool(np.count_nonzero(np.diff(way)) >= _FEWEST_REVERSALS),
        bool(changes >= _FEWEST_CHANGES),
        bool(np.count_nonzero(counts > _BOTH * len(way)) >= _FEWEST_LEVELS),
    )
