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
_SMALL_NOISE = 0.005  # of the largest friction: the largest of such values is hardly too large
_HALF_SAMPLES = 3  # of a line through every other sample, at least


class Peak(NamedTuple):
    """The first maximum of friction: its sample, and how many up to it are a straight line."""

    at: int
    samples: int
    fallen: int = 0  # the sample at which friction has fallen
    noise_n: float = 0.0  # standard deviation of the line's end


def first_peak(friction_n: np.ndarray) -> Peak | None:
    """Return the first maximum of friction (n,) [N], positive against the push.

    Friction is the end of a straight line through the last m samples, with the variance
    4 sigma^2 / m, so that the largest of many noisy samples is no maximum. A maximum counts once
    friction has fallen below it by ``least_fall``. None if friction rises until the end. Sliding
    friction may exceed it later, since the pressures rise.
    """
    if not _pushes(friction_n):
        return None
    lines = _lines(friction_n)
    friction = lines.ends_n
    highest = np.maximum.accumulate(friction)
    fallen = (highest - friction > lines.fall_n) & (highest >= _HIGH * friction.max())
    if not fallen.any():
        return None
    end = int(np.argmax(fallen))
    return Peak(int(np.argmax(friction[:end])), lines.samples, end, lines.noise_n)


def peak_n(t_s: np.ndarray, friction_n: np.ndarray, peak: Peak) -> float:
    """Return friction [N] at the first maximum of friction (n,) [N] at t_s (n,) [s].

    The largest of noisy values is too large in the mean. Where noise matters, the moment is that
    of every other sample and the value that of the samples between, whose noise is independent;
    the result is the mean of both choices.
    """
    if peak.noise_n <= _SMALL_NOISE * friction_n.max():
        return _end_of_line(t_s, friction_n, float(t_s[peak.at]), peak.samples)
    half = max(peak.samples // 2, _HALF_SAMPLES)
    values = []
    even, odd = slice(0, None, 2), slice(1, None, 2)
    for chosen, others in ((even, odd), (odd, even)):
        ends = _ends_of_lines(friction_n[chosen], half)
        rising = t_s[chosen] < t_s[peak.fallen]
        at_s = float(t_s[chosen][rising][np.argmax(ends[rising])])
        values.append(_end_of_line(t_s[others], friction_n[others], at_s, half))
    return float(np.mean(values))


def _end_of_line(t_s: np.ndarray, y: np.ndarray, at_s: float, m: int) -> float:
    """Return at ``at_s`` the straight line through the last m of y (n,) up to it, at least two."""
    last = max(int(np.searchsorted(t_s, at_s, side="right")), 2)
    line = slice(max(last - m, 0), last)
    return float(np.polyval(np.polyfit(t_s[line] - at_s, y[line], 1), 0.0))


def least_fall(friction_n: np.ndarray) -> float:
    """Return the fall [N] of friction (n,) [N] after a maximum that counts.

    1 % of the largest friction, or eight standard deviations of the noise of a line's end, if that
    is more. NaN without friction against the push.
    """
    return _lines(friction_n).fall_n if _pushes(friction_n) else float("nan")


def _pushes(friction_n: np.ndarray) -> bool:
    return len(friction_n) >= 4 and float(friction_n.max()) > 0.0


class _Lines(NamedTuple):
    """Straight lines through the last samples before each of n samples of friction."""

    samples: int  # of a line
    ends_n: np.ndarray  # (n,) [N]
    noise_n: float  # standard deviation of an end
    fall_n: float  # below a maximum of the ends, that counts


def _lines(friction_n: np.ndarray) -> _Lines:
    noise = noise_of_differences(np.diff(friction_n, 2), 2)  # second ones: the push is a ramp
    samples = int(np.ceil((2 * noise / (_NOISE * friction_n.max())) ** 2))
    samples = min(max(samples, _SAMPLES), len(friction_n) // 2)
    ends = _ends_of_lines(friction_n, samples)
    of_end = 2 * noise / float(np.sqrt(samples))
    fall = max(_FALL * float(ends.max()), _FALL_NOISE * of_end)
    return _Lines(samples, ends, of_end, fall)


def _ends_of_lines(y: np.ndarray, m: int) -> np.ndarray:
    """Return the ends of least-squares lines through each value of ``y`` (n,) and m - 1 before it.

    With j = 0 for the last sample, its weights are (4 m - 2 - 6 j) / (m (m + 1)). Before the first
    sample ``y`` is constant.
    """
    weights = (4 * m - 2 - 6 * np.arange(m)) / (m * (m + 1))
    return np.convolve(np.pad(y, (m - 1, 0), mode="edge"), weights, mode="valid")
