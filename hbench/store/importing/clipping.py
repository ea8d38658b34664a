"""Detection of clipped channels in imported logs: the true value is beyond the converter's range.

A clipped channel stays at exactly its highest or lowest value for three samples or more while
other channels change, and longer than at any value between. An unclipped channel with little noise
and coarse resolution does the same, at a peak or when settled. Clipping is therefore reported only
where the noise from sample to sample is above the resolution, in the log and next to these samples:
a lively stroke may settle quietly at its end.
"""

from collections.abc import Mapping

import numpy as np

LEAST_SAMPLES = 3  # consecutive
_LEAST_NOISE = 1.5  # in units of the resolution
_NEAR = 20  # samples on either side


def clipped_at_limit(values: np.ndarray, others_change: np.ndarray) -> np.ndarray:
    """Return the samples (n,) at a limit of the converter; none if that can't be determined.

    ``others_change`` (n,) is True where another channel differs from its previous sample: where
    all channels are constant, the log has stopped and no converter is saturated.
    """
    none = np.zeros(len(values), dtype=bool)
    known = values[np.isfinite(values)]
    steps = np.abs(np.diff(known))
    if len(known) < 3 * LEAST_SAMPLES or not steps.any():
        return none
    resolution = steps[steps > 1e-9 * np.ptp(known)].min()
    inside = known[(known > known.min()) & (known < known.max())]
    if _noise(inside) <= _LEAST_NOISE * resolution:
        return none
    least = max(LEAST_SAMPLES, _longest(np.diff(inside) == 0)[1] + 2)
    clipped = none
    for limit in (known.max(), known.min()):
        at_limit = values == limit
        start, length = _longest(at_limit[1:] & at_limit[:-1] & others_change[1:])
        near = slice(max(start - _NEAR, 0), start + length + 1 + _NEAR)
        beside = values[near][~at_limit[near]]
        lively = _noise(beside) > _LEAST_NOISE * resolution or len(beside) < LEAST_SAMPLES
        if length + 1 >= least and lively:
            clipped = clipped | at_limit
    return clipped


def clipped_samples(sensed: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the clipped samples (n,) of each channel that has some.

    ``sensed`` are the channels as logged, before any zero or mean. Position and valve commands are
    not tested: they rest at the limits of their ranges.
    """
    changed = {
        name: np.concatenate(([False], np.diff(values) != 0)) for name, values in sensed.items()
    }
    tested = [name for name in sensed if name.startswith("p_") or name == "f_applied_n"]
    clipped = {}
    for name in tested:
        others = [changes for other, changes in changed.items() if other not in (name, "t_s")]
        if others:
            clipped[name] = clipped_at_limit(sensed[name], np.logical_or.reduce(others))
    return {name: samples for name, samples in clipped.items() if samples.any()}


def _longest(held: np.ndarray) -> tuple[int, int]:
    """Return the first index and the length of the longest run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], held.astype(int), [0]))))
    lengths = edges[1::2] - edges[::2]
    if not len(lengths):
        return 0, 0
    longest = int(np.argmax(lengths))
    return int(edges[2 * longest]), int(lengths[longest])


def _noise(values: np.ndarray) -> float:
    """Return the standard deviation of white noise on a smooth signal, by second differences."""
    bends = np.abs(np.diff(values, 2))
    return float(np.median(bends) / (0.6745 * np.sqrt(6))) if len(bends) else 0.0
