"""Diagnosis of a campaign with a model: refit, search, verdict, and the figures behind them."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.config.sensors import Instruments
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.diagnosis_fields import (
    added_effect,
    fitted_shape,
    insufficient_data_diagnosis,
    residual_map,
    with_place,
)
from hbench.reconcile.estimates import ParameterEstimates, fit_coefficients
from hbench.reconcile.gaps.gap_map import GapMap, column_means, point_of
from hbench.reconcile.gaps.log_map import ranked_gaps, unexplained_gaps
from hbench.reconcile.gaps.overlays import overlays
from hbench.reconcile.gaps.regions import regions
from hbench.reconcile.gaps.tables import BalanceStages, SimulatedStages, gap_table, gaps_of_runs
from hbench.reconcile.hypothesis import Hypothesis, typical_size
from hbench.reconcile.learned.law_search import LawSearch
from hbench.reconcile.learned.unnamed_laws import unnamed_laws
from hbench.reconcile.linearised import LinearisedModel
from hbench.reconcile.measured.balances import OF_LOAD_CYLINDER, balance_model
from hbench.reconcile.measured.comparable_runs import comparable_runs, log_remarks
from hbench.reconcile.measured.contradictions import refuse_contradictions
from hbench.reconcile.measured.session import sessions
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.nuisance import FACTORS, standard_deviation, zero_tolerances
from hbench.reconcile.practice.changes import in_practice
from hbench.reconcile.revised_model import held_out_gaps, revision, without_unconfirmed
from hbench.reconcile.search.campaign_search import CampaignSearch
from hbench.reconcile.search_result import SearchResult
from hbench.reconcile.separation.next_experiment import ExperimentLibrary, Proposal, Undecided
from hbench.reconcile.separation.observable import divided_points, observable_effects
from hbench.reconcile.separation.separability import Separation, with_remaining_noise
from hbench.reconcile.verdict import (
    data_shortfalls,
    decide_verdict,
    missing_experiments,
    unmeasured_channels,
)
from hbench.records import (
    AddedEffect,
    Diagnosis,
    Gap,
    Overlay,
    Provenance,
    Run,
    RunPlan,
    UnnamedLaw,
)
from hbench.records.diagnosis import MATERIAL

_LIBRARY_ADVICE = "The schedule configs/discriminate.yaml contains all runs that are needed."
NOT_SIMULATED = "The motion of imported runs can't be simulated: no gaps of signals, no overlays."
_ASSUMED = (
    "No instruments are stated. Tolerances of 1 % of the largest reading are assumed: errors of "
    "sensors below that are not named."
)
_NO_TRIALS = "No operating point has a second trial: no gaps of signals, no overlays."
_STOPPED = "No gaps of signals: the simulation with the {} model ended early ({})."

Simulate = Callable[[Sequence[Hypothesis], Sequence[RunPlan]], Sequence[tuple[Run, ...] | str]]
"""Simulates one run of each operating point of some plans; text: why the simulation ended early."""


@dataclass(frozen=True)
class ReconcileTask:
    """Task of a diagnosis: runs of a campaign and a model of its bench."""

    provenance: Provenance
    bench: Bench | None  # None: its board is unknown
    model: str  # file name
    plant: Plant  # of the model
    plant_data: Mapping[str, Any]  # sections of the model's file
    runs: tuple[Run, ...]
    instruments: Instruments | None
    material: float = MATERIAL
    simulate: Simulate | None = None  # None: the runs can't be simulated
    experiments: ExperimentLibrary | None = None  # None: no experiment is proposed
    stage: Callable[[str], None] = lambda stage: None  # receives a description of each stage


def run_search(
    task: ReconcileTask, names: Sequence[str]
) -> tuple[MeasuredCampaign, SearchResult, np.ndarray]:
    """Return the measured campaign, the result of the search, and indices of held-out points.

    Raises ``DataError`` for logs that contradict the model's areas or the valves' signs.
    """
    measured = MeasuredCampaign(
        task.bench, task.plant, task.instruments, sessions(task.runs), task.material
    )
    refuse_contradictions(measured.logs, measured.balance_model(measured.start))
    train, held_out = divided_points(len({point_of(run.plan) for run in task.runs}))
    search = CampaignSearch(measured, train, tuple(names), task.stage)
    result = without_unconfirmed(search, search.run(), held_out)
    if not result.steps[-1].ambiguous:
        result = with_laws(search, result, held_out)
    return measured, result, held_out


def with_laws(search: CampaignSearch, result: SearchResult, held_out: np.ndarray) -> SearchResult:
    """Return the result with learned laws, if any are kept.

    An offset or gain of a sensor can take the part of a law that the model does not contain. One
    that is within its tolerance beside the laws is no effect: they are learned again without it.
    """
    names = result.confirmed
    final, laws = LawSearch(search.measured, search, names, held_out).run(result.final)
    if not laws:
        return result
    if gone := search.within_tolerance(final, names):
        others = tuple(name for name in names if name not in gone)
        without = search.without(result.final, gone, others) if others else result.refitted
        vanished = (*result.vanished, *gone)
        return with_laws(search, replace(result, final=without, vanished=vanished), held_out)
    return replace(result, final=final, laws=laws, unlearned=result.final)


def diagnose(task: ReconcileTask) -> Diagnosis:
    """Determine where model and measurement disagree and why; see ``Diagnosis``.

    Insufficient data give a diagnosis that lists what is missing.
    """
    usable, left_out = comparable_runs(task.runs)
    absent = () if "load_cylinder" in task.plant_data else OF_LOAD_CYLINDER
    missing = unmeasured_channels(usable, absent) | missing_experiments(usable)
    if shortfalls := data_shortfalls(usable):
        every = tuple((shortfalls | missing).values())
        return insufficient_data_diagnosis(task, every, left_out, _LIBRARY_ADVICE)
    task = replace(task, runs=usable)
    names, not_tried = observable_effects(task.runs, task.plant)
    measured, result, held_out = run_search(task, names)
    return assembled(task, measured, result, held_out, not_tried, tuple(missing.values()), left_out)


def assembled(
    task: ReconcileTask,
    measured: MeasuredCampaign,
    result: SearchResult,
    held_out: np.ndarray,
    not_tried: Mapping[str, str],
    missing: tuple[str, ...],
    left_out: tuple[str, ...],
    rank: Callable[[GapMap, np.ndarray], tuple[Gap, ...]] = ranked_gaps,
) -> Diagnosis:
    """Return the diagnosis that the result of a search gives; ``rank`` returns the gaps."""
    refitted, final = result.refitted, result.final
    points = final.gap_map.points
    held_out_points = frozenset(points[i] for i in held_out)
    train = np.setdiff1d(np.arange(len(points)), held_out)
    estimates = fit_coefficients(task.plant, final, result.confirmed, train)
    balances = BalanceStages(
        (
            result.given.gap_map.in_units_of(refitted.gap_map),
            refitted.gap_map,
            final.gap_map.in_units_of(refitted.gap_map),
        ),
        expected_variance(final, estimates),
    )
    runs = tuple(run for log in measured.logs for run in log.runs)
    ends = [float(end) for run in runs for end in (run.x_m.min(), run.x_m.max())]
    cylinder = measured.balance_model(final.hypothesis).par.test
    simulated, overlaid, notes = _verification(task, result, held_out_points)
    where = rank(refitted.gap_map, _allowed(measured, refitted))
    by_effects = result.without_laws.gap_map.in_units_of(refitted.gap_map)
    unexplained = unexplained_gaps(rank(by_effects, _allowed(measured, refitted)))
    last = result.steps[-1]
    rivals = {
        each.candidate.name: each.model
        for each in last.evaluated
        if each.candidate in last.ambiguous and each.model
    }
    proposal = Proposal(None, None, ())
    if rivals and task.experiments:
        task.stage("searching for the experiment that separates the effects best")
        proposal = task.experiments.propose(_undecided(result, rivals, train))
    verdict, why = decide_verdict(result, unexplained)
    best = next(iter(rivals.values()), final)
    expected = Separation(with_remaining_noise(refitted, best, train), train)
    tried = tuple(name for name in EFFECTS if name not in not_tried)
    if verdict == "none" and task.experiments:
        task.stage("searching for the experiments that show more effects")
        proposal = task.experiments.reveal(expected, tried)
    fits = {
        name: fit_coefficients(task.plant, each.model, each.effects, train)
        for name, each in result.unconfirmed.items()
    }
    fits |= dict.fromkeys(result.confirmed, estimates) | {
        each.candidate.name: fit_coefficients(
            task.plant, each.model, (*result.names, each.candidate.name), train
        )
        for each in last.evaluated
        if each.candidate in last.ambiguous and each.model
    }
    point, practice = in_practice(measured, final.gap_map, fits)
    factors, sections = revision(task.plant_data, result, estimates)
    return Diagnosis(
        provenance=task.provenance,
        model=task.model,
        verdict=verdict,
        why=why,
        where=where,
        regions=regions(refitted.gap_map),
        regions_after=regions(balances.maps[-1]),
        effects=tuple(
            with_place(effect, cylinder, (min(ends), max(ends)))
            for effect in _added_effects(result, fits, held_out)
        ),
        alternatives=last.ambiguous,
        rest=unexplained,
        next_experiment=proposal.words,
        next_schedule=proposal.schedule,
        gap_heldout=gap_table(balances, simulated, held_out_points),
        gap_train=gap_table(balances, simulated, frozenset(points) - held_out_points),
        gap_runs=gaps_of_runs([run.plan for run in runs], balances, simulated, held_out_points),
        ranking=tuple(each.candidate for each in result.steps[0].evaluated),
        threshold=result.steps[0].evaluated[0].candidate.threshold,
        refitted=factors,
        refit_priors={path: FACTORS[path] for path in factors},
        residuals_before=residual_map(refitted.gap_map, held_out_points),
        residuals_after=residual_map(balances.maps[-1], held_out_points),
        overlays=overlaid,
        heldout_runs=tuple(run.plan.run for run in runs if point_of(run.plan) in held_out_points),
        not_tried=dict(not_tried),
        missing=missing,
        left_out=left_out,
        revised=sections,
        notes=(
            *log_remarks(measured.logs),
            *notes,
            *proposal.notes,
            *([] if task.instruments else [_ASSUMED]),
        ),
        unnamed=_unnamed_laws(result, estimates, held_out),
        separability=expected.separability(tried),
        working_point=point,
        practice=practice,
        refit_refused=result.refused,
        within_tolerance=tuple(
            name for name in measured.start.effects if name in sections.get("effects", {})
        ),
        zero_tolerances=zero_tolerances(measured.tolerances),
        material=measured.material,
    )


def _unnamed_laws(
    result: SearchResult, estimates: ParameterEstimates, held_out: np.ndarray
) -> tuple[UnnamedLaw, ...]:
    """Return the learned laws; their gaps are in the scatter of the refitted model."""
    if result.unlearned is None:
        return ()
    scale = result.refitted.gap_map
    before, after = (each.gap_map.in_units_of(scale) for each in (result.unlearned, result.final))
    return unnamed_laws(result.laws, estimates, before, after, held_out)


def _undecided(
    result: SearchResult, rivals: Mapping[str, LinearisedModel], train: np.ndarray
) -> Undecided:
    """Return the ambiguous set; the best of the ``rivals`` shows what no effect explains."""
    best = next(iter(rivals.values()))
    model = with_remaining_noise(result.steps[-1].before, best, train)
    fitted = {name: model.hypothesis for name, model in rivals.items()}
    return Undecided(model, train, result.names, fitted)


def expected_variance(final: LinearisedModel, estimates: ParameterEstimates) -> np.ndarray:
    """Return the variance (w, c) of the residuals by the parameters' uncertainty, in scatters.

    That by the residuals alone: where they are far below what is material, so is this.
    """
    names = [final.data.names[i] for i in estimates.chosen]
    columns = np.stack([np.nan_to_num(final.columns[name]) for name in names], axis=-1)
    variance = np.einsum("wcj,jk,wck->wc", columns, estimates.sandwich, columns, optimize=True)
    return variance / final.gap_map.scatter**2


def _allowed(measured: MeasuredCampaign, model: LinearisedModel) -> np.ndarray:
    """Return the root mean square (c,) of what sensors within their tolerances may cause."""
    squares = np.zeros(len(model.gap_map.names))
    for which, limit in measured.tolerances.items():
        if EFFECTS[which[0]].of_sensor:
            change = model.columns[".".join(which)] / typical_size(which)
            squares += standard_deviation(limit) ** 2 * np.nan_to_num(column_means(change**2))
    return np.sqrt(squares)


def _verification(
    task: ReconcileTask, result: SearchResult, held_out: frozenset
) -> tuple[SimulatedStages | None, tuple[Overlay, ...], tuple[str, ...]]:
    """Compare the signals of the runs with those of the models given, refitted and final.

    The runs of the same schedule are simulated in closed loop with the firmware.
    """
    trials = Counter(point_of(run.plan) for run in task.runs)
    runs = [run for run in task.runs if run.plan.motion and trials[point_of(run.plan)] > 1]
    if task.simulate is None:
        return None, (), (NOT_SIMULATED,)
    if not runs:
        return None, (), (_NO_TRIALS,)
    task.stage("simulating the schedule with the given, the refitted and the final model")
    hypotheses = [model.hypothesis for model in (result.given, result.refitted, result.final)]
    different = [each for i, each in enumerate(hypotheses) if each not in hypotheses[:i]]
    made_with = task.simulate(different, [run.plan for run in runs])
    results = [made_with[different.index(each)] for each in hypotheses]
    simulated, ended = [], []
    for model, made in zip(("given", "refitted", "final"), results, strict=True):
        if isinstance(made, str):
            ended.append(_STOPPED.format(model, made))
        else:
            simulated.append(made)
    if ended:
        return None, (), tuple(ended)
    models = [balance_model(task.bench, each.plant(task.plant)) for each in hypotheses]
    stages = SimulatedStages(runs, list(zip(simulated, models, strict=True)), held_out)
    shown = overlays(runs, simulated[1], simulated[2], models[1], held_out)
    return stages, shown, ()


def _added_effects(
    result: SearchResult, fits: Mapping[str, ParameterEstimates], held_out: np.ndarray
) -> tuple[AddedEffect, ...]:
    """Return the effects; their gaps are those without learned laws."""
    effects = []
    for name, step in zip(result.names, result.additions, strict=True):
        unconfirmed = result.unconfirmed.get(name)
        model = unconfirmed.model if unconfirmed else result.without_laws
        effect = added_effect(
            name,
            [each.candidate for each in step.evaluated],
            fits[name],
            *held_out_gaps(result, model, name, held_out),
        )
        effects.append(replace(effect, shape=fitted_shape(name, model.hypothesis)))
    return tuple(effects)
