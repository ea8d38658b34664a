"""Steadiness of a motion: speed, its ripple, and a force's drift, each with its noise level.

Each number has the size that measurement noise alone would give it, so that a noisy channel does
not appear unsteady.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import gammaincinv

BLOCK_S = 0.1
_MAD_TO_SIGMA = 1.4826  # of a normal distribution
_MEDIAN_TO_MEAN = 1.2533  # standard error of a normal sample's median against its mean's
_LEVEL = 0.9999  # of the chi-square law; with correlated speeds, noise exceeds it in 0.2 % at most


class BlockSpeeds(NamedTuple):
    """Speeds between the mean positions of neighbouring 0.1 s blocks."""

    t_s: np.ndarray  # (k,) middle between the two blocks
    v_m_s: np.ndarray  # (k,)
    noise_m_s: float  # standard deviation of each speed from the position's noise


class Ripple(NamedTuple):
    """Standard deviation of the speed over 0.1 s means."""

    total_m_s: float
    noise_m_s: float  # upper limit of the contribution of noise


class Drift(NamedTuple):
    """Change of a signal from a window's start to its end."""

    value: float
    se: float


def mean_speed(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the least-squares slope of position over time [m/s].

    It uses the position sensor alone and all samples, so it has neither the filter lag of the
    controller's velocity nor the noise of a difference of two positions.
    """
    t = t_s - t_s.mean()
    return float(t @ x_m / (t @ t))


def block_speeds(t_s: np.ndarray, x_m: np.ndarray) -> BlockSpeeds:
    """Return the speeds between means of 0.1 s blocks; empty for less than two blocks."""
    if len(t_s) < 2:
        return BlockSpeeds(np.zeros(0), np.zeros(0), 0.0)
    block = ((t_s - t_s[0]) / BLOCK_S + 1e-6).astype(int)
    counts = np.bincount(block)
    full = counts >= 0.5 * np.median(counts[counts > 0])
    n = counts[full]
    t = np.bincount(block, t_s - t_s[0])[full] / n
    x = np.bincount(block, x_m - x_m[0])[full] / n
    dt = np.diff(t)
    variance = position_noise(t_s, x_m) ** 2 * (1 / n[:-1] + 1 / n[1:]) / dt**2
    noise = float(np.sqrt(variance.mean())) if len(dt) else 0.0
    return BlockSpeeds(t_s[0] + (t[:-1] + t[1:]) / 2, np.diff(x) / dt, noise)


def position_noise(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the standard deviation [m] of white noise in a smooth position.

    From each sample's distance to the straight line between its neighbours, w x_(i-1) +
    (1 - w) x_(i+1), whose variance is (1 + w^2 + (1 - w)^2) sigma^2.
    """
    span = t_s[2:] - t_s[:-2]
    inner = span > 0
    if not inner.any():
        return 0.0
    w = (t_s[2:] - t_s[1:-1])[inner] / span[inner]
    residual = x_m[1:-1][inner] - w * x_m[:-2][inner] - (1 - w) * x_m[2:][inner]
    return float(np.sqrt(residual @ residual / np.sum(1 + w**2 + (1 - w) ** 2)))


def speed_ripple(t_s: np.ndarray, x_m: np.ndarray) -> Ripple:
    """Return the standard deviation of the 0.1 s speeds and the upper limit of its noise.

    Neighbouring speeds share a block, so their noise is correlated by -1/2 and the variance
    has about k/1.5 degrees of freedom (sum of the squared correlations).
    """
    speeds = block_speeds(t_s, x_m)
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
    scatter = _MAD_TO_SIGMA * np.median(np.abs(slopes - slope))
    window = t_s[-1] - t_s[0]
    return Drift(float(window * slope), float(window * _MEDIAN_TO_MEAN * scatter / np.sqrt(h)))
