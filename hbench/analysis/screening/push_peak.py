"""The moment at which a pushed piston breaks away: the first maximum of its friction."""

from typing import NamedTuple

import numpy as np

from hbench.motion.noise import noise_of_differences

FALL = 0.03  # of the largest friction, by which it falls after the maximum
_FALL_NOISE = 8.0  # or so many standard deviations of the noise, if that is more: 4 up, 4 down
_HIGH = 0.7  # of the largest friction: humps below it are those of the loop as the push begins
_SAMPLES = 5  # of a straight line at least, ...
_NOISE = 0.01  # ... and so many that the noise of its end is this part of the largest friction


class Peak(NamedTuple):
    """The first maximum of friction: its sample, and how many up to it are a straight line."""

    at: int
    samples: int


def first_peak(friction_n: np.ndarray) -> Peak | None:
    """Return the first maximum of friction (n,) [N], positive against the push.

    Friction is the end of a straight line through the last m samples, with the variance
    4 sigma^2 / m, so that the largest of many noisy samples is no maximum. A maximum counts once
    friction has fallen below it by 3 %, and by more than noise. None if friction rises until the
    end. Sliding friction may exceed it later, since the pressures rise.
    """
    if len(friction_n) < 4 or not float(friction_n.max()) > 0.0:
        return None
    noise = noise_of_differences(np.diff(friction_n, 2), 2)  # second ones: the push is a ramp
    samples = int(np.ceil((2 * noise / (_NOISE * friction_n.max())) ** 2))
    samples = min(max(samples, _SAMPLES), len(friction_n) // 2)
    friction = _ends_of_lines(friction_n, samples)
    most = float(friction.max())
    highest = np.maximum.accumulate(friction)
    limit = max(FALL * most, _FALL_NOISE * 2 * noise / np.sqrt(samples))
    fallen = (highest - friction > limit) & (highest >= _HIGH * most)
    if not fallen.any():
        return None
    return Peak(int(np.argmax(friction[: np.argmax(fallen)])), samples)


def _ends_of_lines(y: np.ndarray, m: int) -> np.ndarray:
    """Return the ends of least-squares lines through each value of ``y`` (n,) and m - 1 before it.

    With j = 0 for the last sample, its weights are (4 m - 2 - 6 j) / (m (m + 1)). Before the first
    sample ``y`` is constant.
    """
    weights = (4 * m - 2 - 6 * np.arange(m)) / (m * (m + 1))
    return np.convolve(np.pad(y, (m - 1, 0), mode="edge"), weights, mode="valid")
