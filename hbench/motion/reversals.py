"""Cutting of a reciprocating motion at its reversals into strokes of one direction each."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

# A reversal counts once the position has returned by this fraction of the shortest stroke: far
# above the noise of a position sensor, far below a stroke.
_TURN = 0.1


@dataclass(frozen=True)
class StrokeCuts:
    """Complete strokes, and the numbers of omitted sections."""

    pieces: tuple[slice, ...]  # of samples, in order, disjoint
    partial: int  # sections before the first and after the last reversal
    short: int  # sections between two reversals shorter than the limit


def cut_at_reversals(x_m: np.ndarray, min_stroke_m: float) -> StrokeCuts:
    """Cut positions ``x_m`` (n,) into strokes of at least ``min_stroke_m``.

    A stroke extends from one reversal to the next. Sections before the first and after the last
    reversal are left out, since their start or end is not known.
    """
    turns = _turning_points(x_m.tolist(), _TURN * min_stroke_m)
    pairs = list(zip(turns, turns[1:], strict=False))
    whole = [slice(a, b) for a, b in pairs if abs(x_m[b] - x_m[a]) >= min_stroke_m]
    ends = int(len(x_m) > 0) if not turns else int(turns[0] > 0) + int(turns[-1] < len(x_m) - 1)
    return StrokeCuts(tuple(whole), partial=ends, short=len(pairs) - len(whole))


def stroke_speed(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the signed speed of a stroke [m/s]: the slope over the middle half of its travel."""
    start, end = x_m[0], x_m[-1]
    travelled = (x_m - start) / (end - start)
    middle = (travelled > 0.25) & (travelled < 0.75)
    if middle.sum() < 3:
        return float((end - start) / (t_s[-1] - t_s[0]))
    t, x = t_s[middle] - t_s[middle].mean(), x_m[middle]
    return float(t @ x / (t @ t))


def _turning_points(x: Sequence[float], turn: float) -> list[int]:
    """Return the samples of reversals: extremes from which x has moved by ``turn``."""
    turns: list[int] = []
    low = high = 0  # samples of the extremes since the last reversal
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
