"""Means of unevenly sampled channels over equal intervals, and positions that need them."""

from collections.abc import Iterator

import numpy as np

from hbench.store.importing.file_notes import FileNote

MOST_INTERVALS = 10_000_000
_LEAST_CHANGES = 20  # of a position, to determine their rate
_HELD_S = 0.021  # longer than the speed's shortest block, of which an oscillation is determined
_REGULAR = 0.8  # of the changes: so many are equally far from the one before
_SMALL = 0.2  # of the median change: steps of a coarse encoder are all of one height


def held_position(name: str, t_s: np.ndarray, x_m: np.ndarray) -> Iterator[FileNote]:
    """Yield a note on a position that is sampled more slowly than the log, and held meanwhile."""
    changes = np.flatnonzero(np.diff(x_m))
    if len(changes) < _LEAST_CHANGES:
        return
    held, heights = np.diff(changes), np.abs(np.diff(x_m))[changes]
    every, step_s = float(np.median(held)), float(np.median(np.diff(t_s)))
    if every < 2 or every * step_s < _HELD_S:
        return
    is_regular = np.mean(np.abs(held - every) <= 1) > _REGULAR
    if is_regular and heights.min() < _SMALL * np.median(heights):
        text = (
            "x_m changes in one of {every} samples only, at {rate} Hz, and is held meanwhile: its "
            "steps may look like stick-slip. Write 'resample: {rate} Hz' in the map"
        )
        yield FileNote(name, text, {"every": every, "rate": float(f"{1 / every / step_s:.3g}")})


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
