"""Diagnosis of a campaign with a model: refit, search, verdict, and the figures behind them."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.errors import DataError
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.diagnosis_fields import (
    added_effect,
    fitted_shape,
    gap_of_balances,
    insufficient_data_diagnosis,
    residual_map,
)
from hbench.reconcile.estimates import ParameterEstimates, fit_coefficients
from hbench.reconcile.gaps.columns import ModelColumn, residuals_of_runs
from hbench.reconcile.gaps.gap_map import gaps, point_of
from hbench.reconcile.gaps.overlays import overlays
from hbench.reconcile.gaps.regions import regions
from hbench.reconcile.gaps.tables import GapComparison
from hbench.reconcile.hypothesis import CoefficientKey, Hypothesis, Simulate
from hbench.reconcile.linearised import LinearisedModel, linearise
from hbench.reconcile.measured.balances import (
    channels_missing,
    incomplete_reason,
    prepare,
    residuals,
)
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.revised_model import revised
from hbench.reconcile.search import CampaignSearch, SearchResult
from hbench.reconcile.signatures import signatures
from hbench.reconcile.verdict import (
    data_shortfalls,
    decide_verdict,
    missing_experiments,
    unexplained_gaps,
    unmeasured_channels,
)
from hbench.records import AddedEffect, Diagnosis, Gap, Provenance, Run

HELD_OUT = 5  # every fifth operating point is held out from refit and search
_FIRST_HELD_OUT = 2
_DRAWS = 3  # of the parameters' uncertainty, for the floor
_LIBRARY_ADVICE = "The schedule configs/discriminate.yaml contains all runs that are needed."
_MOST_TRIALS = 3  # of a simulation


ProposeExperiment = Callable[
    [Mapping[str, Hypothesis], Mapping[str, float]], tuple[str, dict[str, Any]] | None
]
"""Returns the experiment that distinguishes hypotheses, in words and as a schedule."""


@dataclass(frozen=True)
class ReconcileTask:
    """Task of a diagnosis: runs of a campaign and a model of its bench."""

    provenance: Provenance
    bench: Bench
    model: str  # file name
    plant: Plant  # of the model
    plant_data: Mapping[str, Any]  # sections of the model's file
    runs: tuple[Run, ...]
    simulate: Simulate
    propose: ProposeExperiment = lambda rivals, scatter: None


@dataclass(frozen=True)
class BaselineSimulation:
    """Simulated runs of the given model, and the signatures of the effects about it.

    It does not depend on the measurement.
    """

    runs: tuple[Run, ...]
    signatures: Mapping[CoefficientKey, ModelColumn]


def simulate_baseline(task: ReconcileTask, names: Sequence[str]) -> BaselineSimulation:
    """Simulate the given model, without effects and with each of the effects ``names``.

    Raises ``DataError`` where the board stops with the given model.
    """
    (runs,) = task.simulate([Hypothesis()], _trials(task.runs))
    if runs is None:
        raise DataError(
            f"{task.model}: the simulated board stops before the end of the campaign",
            f"Check the model with `hbench run --port sim --plant {task.model}`.",
        )
    model = MeasuredCampaign(task.bench, task.plant, ()).balance_model(Hypothesis())
    return BaselineSimulation(runs, signatures(names, task.simulate, model, runs))


def run_search(
    task: ReconcileTask, baseline: BaselineSimulation, names: Sequence[str]
) -> tuple[LinearisedModel, SearchResult, np.ndarray]:
    """Return the given model, the result of the search, and the indices of held-out points.

    Raises ``DataError`` where no operating point has two trials.
    """
    logs = tuple(prepare(run) for run in task.runs)
    measured = MeasuredCampaign(task.bench, task.plant, logs)
    given = linearise(measured, Hypothesis(), baseline.runs, baseline.signatures)
    points = np.arange(len(given.gap_map.points))
    held_out = points % HELD_OUT == _FIRST_HELD_OUT
    search = CampaignSearch(
        measured,
        task.simulate,
        _trials(task.runs),
        baseline.signatures,
        points[~held_out],
        tuple(names),
    )
    return given, search.run(given), points[held_out]


def diagnose(task: ReconcileTask) -> Diagnosis:
    """Determine where model and measurement disagree and why; see ``Diagnosis``.

    Insufficient data give a diagnosis that lists what is missing.
    """
    usable, left_out = _usable_runs(task.runs)
    missing = unmeasured_channels(usable) | missing_experiments([run.plan for run in usable])
    if shortfalls := data_shortfalls(usable):
        every = tuple((shortfalls | missing).values())
        return insufficient_data_diagnosis(task, every, left_out, _LIBRARY_ADVICE)
    trials = Counter(point_of(run.plan) for run in usable)
    repeated = {point for point, count in trials.items() if count > 1}
    task = replace(task, runs=tuple(run for run in usable if point_of(run.plan) in repeated))
    names, not_tried = _observable_effects(task.runs, task.plant)
    baseline = simulate_baseline(task, names)
    simulated = {name for name, _ in baseline.signatures}
    stopped = "the simulated board stops, even with a quarter of the effect's typical size"
    not_tried |= {name: stopped for name in names if name not in simulated}
    given, result, held_out = run_search(task, baseline, names)
    return _assembled(task, given, result, held_out, not_tried, tuple(missing.values()), left_out)


def _assembled(
    task: ReconcileTask,
    given: LinearisedModel,
    result: SearchResult,
    held_out: np.ndarray,
    not_tried: Mapping[str, str],
    missing: tuple[str, ...],
    left_out: tuple[str, ...],
) -> Diagnosis:
    measured = MeasuredCampaign(task.bench, task.plant, tuple(prepare(run) for run in task.runs))
    refitted, final = result.refitted, result.final
    points = final.gap_map.points
    held_out_points = frozenset(points[i] for i in held_out)
    train = np.setdiff1d(np.arange(len(points)), held_out)
    estimates = fit_coefficients(task.plant, final, result.names, train)
    drawn = task.simulate(estimates.draws(_DRAWS), _trials(task.runs))
    comparison = GapComparison(
        measured.logs,
        tuple(
            (model.runs, measured.balance_model(model.hypothesis))
            for model in (given, refitted, final)
        ),
        [runs for runs in drawn if runs is not None],
    )
    where = ranked_gaps(measured, refitted)
    unexplained = unexplained_gaps(ranked_gaps(measured, final))
    last = result.steps[-1]
    rivals = {
        each.candidate.name: each.model.hypothesis
        for each in last.evaluated
        if each.candidate in last.ambiguous and each.model
    }
    scatter = {gap.name: gap.scatter for gap in where}
    proposal = task.propose(rivals, scatter) if rivals else None
    verdict, why = decide_verdict(result, unexplained)
    return Diagnosis(
        provenance=task.provenance,
        model=task.model,
        verdict=verdict,
        why=why,
        where=where,
        regions=regions(refitted.gap_map),
        effects=_added_effects(result, estimates, held_out),
        alternatives=last.ambiguous,
        rest=unexplained,
        next_experiment=proposal[0] if proposal else None,
        next_schedule=proposal[1] if proposal else None,
        gap_heldout=comparison.table(held_out_points),
        gap_train=comparison.table(frozenset(points) - held_out_points),
        gap_runs=comparison.runs(held_out_points),
        ranking=tuple(each.candidate for each in result.steps[0].evaluated),
        threshold=result.steps[0].evaluated[0].candidate.threshold,
        refitted=estimates.factors(),
        residuals_before=residual_map(refitted, held_out_points),
        residuals_after=residual_map(final, held_out_points),
        overlays=overlays(
            task.runs,
            refitted.runs,
            final.runs,
            measured.balance_model(Hypothesis()),
            held_out_points,
        ),
        heldout_runs=tuple(
            run.plan.run for run in task.runs if point_of(run.plan) in held_out_points
        ),
        not_tried=dict(not_tried),
        missing=missing,
        left_out=left_out,
        revised=revised(task.plant_data, estimates.factors(), estimates.hypothesis(estimates.beta)),
    )


def _trials(runs: Sequence[Run]) -> int:
    return min(_MOST_TRIALS, max(Counter(point_of(run.plan) for run in runs).values()))


def _usable_runs(runs: Sequence[Run]) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """Return the complete runs, and the reasons for which others are left out."""
    usable, left_out = [], []
    for run in runs:
        reason = run.aborted or incomplete_reason(run)
        if not reason and run.plan.motion is None:
            reason = "its planned motion is unknown, so it can't be simulated"
        if reason:
            left_out.append(f"run {run.plan.run}: {reason}")
        else:
            usable.append(run)
    return tuple(usable), tuple(left_out)


def _observable_effects(
    runs: Sequence[Run], plant: Plant
) -> tuple[tuple[str, ...], dict[str, str]]:
    """Return the effects that these channels can show, and why the others are not tried."""
    observable, not_tried = [], {}
    for name, row in EFFECTS.items():
        without = [
            balance
            for balance in row.balances
            if all(channels_missing(run, balance) for run in runs)
        ]
        if name in plant.effects:
            not_tried[name] = "the model already contains it; its coefficients are not changed"
        elif len(without) == len(row.balances):
            not_tried[name] = f"no run has the channels of {', '.join(without)}"
        else:
            observable.append(name)
    return tuple(observable), not_tried


def ranked_gaps(measured: MeasuredCampaign, model: LinearisedModel) -> tuple[Gap, ...]:
    """Return the gaps of a model's balances, largest first."""
    balances = measured.balance_model(model.hypothesis)
    logs = [residuals(log, balances) for log in measured.logs]
    return gaps(logs, residuals_of_runs(model.runs, balances))[0]


def _added_effects(
    result: SearchResult, estimates: ParameterEstimates, held_out: np.ndarray
) -> tuple[AddedEffect, ...]:
    effects = []
    for step in result.steps:
        if step.added is not None:
            balances = EFFECTS[step.added].balances
            effect = added_effect(
                step.added,
                [each.candidate for each in step.evaluated],
                estimates,
                gap_of_balances(step.before.gap_map, balances, held_out),
                gap_of_balances(result.final.gap_map, balances, held_out),
            )
            shape = fitted_shape(step.added, result.final.hypothesis)
            effects.append(replace(effect, shape=shape))
    return tuple(effects)
