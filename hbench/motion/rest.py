"""Zero offset of a sensor: its mean at rest before the motion."""

from typing import NamedTuple

import numpy as np

BLOCK_S = 0.1
LEAST_REST_S = 0.5  # five blocks, whose scatter gives the standard error
_MOVED = 0.005  # of the travel: a larger displacement is motion
_MOVED_SIGMAS = 6.0  # of the position's noise, the same
_BEGINNING_S = 0.3  # gives the position's noise


class ZeroOffset(NamedTuple):
    """Mean of a sensor at rest, with its standard error."""

    mean: float
    se: float
    seconds: float  # of rest


def rest_before_motion(t_s: np.ndarray, x_m: np.ndarray, v_ref_m_s: np.ndarray | None) -> slice:
    """Return the samples at rest at a file's start, up to 0.1 s before the motion; may be empty.

    The motion begins where the reference is not zero, or where the position differs from its median
    over the first 0.3 s by 0.5 % of the whole travel and by more than its noise.
    """
    beginning = x_m[t_s - t_s[0] <= _BEGINNING_S]
    noise = np.median(np.abs(np.diff(beginning))) / 0.954 if len(beginning) > 1 else 0.0
    least_m = max(_MOVED * np.ptp(x_m), _MOVED_SIGMAS * noise)
    moved = np.abs(x_m - np.median(beginning)) > least_m
    if v_ref_m_s is not None:
        moved |= np.nan_to_num(v_ref_m_s) != 0.0
    stop = int(np.argmax(moved)) if moved.any() else len(t_s)
    end = t_s[stop] if stop < len(t_s) else t_s[-1] + BLOCK_S
    return slice(0, int(np.searchsorted(t_s, end - BLOCK_S)))


def zero_offset(t_s: np.ndarray, values: np.ndarray) -> ZeroOffset | None:
    """Return the mean of the samples at rest, or None for less than ``LEAST_REST_S`` of rest.

    Noise may be correlated from sample to sample (mains, filters), so the standard error is that
    of the means of k blocks of 0.1 s: s / sqrt(k).
    """
    known = np.isfinite(values)
    t, y = t_s[known], values[known]
    if len(t) < 2 or t[-1] - t[0] < LEAST_REST_S - BLOCK_S / 2:
        return None
    block = ((t - t[0]) / BLOCK_S).astype(int)
    counts = np.bincount(block)
    full = counts >= 0.5 * np.median(counts[counts > 0])
    means = np.bincount(block, y)[full] / counts[full]
    se = float(np.std(means, ddof=1) / np.sqrt(len(means)))
    return ZeroOffset(float(y.mean()), se, float(t[-1] - t[0]))
