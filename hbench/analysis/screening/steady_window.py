"""The steady section of a run: the samples at the reference, and the window to average."""

import numpy as np

from hbench.analysis.screening.steadiness import BLOCK_S, speeds_over_tenths
from hbench.config.schedule import Screening
from hbench.motion.plateaus import plateau_at, plateaus
from hbench.motion.settling import settled
from hbench.records import Run

NOTHING = slice(0, 0)


def at_reference(run: Run) -> slice:
    """Return the samples at the reference speed.

    The board marks them, and a logged reference does, unless it is the same throughout. In other
    logs they are the plateau at the run's nominal speed, wherever it is in the log.
    """
    if run.at_reference is None or run.at_reference.all():
        return _settled(run)
    marked = np.flatnonzero(run.at_reference)
    return slice(marked[0], marked[-1] + 1) if len(marked) else NOTHING


def steady_window(run: Run, section: slice, rules: Screening) -> slice:
    """Return the window: ``section`` after ``settle_time`` and after ``settle_travel``.

    Of strokes in both directions only the positions count that both cover, if the plan has them.
    """
    window = settled(run.t_s, run.x_m, section, rules.settle_time, rules.settle_travel)
    positions = run.plan.positions_m
    if positions is None:
        return window
    inside = np.flatnonzero((run.x_m[window] >= positions[0]) & (run.x_m[window] <= positions[1]))
    if not len(inside):
        return NOTHING
    return slice(window.start + int(inside[0]), window.start + int(inside[-1]) + 1)


def window_length_s(run: Run, window: slice) -> float:
    """Return the time that a window's samples cover: n sampling intervals."""
    t = run.t_s[window]
    return float((t[-1] - t[0]) * len(t) / (len(t) - 1)) if len(t) > 1 else 0.0


def standstill_s(run: Run, section: slice) -> float:
    """Return the time [s] that the piston is at rest at the end of ``section``, after motion.

    It is zero if the piston moves at the end, or was at rest in between (stick-slip).
    """
    v_ref = abs(run.plan.v_ref_m_s)
    speeds = speeds_over_tenths(run.t_s[: section.stop], run.x_m[: section.stop])
    slow = max(0.1 * v_ref, 3 * speeds.noise_m_s)
    moving = np.flatnonzero(np.abs(speeds.v_m_s) > max(0.5 * v_ref, slow))
    if not len(moving):
        return 0.0
    at_rest = np.abs(speeds.v_m_s) < slow
    tail = len(at_rest) if at_rest.all() else int(np.argmin(at_rest[::-1]))
    before = at_rest[moving[0] : len(at_rest) - tail]
    return 0.0 if before.any() else tail * BLOCK_S


def _settled(run: Run) -> slice:
    """Return the plateau at the run's speed, or else the longest one in its direction."""
    t, x, v_ref = run.t_s, run.x_m, run.plan.v_ref_m_s
    section = plateau_at(t, x, v_ref)
    if window_length_s(run, section) > 0.0:
        return section
    others = [p.section for p in plateaus(t, x) if p.v_m_s * v_ref > 0]
    return max(others, key=lambda other: window_length_s(run, other), default=NOTHING)
