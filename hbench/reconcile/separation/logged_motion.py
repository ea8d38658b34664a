"""Motion that a log contains."""

import numpy as np

from hbench.records import Run
from hbench.records.diagnosis import REST_M_S

_WIDTH_S = 0.1  # of a velocity
_SLOW = 0.05  # of the run's largest speed: below it the sign is not counted


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
