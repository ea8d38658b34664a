"""Foreign channels that stand at their converter's end: the true value is beyond, not known.

Such a channel stays at exactly its highest or lowest value for three samples or more while others
move, and longer than at any value between. A quiet channel of coarse resolution does so too without
being clipped, at the top of a wave or settled: there it can't be told, and nothing is said. Only
where the noise from sample to sample is above the resolution is staying no chance.
"""

from collections.abc import Mapping

import numpy as np

LEAST = 3  # samples in a row
_LIVELY = 1.5  # noise in units of the resolution


def at_an_end(values: np.ndarray, others_move: np.ndarray) -> np.ndarray:
    """Return the samples (n,) at an end of the converter; none where that can't be told.

    ``others_move`` (n,) tells where another channel differs from the sample before: a log in which
    all stand still has stopped, and no converter is at its end.
    """
    none = np.zeros(len(values), dtype=bool)
    known = values[np.isfinite(values)]
    steps = np.abs(np.diff(known))
    if len(known) < 3 * LEAST or not steps.any():
        return none
    resolution = steps[steps > 1e-9 * np.ptp(known)].min()
    inside = known[(known > known.min()) & (known < known.max())]
    if _noise(inside) <= _LIVELY * resolution:
        return none
    least = max(LEAST, _longest(np.diff(inside) == 0) + 2)
    found = none
    for end in (known.max(), known.min()):
        at = values == end
        if _longest(at[1:] & at[:-1] & others_move[1:]) + 1 >= least:
            found = found | at
    return found


def clipped(sensed: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return for each channel that is clipped somewhere the samples (n,) in which it is.

    ``sensed`` are the channels as logged, before any zero or mean. Not the position and the
    commands to the valves: these do stand still at the ends of their ranges.
    """
    changed = {
        name: np.concatenate(([False], np.diff(values) != 0)) for name, values in sensed.items()
    }
    judged = [name for name in sensed if name.startswith("p_") or name == "f_applied_n"]
    found = {}
    for name in judged:
        others = [moves for other, moves in changed.items() if other not in (name, "t_s")]
        if others:
            found[name] = at_an_end(sensed[name], np.logical_or.reduce(others))
    return {name: samples for name, samples in found.items() if samples.any()}


def _longest(held: np.ndarray) -> int:
    """Return the length of the longest run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], held.astype(int), [0]))))
    return int((edges[1::2] - edges[::2]).max(initial=0))


def _noise(values: np.ndarray) -> float:
    """Return the standard deviation of white noise on a smooth signal, by second differences."""
    bends = np.abs(np.diff(values, 2))
    return float(np.median(bends) / (0.6745 * np.sqrt(6))) if len(bends) else 0.0
