"""Runs that can be compared with a model, and remarks on those that can only in part."""

from collections.abc import Sequence

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.errors import DataError
from hbench.reconcile.measured.session import CAVITATES_PA, RECORD_S, Session, averaged
from hbench.reconcile.measured.weak import sampling
from hbench.records import Run
from hbench.units import from_si

_MUCH = 0.25  # of a run's windows
_NOT_AVERAGED = 1.05  # times the records of averaged logs: the log itself is as slow
_OSCILLATES = (
    "The control oscillates too fast for records of {step_ms:.2g} ms ({runs}). The balances of "
    "flows and forces leave those windows out. {advice}"
)
_LOG_FASTER = "Log faster, or lower the gains of the loops."
_LOWER_GAINS = (
    "Lower the gains of the loops. Faster logs do not help: hbench averages them to about 10 ms."
)
_CAVITATES = (
    "The pressure of a chamber falls below {limit:g} bar ({runs}), where oil releases air. The "
    "balance of its flow leaves these moments out. Raise the pressure, or brake more gently."
)

_HAS_GAPS = (
    "Samples are missing for more than three records ({runs}). The balances leave these moments "
    "out."
)
_CONSTANT_SUPPLY = (
    "The supply pressure is a constant. If it falls with the flow, the flows deviate as if the "
    "valves were at fault: measure P_S before inspecting them."
)


def comparable_runs(runs: Sequence[Run]) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """Return the complete runs, evenly sampled, and the reasons for which others are left out."""
    usable, left_out = [], []
    for run in runs:
        reason = run.aborted
        try:
            even = averaged(run)
        except DataError as error:
            reason = reason or error.message.removeprefix(f"run {run.plan.run}: ")
        if reason := reason or incomplete_reason(even):
            left_out.append(f"run {run.plan.run}: {reason}")
        else:
            usable.append(even)
    return tuple(usable), tuple(left_out)


def incomplete_reason(run: Run) -> str:
    """Return why a run's log is incomplete or unevenly sampled; empty for a complete one."""
    inside = f"{run.missing_records} records are missing inside the log"
    if reason := run.truncated or (inside if run.missing_records else ""):
        return reason
    try:
        sampling(run)
    except DataError as error:
        return error.message.removeprefix(f"run {run.plan.run}: ")
    return ""


def log_remarks(logs: Sequence[Session]) -> tuple[str, ...]:
    """Return remarks on what the balances leave out, and on a supply that is not measured."""
    return (*_gaps(logs), *_oscillations(logs), *_cavitations(logs), *_constant_supply(logs))


def _constant_supply(logs: Sequence[Session]) -> tuple[str, ...]:
    """Return a remark on a supply pressure that is a known constant, as in an import map."""
    known = [log.measured["p_s_pa"].all() and is_constant(log.channels["p_s_pa"]) for log in logs]
    return (_CONSTANT_SUPPLY,) if known and all(known) else ()


def _gaps(logs: Sequence[Session]) -> tuple[str, ...]:
    """Return a remark on runs with gaps between samples."""
    runs = [run.plan.run for log in logs for run in log.runs if run.in_gap is not None]
    return (_HAS_GAPS.format(runs=_first_of(runs)),) if runs else ()


def _oscillations(logs: Sequence[Session]) -> tuple[str, ...]:
    """Return a remark on runs in which the control oscillates much of the time."""
    found = [
        (log.window.dt_s, run.plan.run)
        for log in logs
        for i, run in enumerate(log.runs)
        if log.counts[i] and log.oscillating[log.run_of_window == i].mean() > _MUCH
    ]
    if not found:
        return ()
    step_s = max(dt_s for dt_s, _ in found)
    advice = _LOG_FASTER if step_s > _NOT_AVERAGED * RECORD_S else _LOWER_GAINS
    runs = _first_of([run for _, run in found])
    return (_OSCILLATES.format(step_ms=from_si(step_s, "ms"), runs=runs, advice=advice),)


def _cavitations(logs: Sequence[Session]) -> tuple[str, ...]:
    """Return a remark on runs in which a chamber cavitates."""
    runs = [
        log.runs[i].plan.run
        for log in logs
        for i in np.unique(log.run_of_window[log.cavitating.any(axis=1)])
    ]
    limit = from_si(CAVITATES_PA, "bar")
    return (_CAVITATES.format(limit=limit, runs=_first_of(runs)),) if runs else ()


def _first_of(runs: Sequence[str]) -> str:
    return f"run {runs[0]}" + (f"; {len(runs)} runs in all" if len(runs) > 1 else "")
