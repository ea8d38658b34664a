"""Cutting of a reciprocating motion at its reversals into strokes of one direction each."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hbench.motion.noise import noise_over_motion
from hbench.motion.rest import BLOCK_S, rest_before_motion

# A reversal counts once the position has returned by this fraction of the shortest stroke: far
# above the noise of a position sensor, far below a stroke.
_TURN = 0.1
_NOISE_SIGMAS = 10.0  # of the position's noise: a smaller return is no reversal
_REST_S = 0.2  # shorter ones at the ends of a log are no rest
LONGEST_STEP_S = BLOCK_S  # between the samples of a rest
_ROUNDING_S = 1e-6  # of times that are written in decimals
SAME_LENGTH, _SAME_DURATION = 0.10, 0.25  # relative differences of settled strokes
# Relative difference of the speeds of strokes that count as the same speed: often it is not
# controlled.
SAME_STROKE_SPEED = 0.20


@dataclass(frozen=True)
class StrokeCuts:
    """Complete strokes, and the numbers of omitted sections."""

    pieces: tuple[slice, ...]  # of samples, in order, disjoint
    partial: int  # sections before the first and after the last reversal
    short: int  # sections between two reversals shorter than the limit


def cut_at_reversals(t_s: np.ndarray, x_m: np.ndarray, min_stroke_m: float) -> StrokeCuts:
    """Cut positions ``x_m`` (n,) into strokes of at least ``min_stroke_m``.

    A stroke extends from one reversal to the next, or from and to a rest at the ends of the log.
    Sections at the ends without rest are left out, since their start or end is not known.
    """
    if not len(x_m):
        return StrokeCuts((), partial=0, short=0)
    turns = _turning_points(x_m.tolist(), _TURN * min_stroke_m)
    first, last = (turns[0], turns[-1]) if turns else (len(x_m) - 1, 0)
    start = _rest_length(t_s, x_m[: first + 1])
    stop = len(x_m) - 1 - _rest_length(-t_s[::-1], x_m[last:][::-1])
    from_rest, to_rest = start > 0, stop < len(x_m) - 1
    if turns:
        ends = [*([start] if from_rest else []), *turns, *([stop] if to_rest else [])]
        partial = (turns[0] > 0 and not from_rest) + (turns[-1] < len(x_m) - 1 and not to_rest)
    else:
        whole = from_rest and to_rest and np.ptp(x_m) >= min_stroke_m
        ends, partial = ([start, stop], 0) if whole else ([], 1)
    pairs = list(zip(ends, ends[1:], strict=False))
    pieces = [slice(a, b) for a, b in pairs if abs(x_m[b] - x_m[a]) >= min_stroke_m]
    return StrokeCuts(tuple(pieces), partial=int(partial), short=len(pairs) - len(pieces))


def travel(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the distance travelled [m] over positions ``x_m`` (n,), from reversal to reversal.

    A return by less than ten times the noise is no reversal, so that noise at rest adds nothing.
    """
    if len(x_m) < 2:
        return 0.0
    turns = _turning_points(x_m.tolist(), _NOISE_SIGMAS * noise_over_motion(t_s, x_m))
    return float(np.abs(np.diff(x_m[[0, *turns, len(x_m) - 1]])).sum())


def settled_strokes(t_s: np.ndarray, x_m: np.ndarray, pieces: Sequence[slice]) -> tuple[slice, ...]:
    """Return the strokes without run-in and run-out.

    These are strokes at the beginning and the end whose length or duration differs from the median
    of their direction. If most differ, none is left out.
    """
    travels = np.array([x_m[p.stop] - x_m[p.start] for p in pieces])
    times = np.array([t_s[p.stop] - t_s[p.start] for p in pieces])
    same = np.ones(len(pieces), dtype=bool)
    for direction in (travels > 0, travels < 0):
        for values, tolerance in ((np.abs(travels), SAME_LENGTH), (times, _SAME_DURATION)):
            if direction.any():
                median = np.median(values[direction])
                same &= ~direction | (np.abs(values - median) <= tolerance * median)
    if same.sum() <= len(pieces) / 2:
        return tuple(pieces)
    kept = np.flatnonzero(same)
    return tuple(pieces[kept[0] : kept[-1] + 1])


def stroke_speed(t_s: np.ndarray, x_m: np.ndarray) -> float:
    """Return the signed speed of a stroke [m/s]: the slope over the middle half of its travel."""
    start, end = x_m[0], x_m[-1]
    if start == end:
        return 0.0
    travelled = (x_m - start) / (end - start)
    middle = (travelled > 0.25) & (travelled < 0.75)
    if middle.sum() < 3:
        return float((end - start) / (t_s[-1] - t_s[0]))
    t, x = t_s[middle] - t_s[middle].mean(), x_m[middle]
    return float(t @ x / (t @ t))


def _rest_length(t_s: np.ndarray, x_m: np.ndarray) -> int:
    """Return the number of samples at rest at the start, or 0 for a rest of less than 0.2 s."""
    if len(x_m) < 2:
        return 0
    rest = rest_before_motion(t_s[: len(x_m)], x_m, None)
    t = t_s[rest]
    if len(t) < 2 or rest.stop == len(x_m):
        return 0
    gap_s = np.diff(t).max()
    whole = (
        t[-1] - t[0] >= _REST_S - BLOCK_S - _ROUNDING_S and gap_s <= LONGEST_STEP_S + _ROUNDING_S
    )
    return rest.stop if whole else 0


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
