"""Weights from the scatter of the trials, pooled over all speeds.

Three trials determine their variance only within a factor of forty, so it can't serve as a point's
weight. Instead, one law ln sigma^2 = a + b ln|v| is fitted to the variances s_i^2 of all points by
maximum likelihood (they are gamma distributed with n_i - 1 degrees of freedom):

    minimise  sum (n_i - 1) (s_i^2 / sigma_i^2 + ln sigma_i^2)

by iterated least squares. The weight of a point with n trials is n / sigma^2. The slope b has the
standard error of the expected information, sum (n_i - 1) x x' / 2 with x = (1, ln|v_i|): about 0.25
for twelve speeds from 4 to 200 mm/s and three trials, a change of the ratio of the end points'
weights by a factor of 2.6. Intervals must contain it (``parameter_spread.py``).
"""

from typing import NamedTuple

import numpy as np

_ITERATIONS = 100
_TOLERANCE = 1e-10


class PooledSigma(NamedTuple):
    """Standard deviations (n,) of a trial at each speed, and their uncertain slope."""

    sigma: np.ndarray
    slope_errors: np.ndarray  # changes of ln sigma^2 (n,) by the standard error of b


def pooled_sigma(
    speed_m_s: np.ndarray, variance: np.ndarray, dof: np.ndarray
) -> PooledSigma | None:
    """Return the standard deviation of a trial at each speed, from the law above.

    ``variance`` (n,) is that of each point's trials, with ``dof`` (n,) degrees of freedom; zero
    where there is one trial, or where the trials differ by rounding. None where nothing scatters or
    fewer than three points have trials.
    """
    used = (dof > 0) & np.isfinite(variance)
    level = float(np.sum((dof * variance)[used]) / max(np.sum(dof[used]), 1.0))
    if used.sum() < 3 or level <= 0.0:
        return None
    log_speed = np.log(speed_m_s) - np.log(speed_m_s[used]).mean()
    matrix = np.column_stack([np.ones(len(log_speed)), log_speed])
    root = np.sqrt(dof[used])[:, None]
    line = np.array([np.log(level), 0.0])
    for _ in range(_ITERATIONS):
        expected = np.exp(matrix[used] @ line)
        away = variance[used] / expected - 1.0
        step = np.linalg.lstsq(root * matrix[used], root[:, 0] * away, rcond=None)[0]
        line = line + np.clip(step, -1.0, 1.0)
        if np.abs(step).max() < _TOLERANCE:
            break
    information = (matrix[used] * (0.5 * dof[used])[:, None]).T @ matrix[used]
    slope_error = float(np.sqrt(np.linalg.pinv(information)[1, 1]))
    return PooledSigma(np.exp(matrix @ line / 2), slope_error * log_speed)
