"""Rest before the motion, and the zero offset of a sensor over it."""

from typing import NamedTuple

import numpy as np

from hbench.motion.noise import noise_of_differences, noise_over_motion

BLOCK_S = 0.1
LEAST_REST_S = 0.5  # five blocks, whose scatter gives the standard error
_MOVED = 0.005  # of the travel: a larger displacement is motion
_MOVED_SIGMAS = 6.0  # of the position's noise, the same
_SIGMAS = 5.0  # of the blocks' scatter: a smaller step or trend is noise


class ZeroOffset(NamedTuple):
    """Mean of a sensor at rest, with its standard error and its largest systematic change."""

    mean: float
    se: float
    start_s: float  # of the rest, in the file's time
    stop_s: float
    step: float  # largest difference of means before and after a time; 0 within noise
    step_at_s: float
    trend: float  # change over the rest by its slope; 0 within noise

    @property
    def seconds(self) -> float:
        """Length of the rest."""
        return self.stop_s - self.start_s


def rest_before_motion(t_s: np.ndarray, x_m: np.ndarray, v_ref_m_s: np.ndarray | None) -> slice:
    """Return the samples at rest at a file's start, up to 0.1 s before the motion; may be empty.

    The motion begins where the reference is not zero, or where the position differs from its median
    over the first 0.1 s by 0.5 % of the whole travel and by more than its noise.
    """
    beginning = x_m[t_s - t_s[0] <= BLOCK_S]
    least_m = max(_MOVED * np.ptp(x_m), _MOVED_SIGMAS * noise_over_motion(t_s, x_m))
    moved = np.abs(x_m - np.median(beginning)) > least_m
    if v_ref_m_s is not None:
        moved |= np.nan_to_num(v_ref_m_s) != 0.0
    stop = int(np.argmax(moved)) if moved.any() else len(t_s)
    end = t_s[stop] if stop < len(t_s) else t_s[-1] + BLOCK_S
    return slice(0, int(np.searchsorted(t_s, end - BLOCK_S)))


def zero_offset(t_s: np.ndarray, values: np.ndarray) -> ZeroOffset | None:
    """Return the mean of the samples at rest, or None for less than ``LEAST_REST_S`` of rest.

    Noise may be correlated from sample to sample (mains, filters), so the standard error is that
    of the means of k blocks of 0.1 s: s / sqrt(k). Their scatter s comes from neighbouring blocks,
    (m_(i+1) - m_i) / sqrt 2, which neither a step nor a trend widens by much.
    """
    known = np.isfinite(values)
    t, y = t_s[known], values[known]
    if len(t) < 2 or t[-1] - t[0] < LEAST_REST_S - BLOCK_S / 2:
        return None
    block = ((t - t[0]) / BLOCK_S).astype(int)
    counts = np.bincount(block)
    full = counts >= 0.5 * np.median(counts[counts > 0])
    means = np.bincount(block, y)[full] / counts[full]
    middles = np.bincount(block, t)[full] / counts[full]
    se = float(np.std(means, ddof=1) / np.sqrt(len(means)))
    scatter = noise_of_differences(np.diff(means), 1)
    step, at = largest_step(means, scatter)
    trend = _trend(middles, means, scatter)
    if step and trend:  # what explains more
        parts = np.where(np.arange(len(means)) < at, means[:at].mean(), means[at:].mean())
        line = means.mean() + trend * (middles - middles.mean()) / np.ptp(middles)
        is_step = np.sum((means - parts) ** 2) < np.sum((means - line) ** 2)
        step, trend = (step, 0.0) if is_step else (0.0, trend)
    return ZeroOffset(
        mean=float(y.mean()),
        se=se,
        start_s=float(t[0]),
        stop_s=float(t[-1]),
        step=step,
        step_at_s=float((middles[at - 1] + middles[at]) / 2),
        trend=trend,
    )


def largest_step(means: np.ndarray, scatter: float) -> tuple[float, int]:
    """Return the largest difference of means after and before a block, and the block's number.

    It is 0 within the noise of ``means`` (k,), whose standard deviation is ``scatter``.
    """
    k = np.arange(1, len(means))
    before = np.cumsum(means)[:-1] / k
    after = (means.sum() - np.cumsum(means)[:-1]) / (len(means) - k)
    noise = _SIGMAS * scatter * np.sqrt(1 / k + 1 / (len(means) - k))
    at = int(np.argmax(np.abs(after - before) - noise))
    step = float(after[at] - before[at])
    return (step if abs(step) > noise[at] else 0.0), at + 1


def _trend(t_s: np.ndarray, means: np.ndarray, scatter: float) -> float:
    """Return the change over the rest by a straight line; 0 within noise."""
    t = t_s - t_s.mean()
    slope = float(t @ means / (t @ t))
    length = float(np.ptp(t))
    noise = _SIGMAS * scatter / np.sqrt(t @ t) * length
    return slope * length if abs(slope * length) > noise else 0.0
