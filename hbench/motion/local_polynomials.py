"""Smoothing and differentiation of evenly sampled logs (Savitzky and Golay 1964)."""

from functools import lru_cache
from itertools import pairwise
from math import factorial

import numpy as np


def local_polynomials(
    y: np.ndarray, edges: np.ndarray, samples: int, order: int, derivative: int, dt_s: float
) -> np.ndarray:
    """Return a derivative (n,) of the polynomial through an odd number of samples about each one.

    ``y`` (n,) are runs one after another, which begin at ``edges`` (r + 1,) and are filtered all at
    once; near its ends a run has the values of its first and last polynomial. A run of fewer
    samples has differences between neighbours, and stays as it is for derivative 0.
    """
    rows = _weights(samples, order, derivative) / dt_s**derivative
    half, out = samples // 2, np.empty_like(y)
    if len(y) >= samples:
        out[half : len(y) - half] = np.correlate(y, rows[half], "valid")
    for start, stop in pairwise(edges):
        part = y[start:stop]
        if len(part) >= samples:
            out[start : start + half] = rows[:half] @ part[:samples]
            out[stop - half : stop] = rows[half + 1 :] @ part[-samples:]
        elif derivative:
            out[start:stop] = np.gradient(part, dt_s) if len(part) > 1 else 0.0
        else:
            out[start:stop] = part
    return out


def noise_share(samples: int, order: int) -> float:
    """Return the share of white noise's variance that is left in a smoothed sample."""
    return float(_weights(samples, order, 0)[samples // 2, samples // 2])


def odd_samples(duration_s: float, dt_s: float, fewest: int) -> int:
    """Return the odd number of samples that is next to a duration, ``fewest`` at least."""
    return max(fewest, 2 * round(duration_s / dt_s / 2) + 1)


@lru_cache
def _weights(samples: int, order: int, derivative: int) -> np.ndarray:
    """Return the weights of all samples for the derivative at each (samples, samples)."""
    rows = []
    for at in range(samples):
        powers = np.vander((np.arange(samples) - at) / samples, order + 1, increasing=True)
        rows.append(np.linalg.pinv(powers)[derivative])
    return np.array(rows) * factorial(derivative) / samples**derivative
