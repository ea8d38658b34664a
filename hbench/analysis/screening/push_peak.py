"""The moment at which a pushed piston breaks away: the first maximum of its friction."""

import numpy as np

from hbench.motion.noise import noise_of_differences

_FALL = 0.03  # of the largest friction, by which it falls after the maximum
_FALL_NOISE = 5.0  # or so many standard deviations of the noise, if that is more
_HIGH = 0.7  # of the largest friction: humps below it are those of the loop as the push begins


def first_peak(friction_n: np.ndarray) -> int | None:
    """Return the index of the first maximum of friction (n,) [N], positive against the push.

    A maximum counts once friction has fallen below it by 3 %, and by more than noise. None if
    friction rises until the end. Sliding friction may exceed it later, since the pressures rise.
    """
    if len(friction_n) < 4 or not (most := float(friction_n.max())) > 0.0:
        return None
    highest = np.maximum.accumulate(friction_n)
    noise = noise_of_differences(np.diff(friction_n, 2), 2)  # second ones: the push is a ramp
    fallen = highest - friction_n > max(_FALL * most, _FALL_NOISE * noise)
    fallen &= highest >= _HIGH * most
    if not fallen.any():
        return None
    return int(np.argmax(friction_n[: np.argmax(fallen)]))
