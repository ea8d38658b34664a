"""Sections of a run's log by its reference, or by its motion: cycles and levels."""

import numpy as np

from hbench.motion.reversals import cut_at_reversals
from hbench.records import Run

_WHOLE = 0.75  # of the travel: a shorter stroke is not one of a cycle
_AT_REST = 0.05  # of the top speed: a lower final speed completes the last cycle


def whole_cycles(v_ref_m_s: np.ndarray) -> list[slice]:
    """Return a triangle's complete cycles, each from rest through both directions to rest."""
    starts = 1 + np.flatnonzero((v_ref_m_s[:-1] < 0) & (v_ref_m_s[1:] >= 0))
    edges = [0, *starts.tolist()]
    falling_in_last = (v_ref_m_s[edges[-1] :] < 0).any()
    if falling_in_last and abs(v_ref_m_s[-1]) <= _AT_REST * np.abs(v_ref_m_s).max():
        edges.append(len(v_ref_m_s))
    return [slice(a, b) for a, b in zip(edges[:-1], edges[1:], strict=True) if b - a > 4]


def cycles_with_rise(run: Run) -> list[tuple[slice, np.ndarray]]:
    """Return a run's complete cycles, with where its speed rises (n,) in each.

    Without a logged reference a cycle is a stroke and the next one, between reversals of the
    position. The speed then rises in the first half of the time of an extending stroke and in the
    second half of a retracting one, as in a sine.
    """
    if run.v_ref_m_s is not None:
        v_ref = run.v_ref_m_s
        return [(each, np.gradient(v_ref[each]) > 0) for each in whole_cycles(v_ref)]
    strokes = cut_at_reversals(run.t_s, run.x_m, _WHOLE * float(np.ptp(run.x_m))).pieces
    pairs = zip(strokes[::2], strokes[1::2], strict=False)
    return [
        (slice(a.start, b.stop), np.concatenate([_rises(run.x_m[a]), _rises(run.x_m[b])]))
        for a, b in pairs
        if a.stop == b.start
    ]


def _rises(x_m: np.ndarray) -> np.ndarray:
    first_half = np.arange(len(x_m)) < len(x_m) / 2
    return first_half if x_m[-1] > x_m[0] else ~first_half


def level_windows(run: Run) -> list[tuple[float, slice]]:
    """Return each level [m/s] of a run of steps and the second half of its time, in order.

    A level is a section of constant reference; records during a change belong to no level.
    """
    v_ref = run.channel("v_ref_m_s")
    edges = np.flatnonzero(np.diff(v_ref)) + 1
    bounds = [0, *edges.tolist(), len(v_ref)]
    return [
        (float(v_ref[a]), slice((a + b) // 2, b))
        for a, b in zip(bounds[:-1], bounds[1:], strict=True)
        if b - a > 2
    ]
