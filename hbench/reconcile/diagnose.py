"""From measured runs and a model to a diagnosis: refit, search, verdict, and what shows it."""

from collections import Counter
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.errors import DataError
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.estimates import Estimates, estimate
from hbench.reconcile.gap import GapMap, gaps, point_of
from hbench.reconcile.gap_regions import regions
from hbench.reconcile.gap_tables import Stages
from hbench.reconcile.linearised import (
    Coefficient,
    Column,
    Hypothesis,
    Linear,
    Measured,
    Simulate,
    linearise,
    shapes,
    windows_of,
)
from hbench.reconcile.measured.balances import (
    BALANCES,
    incomplete,
    lacking_channels,
    prepared,
    residuals,
)
from hbench.reconcile.overlays import overlays
from hbench.reconcile.revised_model import revised
from hbench.reconcile.search import TIE, Found, Search
from hbench.reconcile.signatures import signatures
from hbench.reconcile.verdict import judge, missing_channels, rest, too_few, what_is_missing
from hbench.records import (
    AddedEffect,
    BeforeAfter,
    Candidate,
    Diagnosis,
    Gap,
    GapTable,
    Provenance,
    ResidualMap,
    Rival,
    Run,
)

HELD_OUT = 5  # every fifth operating point takes no part in any choice
_FIRST_HELD_OUT = 2
_DRAWS = 3  # of the parameters' uncertainty, for the floor
_LIBRARY = "configs/discriminate.yaml is a schedule with all runs that are needed."
_MOST_TRIALS = 3  # that a simulation makes


Propose = Callable[
    [Mapping[str, Hypothesis], Mapping[str, float]], tuple[str, dict[str, Any]] | None
]
"""Returns the experiment that tells hypotheses apart, in words and as a schedule; see ``Task``."""


@dataclass(frozen=True)
class Task:
    """What is to be reconciled."""

    provenance: Provenance
    bench: Bench
    model: str  # file name
    plant: Plant  # of the model
    plant_data: Mapping[str, Any]  # its sections, as its file has them
    runs: tuple[Run, ...]
    simulate: Simulate
    propose: Propose = lambda rivals, scatter: None


@dataclass(frozen=True)
class Prior:
    """What does not depend on the measurement: simulations of the model that was given."""

    runs: tuple[Run, ...]
    signatures: Mapping[Coefficient, Column]


def before_measuring(task: Task, names: Sequence[str]) -> Prior:
    """Simulate the model that was given, and with each of the effects ``names``.

    Raises ``DataError`` where the board stops with the model as it is.
    """
    (runs,) = task.simulate([Hypothesis()], _trials(task.runs))
    if runs is None:
        raise DataError(
            f"{task.model}: the simulated board stops before the campaign's runs are made",
            "Try the model by `hbench run --port sim --plant`.",
        )
    measured = Measured(task.bench, task.plant, ())
    return Prior(runs, signatures(names, task.simulate, measured.known(Hypothesis()), runs))


def search(task: Task, prior: Prior, names: Sequence[str]) -> tuple[Linear, Found, np.ndarray]:
    """Return the model that was given, what the search found, and the points held out.

    Raises ``DataError`` where no operating point has two trials.
    """
    logs = tuple(prepared(run) for run in task.runs)
    measured = Measured(task.bench, task.plant, logs)
    given = linearise(measured, Hypothesis(), prior.runs, prior.signatures)
    points = np.arange(len(given.lacking.points))
    out = points % HELD_OUT == _FIRST_HELD_OUT
    looked = Search(
        measured, task.simulate, _trials(task.runs), prior.signatures, points[~out], tuple(names)
    )
    return given, looked.run(given), points[out]


def diagnose(task: Task) -> Diagnosis:
    """Find where model and measurement disagree and why; see ``Diagnosis``.

    Data that is too little for a search gets a diagnosis that says what it lacks.
    """
    usable, left_out = _usable(task.runs)
    missing = (*missing_channels(usable), *what_is_missing([run.plan for run in usable]))
    if few := too_few(usable):
        nothing = too_little(task, tuple(dict.fromkeys((*few, *missing))), left_out)
        return replace(nothing, next_experiment=f"{nothing.next_experiment} {_LIBRARY}")
    trials = Counter(point_of(run.plan) for run in usable)
    repeated = {point for point, count in trials.items() if count > 1}
    task = replace(task, runs=tuple(run for run in usable if point_of(run.plan) in repeated))
    names, not_tried = _told(task.runs, task.plant)
    prior = before_measuring(task, names)
    seen = {name for name, _ in prior.signatures}
    stopped = "the simulated board stops with it, even with a quarter of its typical size"
    not_tried |= {name: stopped for name in names if name not in seen}
    given, found, out = search(task, prior, names)
    return _assembled(task, given, found, out, not_tried, missing, left_out)


def _assembled(
    task: Task,
    given: Linear,
    found: Found,
    out: np.ndarray,
    not_tried: Mapping[str, str],
    missing: tuple[str, ...],
    left_out: tuple[str, ...],
) -> Diagnosis:
    measured = Measured(task.bench, task.plant, tuple(prepared(run) for run in task.runs))
    refitted, final = found.refitted, found.final
    points = final.lacking.points
    held = frozenset(points[i] for i in out)
    train = np.setdiff1d(np.arange(len(points)), out)
    best = estimate(task.plant, final, found.names, train)
    drawn = task.simulate(best.draws(_DRAWS), _trials(task.runs))
    stages = Stages(
        measured.logs,
        tuple((one.runs, measured.known(one.hypothesis)) for one in (given, refitted, final)),
        [runs for runs in drawn if runs is not None],
    )
    where = ranked(measured, refitted)
    left = rest(ranked(measured, final))
    rivals = {
        one.found.name: one.linear.hypothesis
        for one in found.steps[-1].tried
        if one.found in found.steps[-1].close and one.linear
    }
    scatter = {one.name: one.scatter for one in where}
    words, schedule = (task.propose(rivals, scatter) if rivals else None) or (None, None)
    verdict, why = judge(found, left)
    return Diagnosis(
        provenance=task.provenance,
        model=task.model,
        verdict=verdict,
        why=why,
        where=where,
        regions=regions(refitted.lacking),
        effects=_added(found, best, out),
        alternatives=found.steps[-1].close,
        rest=left,
        next_experiment=words,
        next_schedule=schedule,
        gap_heldout=stages.table(held),
        gap_train=stages.table(frozenset(points) - held),
        gap_runs=stages.runs(held),
        ranking=tuple(one.found for one in found.steps[0].tried),
        threshold=found.steps[0].tried[0].found.threshold,
        refitted=best.factors(),
        residuals_before=residual_map(refitted, held),
        residuals_after=residual_map(final, held),
        overlays=overlays(task.runs, refitted.runs, final.runs, measured.known(Hypothesis()), held),
        heldout_runs=tuple(run.plan.run for run in task.runs if point_of(run.plan) in held),
        not_tried=dict(not_tried),
        missing=missing,
        left_out=left_out,
        revised=revised(task.plant_data, best.factors(), best.hypothesis(best.beta)),
    )


def _trials(runs: Sequence[Run]) -> int:
    return min(_MOST_TRIALS, max(Counter(point_of(run.plan) for run in runs).values()))


def _usable(runs: Sequence[Run]) -> tuple[tuple[Run, ...], tuple[str, ...]]:
    """Return whole runs, and why the others take no part."""
    usable, left_out = [], []
    for run in runs:
        why = run.aborted or incomplete(run)
        if not why and run.plan.motion is None:
            why = "its motion is not known, so no simulation can make it"
        if why:
            left_out.append(f"run {run.plan.run}: {why}")
        else:
            usable.append(run)
    return tuple(usable), tuple(left_out)


def _told(runs: Sequence[Run], plant: Plant) -> tuple[tuple[str, ...], dict[str, str]]:
    """Return the effects that these channels can tell, and why not the others."""
    told, not_tried = [], {}
    for name, row in EFFECTS.items():
        without = [one for one in row.balances if all(lacking_channels(run, one) for run in runs)]
        if name in plant.effects:
            not_tried[name] = "the model has it already; its coefficients stay as they are"
        elif len(without) == len(row.balances):
            not_tried[name] = f"no run has the channels of {', '.join(without)}"
        else:
            told.append(name)
    return tuple(told), not_tried


def ranked(measured: Measured, model: Linear) -> tuple[Gap, ...]:
    """Return the gaps of a model's balances, worst first."""
    known = measured.known(model.hypothesis)
    own = [residuals(log, known) for log in measured.logs]
    return gaps(own, windows_of(model.runs, known))[0]


def residual_map(model: Linear, held: frozenset[Hashable]) -> ResidualMap:
    """Return what a model's balances lack; ``held`` are the operating points held out."""
    found = model.lacking
    with np.errstate(divide="ignore", invalid="ignore"):
        value = found.difference / found.scatter
    out = np.array([point in held for point in found.points])
    return ResidualMap(
        found.names, value, found.v_m_s, found.load_n, found.x_m, found.t_s, out[found.point]
    )


def _added(found: Found, best: Estimates, out: np.ndarray) -> tuple[AddedEffect, ...]:
    effects = []
    for step in found.steps:
        if step.taken is not None:
            balances = EFFECTS[step.taken].balances
            gap = tuple(
                touched_gap(one.lacking, balances, out) for one in (step.before, found.final)
            )
            one = added_effect(step.taken, [each.found for each in step.tried], best, gap)
            effects.append(replace(one, shape=shape_words(step.taken, found.final.hypothesis)))
    return tuple(effects)


def added_effect(
    name: str, tried: Sequence[Candidate], best: Estimates, gap: tuple[float, ...]
) -> AddedEffect:
    """Return what was taken of some candidates; ``gap`` before and after.

    Its rival is the best whose score is not above its own: one above it explained too little.
    """
    taken = next(one for one in tried if one.name == name)
    below = [one for one in tried if one.name != name and one.score <= taken.score + TIE]
    rival = max(below, key=lambda one: one.score, default=None)
    row = EFFECTS[name]
    return AddedEffect(
        name=name,
        says=row.description,
        parameters=best.coefficients(name),
        of_sensor=row.of_sensor,
        gap_before=gap[0],
        gap_after=gap[1],
        score=taken.score,
        runner_up=Rival(rival.name, taken.score - rival.score) if rival else None,
    )


def shape_words(name: str, hypothesis: Hypothesis) -> str:
    """Return what another shape of its law an effect was given; empty for the textbook one."""
    given = hypothesis.effects.get(name, {})
    return ", ".join(key for _, key in shapes(name) if key in given)


def touched_gap(found: GapMap, balances: Sequence[str], points: np.ndarray) -> float:
    """Return the gap over some balances and operating points."""
    own = found.excess[np.isin(found.point, points)][:, np.isin(found.names, balances)]
    return float(np.sqrt(max(1 + np.nanmean(own), 0.0)))


def too_little(task: Any, missing: tuple[str, ...], left_out: tuple[str, ...]) -> Diagnosis:
    """Return the diagnosis of data that no effect can be named from; ``task`` as for a search.

    ``missing`` begins with what it lacks most.
    """
    nothing = GapTable(BeforeAfter(*[float("nan")] * 4), {}, {}, {})
    none = np.zeros(0)
    no_map = ResidualMap(
        BALANCES, np.zeros((0, len(BALANCES))), none, none, none, none, none.astype(bool)
    )
    return Diagnosis(
        provenance=task.provenance,
        model=task.model,
        verdict="unknown",
        why=f"To name an effect would be a guess. These runs lack {missing[0]}.",
        where=(),
        regions=(),
        effects=(),
        alternatives=(),
        rest=(),
        next_experiment=f"Measure {missing[0]}.",
        next_schedule=None,
        gap_heldout=nothing,
        gap_train=nothing,
        gap_runs=(),
        ranking=(),
        threshold=float("nan"),
        refitted={},
        residuals_before=no_map,
        residuals_after=no_map,
        overlays=(),
        heldout_runs=(),
        not_tried=dict.fromkeys(EFFECTS, "too few runs"),
        missing=missing,
        left_out=left_out,
        revised=dict(task.plant_data),
    )
