"""Speed of a logged position over short blocks of time, and the noise of both."""

from typing import NamedTuple

import numpy as np

_MAD_TO_SIGMA = 1.4826  # of a normal distribution
_EQUAL = 1e-9  # of a signal's range: a smaller difference is rounding
_ON_GRID = 0.02  # of a sensor's resolution


class BlockSpeeds(NamedTuple):
    """Speeds between the mean positions of neighbouring blocks of time."""

    t_s: np.ndarray  # (k,) middle between the two blocks
    v_m_s: np.ndarray  # (k,)
    noise_m_s: float  # standard deviation of each speed from the position's noise


def mean_speed(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the least-squares slope of position over time [m/s].

    It uses the position sensor alone and all samples, so it has neither the filter lag of the
    controller's velocity nor the noise of a difference of two positions.
    """
    t = t_s - t_s.mean()
    return float((t * x_m).sum() / (t * t).sum())  # t @ x_m starts threads that wait for longer


def block_speeds(
    t_s: np.ndarray, x_m: np.ndarray, block_s: float, noise_m: float | None = None
) -> BlockSpeeds:
    """Return the speeds between means of blocks of ``block_s``; empty for less than two blocks.

    ``noise_m`` is the standard deviation of the position's noise, or else that of these samples.
    """
    if len(t_s) < 2:
        return BlockSpeeds(np.zeros(0), np.zeros(0), 0.0)
    number = np.floor((t_s - t_s[0]) / block_s + 1e-6)
    block = np.cumsum(np.diff(number, prepend=number[0]) > 0)  # a gap has no blocks
    counts = np.bincount(block)
    full = counts >= 0.5 * np.median(counts)
    n = counts[full]
    t = np.bincount(block, t_s - t_s[0])[full] / n
    x = np.bincount(block, x_m - x_m[0])[full] / n
    dt = np.diff(t)
    sigma = position_noise(t_s, x_m) if noise_m is None else noise_m
    variance = sigma**2 * (1 / n[:-1] + 1 / n[1:]) / dt**2
    noise = float(np.sqrt(variance.mean())) if len(dt) else 0.0
    return BlockSpeeds(t_s[0] + (t[:-1] + t[1:]) / 2, np.diff(x) / dt, noise)


def position_noise(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the standard deviation [m] of white noise in a smooth position: root mean square.

    From each sample's distance to the straight line between its neighbours, w x_(i-1) +
    (1 - w) x_(i+1), whose variance is (1 + w^2 + (1 - w)^2) sigma^2.
    """
    scaled = _scaled_bends(t_s, x_m)
    return float(np.sqrt(np.mean(scaled**2))) if len(scaled) else 0.0


def noise_over_motion(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the standard deviation [m] of white noise in a position that also accelerates.

    It is robust to a minority of samples in which the position bends: the median of the same
    distances as in ``position_noise``. It is at least that of the sensor's resolution, q / sqrt 12.
    """
    scaled = _scaled_bends(t_s, x_m)
    if not len(scaled):
        return 0.0
    return max(_MAD_TO_SIGMA * float(np.median(np.abs(scaled))), resolution(x_m) / np.sqrt(12))


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
