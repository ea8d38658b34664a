"""Hysteresis loops of triangles: friction over velocity and over position (sections 3.1.3, 6.2.3).

    energy per cycle       W = integral of F dx around the loop = integral of F v dt
    width at velocity v    |F| while |v| rises  -  |F| while it falls

Phase. A filter that delays the velocity by tau creates an apparent loop of width 2 tau a dF/dv.
Therefore the velocity is the position's derivative without lag (``logged_motion``), the inertia
uses the same derivative, and pressures, force and position are all unfiltered means over one
interval of the log, with the same delay. The controller's velocity has the lag of its filter
(D.11); ``board_n`` is the width with that velocity, which shows the filter's effect.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from hbench.analysis.curves.average import student_interval
from hbench.analysis.rounding import is_constant
from hbench.analysis.screening.reference_sections import cycles_with_rise
from hbench.analysis.screening.sample_friction import logged_motion
from hbench.errors import DataError
from hbench.records import Loop, LoopWidth, Run, ScreenedRun

_SHARES = (-0.75, -0.5, -0.25, 0.25, 0.5, 0.75)  # of the top speed, at which widths are read
_SPAN = 0.1  # of the top speed, to either side: samples for a width's parabolas
_LEAST = 5  # samples of a parabola
_SAME_TRAVEL = 1.1  # ratio of two travels: a larger one is that of another motion
_PHASES = 240  # of the mean loop


@dataclass(frozen=True)
class Cycle:
    """Energy, widths and trace of one cycle."""

    area_j: float
    widths_n: np.ndarray  # (6,) at ``_SHARES``; nan with too few samples
    board_n: np.ndarray
    trace: np.ndarray  # (phases, 3): x_m, v_m_s, friction_n


def hysteresis(
    screened: Iterable[ScreenedRun], mass_kg: float
) -> tuple[tuple[Loop, ...], tuple[str, ...]]:
    """Return a loop for each triangle (label, load, speed, travel) of accepted runs, and notes.

    If a run has several cycles, the first is left out: it begins with relaxed seals. Intervals
    are over trials, or over the cycles of a single trial. ``mass_kg`` is the test side's.
    """
    groups: dict[tuple, list[Run]] = defaultdict(list)
    for verdict in screened:
        plan = verdict.run.plan
        if verdict.accepted:
            key = plan.kind, plan.series, plan.specimen, abs(plan.v_ref_m_s)
            groups[key].append(verdict.run)
    loops, notes = [], []
    for runs in (alike for group in groups.values() for alike in _of_one_travel(group)):
        trials: dict[int, list[Cycle]] = defaultdict(list)
        for run in runs:
            try:
                trials[run.plan.trial] += cycles_of(run, mass_kg)
            except DataError as error:
                notes.append(f"left out of the hysteresis: {error.message}")
        used = [cycles for cycles in trials.values() if cycles]
        if used:
            loops.append(_loop(runs, used))
    return tuple(loops), tuple(notes)


def _of_one_travel(runs: Sequence[Run]) -> Iterator[list[Run]]:
    """Yield the runs whose travels differ by less than a tenth, as trials of one motion do."""
    ordered = sorted(runs, key=lambda run: np.ptp(run.x_m))
    travels = np.array([np.ptp(run.x_m) for run in ordered])
    edges = [0, *(1 + np.flatnonzero(travels[1:] > _SAME_TRAVEL * travels[:-1])), len(ordered)]
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        yield sorted(ordered[first:last], key=lambda run: run.plan.run)


def cycles_of(run: Run, mass_kg: float) -> list[Cycle]:
    """Return a run's complete cycles, without the first if there are several.

    Raises ``DataError`` if a channel or a record is missing, or without a complete cycle.
    """
    motion, top = logged_motion(run, mass_kg), abs(run.plan.v_ref_m_s)
    found = cycles_with_rise(run)
    if not found:
        raise DataError(f"run {run.plan.run}: contains no complete cycle")
    cycles = []
    for window, rising in found[1:] or found:
        v, friction = motion.v_m_s[window], motion.friction_n[window]
        board = None if run.v_m_s is None else run.v_m_s[window]
        nothing = np.full(len(_SHARES), np.nan)
        cycles.append(
            Cycle(
                area_j=float(np.sum(friction * v) * motion.dt_s),
                widths_n=_widths(v, friction, rising, top),
                board_n=nothing if board is None else _widths(board, friction, rising, top),
                trace=_trace(np.column_stack([run.x_m[window], v, friction])),
            )
        )
    return cycles


def _widths(v: np.ndarray, friction: np.ndarray, rising: np.ndarray, top: float) -> np.ndarray:
    widths = []
    for share in _SHARES:
        near = np.abs(v - share * top) <= _SPAN * top
        up, down = (
            _friction_at(share * top, v[near & branch], friction[near & branch])
            for branch in (rising, ~rising)
        )
        widths.append(up - down)  # for v < 0, |v| falls while v rises, and |F| = -F
    return np.array(widths)


def _friction_at(v0: float, v: np.ndarray, friction: np.ndarray) -> float:
    """Return the friction at ``v0`` on a parabola fitted to the samples near it."""
    if len(v) < _LEAST or is_constant(v):
        return np.nan
    return float(np.polynomial.Polynomial.fit(v, friction, 2)(v0))


def _trace(samples: np.ndarray) -> np.ndarray:
    """Return the means (phases, 3) of a cycle's samples (n, 3) in equal parts of its time."""
    phases = min(_PHASES, len(samples))
    edges = np.linspace(0, len(samples), phases + 1).astype(int)
    return np.add.reduceat(samples, edges[:-1]) / np.diff(edges)[:, None]


def _loop(runs: Sequence[Run], trials: list[list[Cycle]]) -> Loop:
    plan = runs[0].plan
    by_trial = len(trials) > 1
    units = trials if by_trial else [[cycle] for cycle in trials[0]]
    cycles = [cycle for trial in trials for cycle in trial]
    phases = min(len(cycle.trace) for cycle in cycles)
    area = np.array([np.mean([cycle.area_j for cycle in unit]) for unit in units])
    widths = np.array([np.mean([cycle.widths_n for cycle in unit], axis=0) for unit in units])
    board = np.mean([cycle.board_n for cycle in cycles], axis=0)
    trace = np.mean([cycle.trace[:phases] for cycle in cycles], axis=0)
    return Loop(
        series=plan.series,
        v_top_m_s=abs(plan.v_ref_m_s),
        a_m_s2=plan.a_ref_m_s2,
        cycles=len(cycles),
        trials=len(trials),
        unit="trial" if by_trial else "cycle",
        area_j=float(area.mean()),
        area_ci95_j=student_interval(area),
        widths=tuple(
            LoopWidth(
                v_m_s=share * abs(plan.v_ref_m_s),
                width_n=float(widths[:, i].mean()),
                ci95_n=student_interval(widths[:, i]),
                board_n=float(board[i]) if np.isfinite(board[i]) else None,
            )
            for i, share in enumerate(_SHARES)
            if np.isfinite(widths[:, i]).all()
        ),
        trace=tuple((float(x), float(v), float(f)) for x, v, f in trace),
        runs=tuple(run.plan.run for run in runs),
        kind=plan.kind,
    )
