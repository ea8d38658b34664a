"""Detection of clipped channels in imported logs: the true value is beyond the converter's range.

A clipped channel stays at exactly its highest or lowest value for three samples or more while
other channels change, and longer than at any value between. An unclipped channel with little noise
and coarse resolution does the same, at a peak or when settled. Clipping is therefore reported only
where the noise from sample to sample, just before and after, is above the resolution: a run is
noisier while it moves or oscillates than when it has settled.
"""

from collections.abc import Mapping

import numpy as np

from hbench.motion.noise import noise_of_differences

LEAST_SAMPLES = 3  # consecutive
_LEAST_NOISE = 1.5  # in units of the resolution
_NEAR = 30  # samples before and after, which the noise is of
_COUNTS = 2  # of the resolution: a limit with a noise of one count up and down
_LEAST_NOISY_SAMPLES = 10  # consecutive within these counts
_LESS_NOISE = 2.0  # times: the noise next to such a stretch, over its own and the resolution


def clipped_at_limit(values: np.ndarray, others_change: np.ndarray) -> np.ndarray:
    """Return the samples (n,) at a limit of the converter; none if that can't be determined.

    ``others_change`` (n,) is True where another channel differs from its previous sample: where
    all channels are constant, the log has stopped and no converter is saturated.
    """
    none = np.zeros(len(values), dtype=bool)
    known = values[np.isfinite(values)]
    resolution = _resolution(known)
    if len(known) < 3 * LEAST_SAMPLES or not resolution:
        return none
    inside = known[(known > known.min()) & (known < known.max())]
    least = max(LEAST_SAMPLES, _longest(np.diff(inside) == 0) + 2)
    within = np.isfinite(values) & (values > known.min()) & (values < known.max())
    clipped = none
    for limit in (known.max(), known.min()):
        at_limit = values == limit
        held = at_limit[1:] & at_limit[:-1] & others_change[1:]
        if any(
            stop - start + 1 >= least
            and _noise_near(values, within, start, stop + 1) > _LEAST_NOISE * resolution
            for start, stop in _stretches(held)
        ):
            clipped = clipped | at_limit
    return clipped


def _resolution(known: np.ndarray) -> float:
    """Return the smallest step between successive samples (n,); 0 where they are constant."""
    steps = np.abs(np.diff(known))
    return float(steps[steps > 1e-9 * np.ptp(known)].min()) if steps.any() else 0.0


def near_limit(values: np.ndarray) -> np.ndarray:
    """Return the samples (n,) in stretches near the highest or the lowest value with little noise.

    An amplifier that is saturated before the converter shows its limit with a noise of about one
    count. This is a suspicion: a pressure that settles at its highest value may be as quiet.
    """
    near = np.zeros(len(values), dtype=bool)
    known = values[np.isfinite(values)]
    resolution = _resolution(known)
    if len(known) < 3 * _LEAST_NOISY_SAMPLES or not resolution:
        return near
    for limit in (known.max(), known.min()):
        within = np.abs(values - limit) <= (_COUNTS + 0.01) * resolution
        beyond = np.isfinite(values) & ~within
        for start, stop in _stretches(within):
            if stop - start < _LEAST_NOISY_SAMPLES:
                continue
            own = max(resolution, noise_of_differences(np.diff(values[start:stop], 2), 2))
            near[start:stop] |= _noise_near(values, beyond, start, stop) > _LESS_NOISE * own
    return near


def clipped_samples(sensed: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the clipped samples (n,) of each channel that has some.

    ``sensed`` are the channels as logged, before any zero or mean. Position and valve commands are
    not tested: they rest at the limits of their ranges.
    """
    changed = {
        name: np.concatenate(([False], np.diff(values) != 0)) for name, values in sensed.items()
    }
    clipped = {}
    for name in _tested(sensed):
        others = [changes for other, changes in changed.items() if other not in (name, "t_s")]
        if others:
            clipped[name] = clipped_at_limit(sensed[name], np.logical_or.reduce(others))
    return {name: samples for name, samples in clipped.items() if samples.any()}


def suspected_samples(
    sensed: Mapping[str, np.ndarray], clipped: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Return the samples (n,) near a limit of each channel that has some and is not clipped."""
    near = {name: near_limit(sensed[name]) for name in _tested(sensed) if name not in clipped}
    return {name: samples for name, samples in near.items() if samples.any()}


def _tested(sensed: Mapping[str, np.ndarray]) -> list[str]:
    return [name for name in sensed if name.startswith("p_") or name == "f_applied_n"]


def _stretches(held: np.ndarray) -> np.ndarray:
    """Return start and end (m, 2) of each run of True in ``held`` (n,); the end is excluded."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], held.astype(int), [0]))))
    return edges.reshape(-1, 2)


def _longest(held: np.ndarray) -> int:
    """Return the length of the longest run of True."""
    return int(np.diff(_stretches(held)).max(initial=0))


def _noise_near(values: np.ndarray, within: np.ndarray, start: int, stop: int) -> float:
    """Return the noise of the samples ``within`` the limits next to those of start to stop."""
    before = values[:start][within[:start]][-_NEAR:]
    after = values[stop:][within[stop:]][:_NEAR]
    return noise_of_differences(np.concatenate([np.diff(before, 2), np.diff(after, 2)]), 2)
