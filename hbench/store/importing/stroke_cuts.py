"""Cuts a back-and-forth motion at its reversals into strokes of one direction each."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# A turn counts once the position has come back by this part of the shortest stroke: far above
# the noise of a position sensor, far below a stroke.
_TURN = 0.1


@dataclass(frozen=True)
class Strokes:
    """Whole strokes, and what was left out."""

    pieces: tuple[slice, ...]  # of samples, in order; none is in two
    partial: int  # before the first and after the last reversal
    short: int  # pieces between two reversals shorter than the limit


def cut_at_reversals(x_m: np.ndarray, min_stroke_m: float) -> Strokes:
    """Cut positions ``x_m`` (n,) into strokes of at least ``min_stroke_m``.

    A stroke goes from one reversal to the next. What comes before the first and after the last
    one is left out, since where it began or would have ended is not known.
    """
    turns = _turning_points(x_m.tolist(), _TURN * min_stroke_m)
    pairs = list(zip(turns, turns[1:], strict=False))
    whole = [slice(a, b) for a, b in pairs if abs(x_m[b] - x_m[a]) >= min_stroke_m]
    ends = int(len(x_m) > 0) if not turns else int(turns[0] > 0) + int(turns[-1] < len(x_m) - 1)
    return Strokes(tuple(whole), partial=ends, short=len(pairs) - len(whole))


def stroke_speed(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the speed of one stroke [m/s], signed: the slope over the middle half of its way."""
    start, end = x_m[0], x_m[-1]
    part = (x_m - start) / (end - start)
    middle = (part > 0.25) & (part < 0.75)
    if middle.sum() < 3:
        return float((end - start) / (t_s[-1] - t_s[0]))
    t, x = t_s[middle] - t_s[middle].mean(), x_m[middle]
    return float(t @ x / (t @ t))


def _turning_points(x: Sequence[float], turn: float) -> list[int]:
    """Return the samples at which motion reverses: extremes that x has left by ``turn``."""
    turns: list[int] = []
    low = high = 0  # where the extremes since the last turn are
    direction = 0  # not known before x has moved by ``turn``
    for i, value in enumerate(x):
        if value > x[high]:
            high = i
        if value < x[low]:
            low = i
        if direction >= 0 and x[high] - value > turn:
            if direction:
                turns.append(high)
            direction, low = -1, i
        elif direction <= 0 and value - x[low] > turn:
            if direction:
                turns.append(low)
            direction, high = 1, i
    return turns
