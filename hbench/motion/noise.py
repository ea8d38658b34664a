"""Noise of a logged signal: its standard deviation, at rest and in motion, and the resolution.

Robust estimates are those of the median, which a minority of other samples hardly changes.
"""

from math import comb, sqrt

import numpy as np

NORMAL_MEDIAN = 0.6745  # of |z| for a normal z: 1 / 1.4826
_EQUAL = 1e-9  # of a signal's range: a smaller difference is rounding
_ON_GRID = 0.02  # of a sensor's resolution


def robust_sigma(deviations: np.ndarray) -> float:
    """Return the standard deviation of normal ``deviations`` (n,) about 0; 0 for none.

    sigma = median |d| / 0.6745, the normalised median absolute deviation: up to half of the
    deviations may be outliers.
    """
    return float(np.median(np.abs(deviations))) / NORMAL_MEDIAN if len(deviations) else 0.0


def noise_of_differences(differences: np.ndarray, order: int) -> float:
    """Return the robust standard deviation of white noise from differences (n,) of its samples.

    Those of ``order`` k have comb(2k, k) times its variance: 2 for first, 6 for second ones, which
    are 0 on a straight line.
    """
    return robust_sigma(differences) / sqrt(comb(2 * order, order))


def position_noise(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the standard deviation [m] of white noise in a smooth position: root mean square.

    From each sample's distance to the straight line between its neighbours, w x_(i-1) +
    (1 - w) x_(i+1), whose variance is (1 + w^2 + (1 - w)^2) sigma^2.
    """
    scaled = _scaled_bends(t_s, x_m)
    return float(np.sqrt(np.mean(scaled**2))) if len(scaled) else 0.0


def noise_over_motion(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the standard deviation [m] of white noise in a position that also accelerates.

    It is robust to a minority of samples in which the position bends: ``robust_sigma`` of the same
    distances as in ``position_noise``. It is at least that of the sensor's resolution, q / sqrt 12.
    """
    scaled = _scaled_bends(t_s, x_m)
    if not len(scaled):
        return 0.0
    return max(robust_sigma(scaled), resolution(x_m) / np.sqrt(12))


def resolution(values: np.ndarray) -> float:
    """Return the step of which all differences of the values (n,) are multiples; 0 for none."""
    bends = np.abs(np.diff(values, 2))
    bends = bends[bends > _EQUAL * np.ptp(values)]
    if not len(bends):
        return 0.0
    step = float(bends.min())
    steps = (values - values[0]) / step
    return step if np.abs(steps - np.rint(steps)).max() < _ON_GRID else 0.0


def _scaled_bends(t_s: np.ndarray, x_m: np.ndarray) -> np.ndarray:
    """Return the distances to the neighbours' line, scaled to the noise's standard deviation."""
    span = t_s[2:] - t_s[:-2]
    inner = span > 0
    w = (t_s[2:] - t_s[1:-1])[inner] / span[inner]
    bends = x_m[1:-1][inner] - w * x_m[:-2][inner] - (1 - w) * x_m[2:][inner]
    return bends / np.sqrt(1 + w**2 + (1 - w) ** 2)
