"""The zero of a sensor, from its mean at rest before the motion."""

from typing import NamedTuple

import numpy as np

BLOCK_S = 0.1
LEAST_S = 0.5  # of rest: five blocks, whose scatter gives the standard error
_LEFT = 0.005  # of the travel: the piston has left its place
_SIGMAS = 6.0  # so far does noise alone not go
_BEGINNING_S = 0.3  # over which the position's noise is told


class Zero(NamedTuple):
    """A mean at rest."""

    mean: float
    se: float
    seconds: float


def rest_before_motion(t_s: np.ndarray, x_m: np.ndarray, v_ref_m_s: np.ndarray | None) -> slice:
    """Return the samples at rest at a file's start, up to 0.1 s before the motion; maybe none.

    The motion begins where the reference does, or where the position has left its first 0.3 s by
    0.5 % of the whole travel and by more than its noise.
    """
    beginning = x_m[t_s - t_s[0] <= _BEGINNING_S]
    noise = np.median(np.abs(np.diff(beginning))) / 0.954 if len(beginning) > 1 else 0.0
    left = np.abs(x_m - np.median(beginning)) > max(_LEFT * np.ptp(x_m), _SIGMAS * noise)
    if v_ref_m_s is not None:
        left |= np.nan_to_num(v_ref_m_s) != 0.0
    stop = int(np.argmax(left)) if left.any() else len(t_s)
    end = t_s[stop] if stop < len(t_s) else t_s[-1] + BLOCK_S
    return slice(0, int(np.searchsorted(t_s, end - BLOCK_S)))


def zero_at_rest(t_s: np.ndarray, values: np.ndarray) -> Zero | None:
    """Return the mean of samples at rest, or None for less than ``LEAST_S`` of them.

    Noise may be correlated from sample to sample (mains, filters), so the standard error is that
    of the means of 0.1 s blocks: s / sqrt(k).
    """
    known = np.isfinite(values)
    t, y = t_s[known], values[known]
    if len(t) < 2 or t[-1] - t[0] < LEAST_S - BLOCK_S / 2:
        return None
    block = ((t - t[0]) / BLOCK_S).astype(int)
    counts = np.bincount(block)
    full = counts >= 0.5 * np.median(counts[counts > 0])
    means = np.bincount(block, y)[full] / counts[full]
    se = float(np.std(means, ddof=1) / np.sqrt(len(means)))
    return Zero(float(y.mean()), se, float(t[-1] - t[0]))
