"""Means of unevenly sampled channels over equal intervals."""

import numpy as np

MOST_INTERVALS = 10_000_000


def whole_intervals(t_s: np.ndarray, rate_hz: float, max_gap_s: float) -> np.ndarray:
    """Return the starts (m,) [s] of the intervals of 1/rate, from the first sample on.

    Each interval is between the first and the last sample, and contains no gap between samples
    longer than ``max_gap_s``. Raises ``ValueError`` for more than ``MOST_INTERVALS``.
    """
    gaps = np.flatnonzero(np.diff(t_s) > max_gap_s)
    count = int(np.floor((t_s[-1] - t_s[0]) * rate_hz + 1e-9))
    # Only intervals near the sections between gaps are made: a gap can be as long as 1e6 s.
    sections = t_s[np.append(0, gaps + 1)], t_s[np.append(gaps, len(t_s) - 1)]
    first, last = (((t - t_s[0]) * rate_hz).astype(int) for t in sections)
    counts = last - first + 2
    if counts.sum() > MOST_INTERVALS:
        raise ValueError(f"{counts.sum()} intervals; limit {MOST_INTERVALS}")
    numbers = np.arange(counts.sum()) + np.repeat(first - np.cumsum(counts) + counts, counts)
    numbers = np.unique(numbers[numbers < count])
    starts = t_s[0] + numbers / rate_hz
    return starts[~gaps_within(t_s, starts, rate_hz, max_gap_s)]


def gaps_within(
    t_s: np.ndarray, starts_s: np.ndarray, rate_hz: float, max_gap_s: float
) -> np.ndarray:
    """Return whether each interval (m,) of 1/rate contains a gap longer than ``max_gap_s``."""
    first, last = _around(t_s, starts_s, starts_s + 1 / rate_hz)
    return _any_between(np.diff(t_s) > max_gap_s, first, last)


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
    first, last = _around(t_s, starts_s, stops)
    means[_any_between(~(known[1:] & known[:-1]), first, last)] = np.nan
    return means


def _around(
    t_s: np.ndarray, starts_s: np.ndarray, stops_s: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the last sample before each interval and the first one after it, (m,) each."""
    first = np.clip(np.searchsorted(t_s, starts_s, side="right") - 1, 0, len(t_s) - 1)
    last = np.clip(np.searchsorted(t_s, stops_s - 1e-12), 0, len(t_s) - 1)
    return first, last


def _any_between(bad: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Return whether any of the steps (n-1,) between samples ``first`` and ``last`` is bad."""
    counted = np.concatenate(([0], np.cumsum(bad)))
    return counted[last] > counted[first]
