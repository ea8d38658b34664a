"""Velocity of a piston that stands still between its strokes, from a position with noise.

The slope over a short time contains the position's noise. The mean of |v| of such a velocity is not
0, so it would relax the bristles of a friction law at rest, and a fit would then find another
static friction and a sigma_1 that does not exist.
"""

from math import sqrt

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from hbench.motion.local_polynomials import local_polynomials, noise_share, odd_samples
from hbench.motion.noise import noise_over_motion, resolution, robust_sigma

_REST_S, _STILL = 0.3, 8.0  # at rest the position stays within so many deviations for so long
_SMOOTH_S, _FEWEST, _ORDER = 0.06, 7, 4  # of the polynomial; samples at least
_RESIDUAL = 0.66  # of white noise, what a polynomial of seven samples leaves
_ALIKE = 2.5  # deviations of the smoothed position; twice as many are motion


def standstill(x_m: np.ndarray, dt_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Return which samples are at rest (n,), and the velocity [m/s] (n,) of those.

    The position ``x_m`` (n,) is sampled every ``dt_s``. A rest is 0.3 s within 8 deviations of the
    position's noise; its velocity is the slope over this time. The samples before and after belong
    to it whose position is still that of the rest, within its noise.
    """
    window = odd_samples(_SMOOTH_S, dt_s, _FEWEST)
    long = odd_samples(_REST_S, dt_s, window)
    if len(x_m) < long:
        return np.zeros(len(x_m), bool), np.zeros(len(x_m))
    whole = np.array([0, len(x_m)])
    smooth = _smooth(x_m, window)
    level, step = (local_polynomials(x_m, whole, long, 1, order, 1.0) for order in (0, 1))
    noise_m = _noise(x_m, smooth)
    still = np.ptp(sliding_window_view(x_m, long), axis=1) <= _STILL * noise_m
    still = np.pad(still, long // 2, mode="edge")
    within_m = _ALIKE * noise_m * sqrt(noise_share(window, _ORDER))
    at_rest, step = _rests(still, long // 2, smooth, level, step, within_m)
    return at_rest, step / dt_s


def noise_of_motion(x_m: np.ndarray, dt_s: float) -> float:
    """Return the standard deviation of the noise [m] of a position with rests and strokes."""
    return _noise(x_m, _smooth(x_m, odd_samples(_SMOOTH_S, dt_s, _FEWEST)))


def _smooth(x_m: np.ndarray, window: int) -> np.ndarray:
    return local_polynomials(x_m, np.array([0, len(x_m)]), window, _ORDER, 0, 1.0)


def _noise(x_m: np.ndarray, smooth: np.ndarray) -> float:
    """Return the standard deviation of the position's noise [m].

    A fast oscillation also bends between samples, as noise does; the ``smooth`` position (n,)
    follows it, so the smaller of two estimates counts, each at least the sensor's resolution.
    """
    residual = robust_sigma(x_m - smooth) / _RESIDUAL
    noise = max(residual, resolution(x_m) / np.sqrt(12))
    return min(noise_over_motion(np.arange(len(x_m)), x_m), noise)


def _rests(
    still: np.ndarray,
    half: int,
    smooth: np.ndarray,
    level: np.ndarray,
    slope: np.ndarray,
    within_m: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return which samples are at rest (n,), and their change of position per sample (n,) [m].

    ``still`` (n,) is true in the middle of windows without motion, of ``half`` samples to each
    side; ``level`` and ``slope`` (n,) are the lines through the windows. Before and after the
    windows that are all rest, the piston rests as long as the ``smooth`` position is within
    ``within_m`` of the line through the nearest of these. Its distance from the line at the
    outermost sample is the travel of the outermost 60 ms, so that no travel is lost.
    """
    at_rest, step, last = np.zeros(len(still), bool), slope.copy(), len(still) - 1
    edges = np.flatnonzero(np.diff(still, prepend=False, append=False))
    for first, end in zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True):
        inner = min(first + half, (first + end) // 2), max(end - half, (first + end + 1) // 2)
        at_rest[inner[0] : inner[1] + 1] = True
        for own, until, way in (
            (inner[0], max(first - half, 0), -1),
            (inner[1], min(end + half, last), 1),
        ):
            samples = np.arange(own, until + way, way)
            off = smooth[samples] - level[own] - slope[own] * (samples - own)
            moves = np.flatnonzero(np.abs(off) > 2 * within_m)
            before = np.abs(off[: moves[0] if len(moves) else None])
            outermost = int(np.flatnonzero(before <= within_m)[-1:].sum())
            resting = samples[: outermost + 1]
            at_rest[resting], step[resting] = True, slope[own]
            ending = resting[-round(2 * half * _SMOOTH_S / _REST_S) :]
            step[ending] += way * off[outermost] / len(ending)
    return at_rest, step
