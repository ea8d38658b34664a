"""Steadiness of a motion: speed, its ripple, and a force's drift, each with its noise level.

Each number has the size that measurement noise alone would give it, so that a noisy channel does
not appear unsteady.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import gammaincinv

from hbench.motion.noise import noise_of_differences, position_noise, robust_sigma
from hbench.motion.rest import largest_step
from hbench.motion.speeds import BlockSpeeds, block_speeds

BLOCK_S = 0.1
_STEP_BLOCKS = 12  # of a window, between which a load may step
_MEDIAN_TO_MEAN = 1.2533  # standard error of a normal sample's median against its mean's
_LEVEL = 0.9999  # of the chi-square law; with correlated speeds, noise exceeds it in 0.2 % at most


class Ripple(NamedTuple):
    """Standard deviation of the speed between means over blocks of time, 0.1 s by default."""

    total_m_s: float
    noise_m_s: float  # upper limit of the contribution of noise


class Drift(NamedTuple):
    """Change of a signal from a window's start to its end."""

    value: float
    se: float


def speeds_over_tenths(t_s: np.ndarray, x_m: np.ndarray) -> BlockSpeeds:
    """Return the speeds between means of 0.1 s blocks, which the limits of the screening use."""
    return block_speeds(t_s, x_m, BLOCK_S)


def speed_ripple(
    t_s: np.ndarray, x_m: np.ndarray, largest_noise_m: float = np.inf, block_s: float = BLOCK_S
) -> Ripple:
    """Return the standard deviation of the speeds over blocks and the upper limit of its noise.

    The position's noise is that within these samples, at most ``largest_noise_m``: a fast
    oscillation looks like noise.

    Neighbouring speeds share a block, so their noise is correlated by -1/2 and the variance
    has about k/1.5 degrees of freedom (sum of the squared correlations).
    """
    noise_m = min(position_noise(t_s, x_m), largest_noise_m)
    speeds = block_speeds(t_s, x_m, block_s, noise_m)
    k = len(speeds.v_m_s)
    if k < 2:
        return Ripple(0.0, 0.0)
    dof = (k - 1) / 1.5
    chi2 = 2 * gammaincinv(dof / 2, _LEVEL)
    return Ripple(float(np.std(speeds.v_m_s, ddof=1)), speeds.noise_m_s * np.sqrt(chi2 / dof))


def drift(t_s: np.ndarray, y: np.ndarray) -> Drift:
    """Return the change of ``y`` over the window and its standard error, both robust.

    The slope is Theil's: the median of (y_(i+h) - y_i) / (t_(i+h) - t_i) with h = n/2. Each sample
    occurs once, so the slopes are independent and their scatter gives the error.
    """
    h = len(y) // 2
    if h < 2:
        return Drift(0.0, np.inf)
    slopes = (y[-h:] - y[:h]) / (t_s[-h:] - t_s[:h])
    slope = np.median(slopes)
    scatter = robust_sigma(slopes - slope)
    window = t_s[-1] - t_s[0]
    return Drift(float(window * slope), float(window * _MEDIAN_TO_MEAN * scatter / np.sqrt(h)))


def line_change(t_s: np.ndarray, y: np.ndarray) -> float:
    """Return the change of the least-squares line through ``y`` over the window.

    Spikes move it. Hum does not, where it may move ``drift``: its slopes have few values, and the
    median is one of them.
    """
    from_middle = t_s - t_s.mean()
    slope = (from_middle @ y) / (from_middle @ from_middle)
    return float((t_s[-1] - t_s[0]) * slope)


def load_step(y: np.ndarray) -> float:
    """Return the largest difference of means after and before any time; 0 within noise."""
    blocks = min(_STEP_BLOCKS, len(y) // 2)
    if blocks < 2:
        return 0.0
    edges = np.linspace(0, len(y), blocks + 1).astype(int)
    means = np.add.reduceat(y, edges[:-1]) / np.diff(edges)
    return largest_step(means, noise_of_differences(np.diff(means), 1))[0]
