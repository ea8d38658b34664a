"""The moment at which a pushed piston breaks away: the first maximum of its friction."""

from typing import NamedTuple

import numpy as np

from hbench.motion.noise import noise_of_differences

# Of the largest friction, by which it falls after the maximum. Pressures rise during a push, and
# the friction of seals with them: of a fall of a tenth they may leave less than 3 %.
_FALL = 0.01
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
    friction has fallen below it by ``least_fall``. None if friction rises until the end. Sliding
    friction may exceed it later, since the pressures rise.
    """
    if not _pushes(friction_n):
        return None
    samples, limit = _samples_and_fall(friction_n)
    friction = _ends_of_lines(friction_n, samples)
    highest = np.maximum.accumulate(friction)
    fallen = (highest - friction > limit) & (highest >= _HIGH * friction.max())
    if not fallen.any():
        return None
    return Peak(int(np.argmax(friction[: np.argmax(fallen)])), samples)


def least_fall(friction_n: np.ndarray) -> float:
    """Return the fall [N] of friction (n,) [N] after a maximum that counts.

    1 % of the largest friction, or eight standard deviations of the noise of a line's end, if that
    is more. NaN without friction against the push.
    """
    return _samples_and_fall(friction_n)[1] if _pushes(friction_n) else float("nan")


def _pushes(friction_n: np.ndarray) -> bool:
    return len(friction_n) >= 4 and float(friction_n.max()) > 0.0


def _samples_and_fall(friction_n: np.ndarray) -> tuple[int, float]:
    """Return the samples of a line, and the fall [N] that counts."""
    noise = noise_of_differences(np.diff(friction_n, 2), 2)  # second ones: the push is a ramp
    samples = int(np.ceil((2 * noise / (_NOISE * friction_n.max())) ** 2))
    samples = min(max(samples, _SAMPLES), len(friction_n) // 2)
    most = float(_ends_of_lines(friction_n, samples).max())
    return samples, max(_FALL * most, _FALL_NOISE * 2 * noise / float(np.sqrt(samples)))


def _ends_of_lines(y: np.ndarray, m: int) -> np.ndarray:
    """Return the ends of least-squares lines through each value of ``y`` (n,) and m - 1 before it.

    With j = 0 for the last sample, its weights are (4 m - 2 - 6 j) / (m (m + 1)). Before the first
    sample ``y`` is constant.
    """
    weights = (4 * m - 2 - 6 * np.arange(m)) / (m * (m + 1))
    return np.convolve(np.pad(y, (m - 1, 0), mode="edge"), weights, mode="valid")
