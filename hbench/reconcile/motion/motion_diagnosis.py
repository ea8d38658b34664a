"""Diagnosis of a driven mass: force error and open-loop position error of held-out runs.

No value is fitted to every fifth run. These held-out runs decide whether a refit or an effect is
kept. The force error is that of the balance along the measured motion. The position error is that
of the motion that a model makes of the measured drive force. A model can improve one alone, so both
are always reported.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from hbench.config.stroke_model import MotionPlant
from hbench.reconcile.diagnose import NOT_SIMULATED, ReconcileTask, assembled
from hbench.reconcile.diagnosis_fields import ModelledData, insufficient_data_diagnosis
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.measured.balances import BALANCES
from hbench.reconcile.measured.comparable_runs import incomplete_reason
from hbench.reconcile.motion.force_unit import in_newtons
from hbench.reconcile.motion.measured_motion import (
    BALANCE,
    MeasuredMotion,
    measured_motion,
    observable_in_motion,
)
from hbench.reconcile.motion.motion_words import of_driven_mass
from hbench.reconcile.motion.open_loop import open_loop_positions
from hbench.reconcile.revised_model import without_unconfirmed
from hbench.reconcile.search.campaign_search import CampaignSearch
from hbench.reconcile.search_result import SearchResult
from hbench.reconcile.separation.missing_data import FEWEST_POINTS
from hbench.reconcile.separation.observable import divided_points
from hbench.records import Diagnosis, HeldOutError, Overlay, Run

_SHORTEST_S = 1.0
_NOTES = (
    "Motion of a driven mass: load_cell_offset is any constant force, such as a weight or an "
    "offset of the drive.",
)


@dataclass(frozen=True, kw_only=True)
class MotionTask(ModelledData):
    """Task of a diagnosis: runs with position and drive force, and a model of the mass."""

    plant: MotionPlant  # of the model
    runs: tuple[Run, ...]
    material: float
    stage: Callable[[str], None] = lambda stage: None  # receives a description of each stage


def diagnose_motion(task: MotionTask) -> Diagnosis:
    """Determine the effects behind the residuals of the force balance; see ``Diagnosis``."""
    usable, left_out = [], []
    for run in task.runs:
        if reason := _unusable(run):
            left_out.append(f"run {run.plan.run}: {reason}")
        else:
            usable.append(run)
    if len(usable) < FEWEST_POINTS:
        runs = (
            f"at least {FEWEST_POINTS} runs of {_SHORTEST_S:g} s with position and drive force; "
            f"there are {len(usable)}"
        )
        return insufficient_data_diagnosis(task, (runs,), tuple(left_out))
    names, not_tried = observable_in_motion(usable, task.plant)
    measured = measured_motion(task.plant, usable, task.material)
    train, held_out = divided_points(len(usable))
    search = CampaignSearch(measured, train, names, task.stage)
    result = without_unconfirmed(search, search.run(), held_out)
    whole = ReconcileTask(
        provenance=task.provenance,
        bench=None,
        model=task.model,
        plant=measured.plant,
        plant_data=task.plant_data,
        runs=tuple(run for log in measured.logs for run in log.runs),
        instruments=None,
        material=task.material,
        stage=task.stage,
    )
    diagnosis = assembled(whole, measured, result, held_out, not_tried, (), tuple(left_out))
    fitted = frozenset(measured.start.effects) | frozenset(result.names)
    errors, shown = _held_out_errors(measured, result, held_out)
    notes = tuple(note for note in diagnosis.notes if note != NOT_SIMULATED)
    has_load = any(run.f_applied_n is not None and run.f_applied_n.any() for run in usable)
    of_mass = of_driven_mass(in_newtons(diagnosis, measured.unit_n, fitted), names, has_load)
    return replace(
        of_mass,
        errors=errors,
        overlays=(shown,),
        notes=(*_NOTES, *notes),
    )


def _unusable(run: Run) -> str:
    """Return why a run is left out; empty for a usable one."""
    if run.f_drive_n is None:
        return "no drive force"
    if reason := run.aborted or incomplete_reason(run):
        return reason
    duration = float(run.t_s[-1] - run.t_s[0])
    if duration < _SHORTEST_S:
        return f"lasts {duration:.2g} s (limit: {_SHORTEST_S:g} s)"
    signals = (run.x_m, run.f_drive_n, run.f_applied_n)
    gaps = any(y is not None and not np.isfinite(y).all() for y in signals)
    return "position or force has gaps" if gaps else ""


def _held_out_errors(
    measured: MeasuredMotion, result: SearchResult, held_out: np.ndarray
) -> tuple[tuple[HeldOutError, ...], Overlay]:
    """Return both errors, and the positions of the run with the largest error of the final model.

    An error is nan where a simulated motion diverges.
    """
    models = (result.given, result.refitted, result.final)
    forces = [measured.unit_n * _force_error(model.gap_map, held_out) for model in models]
    runs = [run for log in measured.logs for run in log.runs]
    simulated = [_positions(measured, model.hypothesis) for model in models]
    squares = np.array([[_mean_square(x[i] - runs[i].x_m) for i in held_out] for x in simulated])
    samples = [len(runs[i].t_s) for i in held_out]
    positions = 1e3 * np.sqrt(np.average(squares, axis=1, weights=samples))
    worst = int(held_out[np.argmax(np.nan_to_num(squares[-1], nan=np.inf))])
    run, (_, refitted, final) = runs[worst], (x[worst] for x in simulated)
    t_s = run.t_s - run.t_s[0]
    shown = Overlay(run.plan.run, "x", "m", t_s, run.x_m, refitted, final)
    return (
        HeldOutError("force", "N", *forces),
        HeldOutError("position", "mm", *positions.tolist()),
    ), shown


def _force_error(residuals: GapMap, points: np.ndarray) -> float:
    chosen = residuals.difference[np.isin(residuals.point, points), BALANCES.index(BALANCE)]
    return float(np.sqrt(np.nanmean(chosen**2)))


def _positions(measured: MeasuredMotion, hypothesis: Hypothesis) -> list[np.ndarray]:
    """Return the simulated positions of each run."""
    model = measured.balance_model(hypothesis)
    return [
        own
        for log in measured.logs
        for own in np.split(open_loop_positions(log, model), log.edges[1:-1])
    ]


def _mean_square(values: np.ndarray) -> float:
    return float(np.mean(values**2))
