"""Sections of a run's log by its reference: cycles and levels."""

import numpy as np

from hbench.analysis.screening.friction_channels import required
from hbench.records import Run

_AT_REST = 0.05  # of the top speed: a lower final speed completes the last cycle


def whole_cycles(v_ref_m_s: np.ndarray) -> list[slice]:
    """Return a triangle's complete cycles, each from rest through both directions to rest."""
    starts = 1 + np.flatnonzero((v_ref_m_s[:-1] < 0) & (v_ref_m_s[1:] >= 0))
    edges = [0, *starts.tolist()]
    falling_in_last = (v_ref_m_s[edges[-1] :] < 0).any()
    if falling_in_last and abs(v_ref_m_s[-1]) <= _AT_REST * np.abs(v_ref_m_s).max():
        edges.append(len(v_ref_m_s))
    return [slice(a, b) for a, b in zip(edges[:-1], edges[1:], strict=True) if b - a > 4]


def level_windows(run: Run) -> list[tuple[float, slice]]:
    """Return each level [m/s] of a run of steps and the second half of its time, in order.

    A level is a section of constant reference; records during a change belong to no level.
    """
    v_ref = required(run, "v_ref_m_s")
    edges = np.flatnonzero(np.diff(v_ref)) + 1
    bounds = [0, *edges.tolist(), len(v_ref)]
    return [
        (float(v_ref[a]), slice((a + b) // 2, b))
        for a, b in zip(bounds[:-1], bounds[1:], strict=True)
        if b - a > 2
    ]
