"""Means of unevenly sampled channels over equal intervals."""

import numpy as np


def whole_intervals(t_s: np.ndarray, rate_hz: float, max_gap_s: float) -> np.ndarray:
    """Return the starts (m,) [s] of the intervals of 1/rate, from the first sample on.

    Each interval is between the first and the last sample, and contains no gap between samples
    longer than ``max_gap_s``.
    """
    count = int(np.floor((t_s[-1] - t_s[0]) * rate_hz + 1e-9))
    starts = t_s[0] + np.arange(count) / rate_hz
    first = np.clip(np.searchsorted(t_s, starts, side="right") - 1, 0, len(t_s) - 1)
    last = np.clip(np.searchsorted(t_s, starts + 1 / rate_hz - 1e-12), 0, len(t_s) - 1)
    return starts[~_any_between(np.diff(t_s) > max_gap_s, first, last)]


def interval_means(
    t_s: np.ndarray, values: np.ndarray, starts_s: np.ndarray, rate_hz: float
) -> np.ndarray:
    """Return the mean (m,) of the linearly interpolated samples over each interval.

    ``starts_s`` (m,) are the intervals' starts. The integral is exact (trapezia), so dense sampling
    gives no extra weight. A mean over T is a zero-phase filter with the gain
    sin(pi f T) / (pi f T). It is NaN if one of its samples is NaN.
    """
    known = np.isfinite(values)
    y = np.where(known, values, 0.0)
    steps = np.diff(t_s)
    area = np.concatenate(([0.0], np.cumsum(steps * (y[1:] + y[:-1]) / 2)))
    slope = np.diff(y) / steps

    def integral(at: np.ndarray) -> np.ndarray:
        i = np.clip(np.searchsorted(t_s, at, side="right") - 1, 0, len(steps) - 1)
        dt = at - t_s[i]
        return area[i] + dt * (y[i] + slope[i] * dt / 2)

    stops = starts_s + 1 / rate_hz
    means = (integral(stops) - integral(starts_s)) * rate_hz
    first = np.clip(np.searchsorted(t_s, starts_s, side="right") - 1, 0, len(t_s) - 1)
    last = np.clip(np.searchsorted(t_s, stops - 1e-12), 0, len(t_s) - 1)
    means[_any_between(~(known[1:] & known[:-1]), first, last)] = np.nan
    return means


def _any_between(bad: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Return whether any of the steps (n-1,) between samples ``first`` and ``last`` is bad."""
    counted = np.concatenate(([0], np.cumsum(bad)))
    return counted[last] > counted[first]
