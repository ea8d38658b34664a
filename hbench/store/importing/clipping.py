"""Detection of clipped channels in imported logs: the true value is beyond the converter's range.

A clipped channel stays at exactly its highest or lowest value for three samples or more while
other channels change, and longer than at any value between. An unclipped channel with little noise
and coarse resolution does the same, at a peak or when settled. Clipping is therefore reported only
where the noise from sample to sample, just before and after, is above the resolution: a run is
noisier while it moves or oscillates than when it has settled.

A frozen channel repeats its last value, whatever that is: a sensor that hangs, or a bus that fails.
Noise does not end from one sample to the next, as it does there.
"""

from collections.abc import Mapping

import numpy as np

from hbench.motion.noise import noise_of_differences

LEAST_SAMPLES = 3  # consecutive
_LEAST_NOISE = 1.5  # in units of the resolution
_NEAR = 30  # samples before and after, which the noise is of
_COUNTS = 2  # of the resolution: a limit with a noise of one count up and down
_LEAST_NOISY_SAMPLES = 10  # consecutive within these counts
_FROZEN = 3  # times: a frozen stretch over the longest other one
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


def frozen_at(values: np.ndarray, others_change: np.ndarray) -> np.ndarray:
    """Return the samples (n,) of stretches in which a noisy channel repeats one value exactly.

    They are longer than the samples that their noise is of, and three times as long as all other
    stretches of equal samples. The noise next to them is above the resolution.
    """
    frozen = np.zeros(len(values), dtype=bool)
    resolution = _resolution(values[np.isfinite(values)])
    if not resolution:
        return frozen
    equal = np.diff(values) == 0
    stretches = _stretches(equal)
    lengths = np.diff(stretches).ravel()
    long = lengths >= _NEAR
    least = _FROZEN * lengths[~long].max(initial=1)
    inside = np.isfinite(values)
    for start, stop in stretches[long & (lengths >= least)]:
        alone = not others_change[start + 1 : stop + 1].any()
        if alone or _noise_near(values, inside, start, stop + 1) <= _LEAST_NOISE * resolution:
            continue
        frozen[start : stop + 1] = True
    return frozen


def frozen_samples(
    sensed: Mapping[str, np.ndarray], clipped: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Return the frozen samples (n,) of each channel that has some and is not clipped."""
    found = {}
    for name in _tested(sensed):
        others = [
            np.diff(v, prepend=v[0]) != 0 for k, v in sensed.items() if k not in (name, "t_s")
        ]
        if name not in clipped and others:
            found[name] = frozen_at(sensed[name], np.logical_or.reduce(others))
    return {name: samples for name, samples in found.items() if samples.any()}


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
