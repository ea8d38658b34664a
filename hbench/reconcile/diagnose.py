"""Diagnosis of a campaign with a model: refit, search, verdict, and the figures behind them."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.config.sensors import Instruments
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.added_effects import added_effects, small_effects
from hbench.reconcile.diagnosis_fields import (
    ModelledData,
    insufficient_data_diagnosis,
)
from hbench.reconcile.estimates import ParameterEstimates, fit_coefficients
from hbench.reconcile.gaps.gap_map import point_of
from hbench.reconcile.gaps.model_gaps import gap_fields, refitted_and_unexplained
from hbench.reconcile.gaps.overlays import overlays
from hbench.reconcile.gaps.tables import SimulatedStages
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.learned.law_search import LawSearch
from hbench.reconcile.learned.unnamed_laws import unnamed_laws
from hbench.reconcile.linearised import LinearisedModel
from hbench.reconcile.measured.balances import OF_LOAD_CYLINDER, balance_model
from hbench.reconcile.measured.comparable_runs import comparable_runs, log_remarks
from hbench.reconcile.measured.contradictions import refuse_contradictions
from hbench.reconcile.measured.session import sessions
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.nuisance import nuisances, zero_tolerances
from hbench.reconcile.practice.changes import in_practice
from hbench.reconcile.revised_model import revision, without_unconfirmed
from hbench.reconcile.search.campaign_search import CampaignSearch
from hbench.reconcile.search_result import SearchResult
from hbench.reconcile.separation.missing_data import missing_data
from hbench.reconcile.separation.next_experiment import ExperimentLibrary, Proposal, Undecided
from hbench.reconcile.separation.observable import divided_points, observable_effects
from hbench.reconcile.separation.separability import Separation, with_remaining_noise
from hbench.reconcile.verdict import decide_verdict
from hbench.records import (
    Diagnosis,
    Overlay,
    Run,
    RunPlan,
    Separability,
    UnnamedLaw,
    Verdict,
)
from hbench.records.reconcile.diagnosis import MATERIAL

_ALIKE = 0.5  # share of the largest delay
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


@dataclass(frozen=True, kw_only=True)
class ReconcileTask(ModelledData):
    """Task of a diagnosis: runs of a campaign and a model of its bench."""

    bench: Bench | None  # None: its board is unknown
    plant: Plant  # of the model
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
    if measured.delayed and _position_is_late(
        fit_coefficients(task.plant, result.final, result.confirmed, train)
    ):
        task.stage("all sensors are early, so the position is late")
        search = replace(search, measured=replace(measured, late_position=True))
        measured, result = search.measured, without_unconfirmed(search, search.run(), held_out)
    if result.steps[-1].ambiguous:
        return measured, result, held_out
    if not result.names and (small := search.small_effects(result.final)):
        return measured, replace(result, small=small), held_out
    return measured, with_laws(search, result, held_out), held_out


def _position_is_late(estimates: ParameterEstimates) -> bool:
    """Return whether several sensors are early, each by at least half as much as another.

    A late position is as good, and one late channel is likelier.
    """
    early = [-delay.value for delay in estimates.delays().values()]
    return len(early) > 1 and min(early) > _ALIKE * max(early)


def with_laws(search: CampaignSearch, result: SearchResult, held_out: np.ndarray) -> SearchResult:
    """Return the result with learned laws, if any are kept.

    An offset or gain of a sensor can take the part of a law that the model does not contain. One
    that is within its tolerance beside the laws is no effect: they are learned again without it.
    """
    names = result.confirmed
    final, laws = LawSearch(search.measured, search, names, held_out).run(result.final)
    if not laws:
        return result
    if gone := search.no_longer_errors(final, names):
        others = tuple(name for name in names if name not in gone)
        without = search.without(result.final, list(gone), others) if others else result.refitted
        result = replace(result, final=without, ruled_out={**result.ruled_out, **gone})
        return with_laws(search, result, held_out)
    return replace(result, final=final, laws=laws, unlearned=result.final)


def diagnose(task: ReconcileTask) -> Diagnosis:
    """Determine where model and measurement disagree and why; see ``Diagnosis``.

    Insufficient data give a diagnosis that lists what is missing.
    """
    usable, left_out = comparable_runs(task.runs)
    absent = () if "load_cylinder" in task.plant_data else OF_LOAD_CYLINDER
    load = task.plant.load_cylinder
    areas = None if absent else (load.area_piston_m2, load.area_rod_m2)
    suffices, missing = missing_data(usable, task.runs, areas, absent)
    if not suffices:
        advice = _LIBRARY_ADVICE if task.bench else ""
        return insufficient_data_diagnosis(task, missing, left_out, advice)
    task = replace(task, runs=usable)
    names, not_tried = observable_effects(task.runs, task.plant)
    measured, result, held_out = run_search(task, names)
    return assembled(task, measured, result, held_out, not_tried, missing, left_out)


def assembled(
    task: ReconcileTask,
    measured: MeasuredCampaign,
    result: SearchResult,
    held_out: np.ndarray,
    not_tried: Mapping[str, str],
    missing: tuple[str, ...],
    left_out: tuple[str, ...],
) -> Diagnosis:
    """Return the diagnosis that the result of a search gives."""
    final = result.final
    held_out_points = frozenset(final.gap_map.points[i] for i in held_out)
    train = np.setdiff1d(np.arange(len(final.gap_map.points)), held_out)
    estimates = fit_coefficients(task.plant, final, result.confirmed, train)
    runs = tuple(run for log in measured.logs for run in log.runs)
    simulated, overlaid, notes = _verification(task, result, held_out_points)
    where, unexplained = refitted_and_unexplained(measured, result)
    verdict, why = decide_verdict(result, unexplained)
    rivals = _rivals(result)
    tried = tuple(name for name in EFFECTS if name not in not_tried)
    proposal, separability = _advice(task, result, rivals, verdict, tried, train)
    fits = _fits(task.plant, result, estimates, rivals, train)
    point, practice = in_practice(measured, final.gap_map, fits)
    factors, sections = revision(task.plant_data, result, estimates)
    priors = nuisances(task.plant)
    first, last = result.steps[0], result.steps[-1]
    return Diagnosis(
        provenance=task.provenance,
        model=task.model,
        verdict=verdict,
        why=why,
        where=where,
        effects=added_effects(measured, result, fits, held_out),
        small_effects=small_effects(measured, result, held_out),
        alternatives=last.ambiguous,
        rest=unexplained,
        next_experiment=proposal.words,
        next_schedule=proposal.schedule,
        ranking=tuple(each.candidate for each in first.evaluated),
        threshold=first.evaluated[0].candidate.threshold,
        refitted=factors,
        refit_priors={path: priors[path] for path in factors},
        delays=estimates.delays(),
        overlays=overlaid,
        heldout_runs=tuple(run.plan.run for run in runs if point_of(run.plan) in held_out_points),
        not_tried=dict(not_tried),
        ruled_out=dict(result.ruled_out),
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
        separability=separability,
        working_point=point,
        practice=practice,
        refit_refused=result.refused,
        within_tolerance=tuple(
            name for name in measured.start.effects if name in sections.get("effects", {})
        ),
        zero_tolerances=zero_tolerances(measured.tolerances),
        material=measured.material,
        **gap_fields(result, estimates, simulated, [run.plan for run in runs], held_out_points),
    )


def _rivals(result: SearchResult) -> dict[str, LinearisedModel]:
    """Return the models with each effect of the ambiguous set, best first."""
    last = result.steps[-1]
    return {
        each.candidate.name: each.model
        for each in last.evaluated
        if each.candidate in last.ambiguous and each.model
    }


def _advice(
    task: ReconcileTask,
    result: SearchResult,
    rivals: Mapping[str, LinearisedModel],
    verdict: Verdict,
    tried: Sequence[str],
    train: np.ndarray,
) -> tuple[Proposal, Separability]:
    """Return the next experiment, and how well the runs separate the effects ``tried``."""
    best = next(iter(rivals.values()), result.final)
    expected = Separation(with_remaining_noise(result.refitted, best, train), train)
    proposal = Proposal(None, None, ())
    if rivals and task.experiments:
        task.stage("searching for the experiment that separates the effects best")
        proposal = task.experiments.propose(_undecided(result, rivals, train))
    elif verdict == "none" and task.experiments:
        task.stage("searching for the experiments that show more effects")
        proposal = task.experiments.reveal(expected, tried)
    return proposal, expected.separability(tried)


def _fits(
    plant: Plant,
    result: SearchResult,
    estimates: ParameterEstimates,
    rivals: Mapping[str, LinearisedModel],
    train: np.ndarray,
) -> dict[str, ParameterEstimates]:
    """Return the fit with each effect that is named, not confirmed, or in the ambiguous set."""
    unconfirmed = {
        name: fit_coefficients(plant, each.model, each.effects, train)
        for name, each in result.unconfirmed.items()
    }
    ambiguous = {
        name: fit_coefficients(plant, model, (*result.names, name), train)
        for name, model in rivals.items()
    }
    return unconfirmed | dict.fromkeys(result.confirmed, estimates) | ambiguous


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
    stages = [different.index(each) for each in hypotheses]
    ended = [
        _STOPPED.format(model, made_with[i])
        for model, i in zip(("given", "refitted", "final"), stages, strict=True)
        if isinstance(made_with[i], str)
    ]
    if ended:
        return None, (), tuple(ended)
    simulated = [made for made in made_with if not isinstance(made, str)]
    models = [balance_model(task.bench, each.plant(task.plant)) for each in different]
    pairs = list(zip(simulated, models, strict=True))
    _, refitted, final = stages
    shown = overlays(runs, simulated[refitted], simulated[final], models[refitted], held_out)
    return SimulatedStages(runs, pairs, stages, held_out), shown, ()
