"""Speed of a logged position: over a whole section, and over short blocks of time."""

from typing import NamedTuple

import numpy as np

from hbench.motion.noise import position_noise


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
