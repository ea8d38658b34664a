"""A diagnosis from steady strokes that another bench made: verdict, intervals, loads left out.

The gaps of held-out runs are those of each load in turn, with parameters from the others alone.
Which effects are in the model was chosen with all loads in sight: four are too few to choose by
three.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hbench.config.stroke_model import StrokePlant
from hbench.errors import ConfigError
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.diagnose import added_effect, residual_map, too_little, touched_gap
from hbench.reconcile.estimates import Estimates
from hbench.reconcile.gap import gaps
from hbench.reconcile.gap_regions import regions
from hbench.reconcile.linearised import Linear
from hbench.reconcile.revised_model import revised
from hbench.reconcile.strokes.heldout import (
    Stages,
    errors,
    floor,
    stages_at,
    table,
    with_floor,
    without_each,
)
from hbench.reconcile.strokes.search import (
    OF_THE_SEAL,
    SeriesSearch,
    StrokesFound,
    search_strokes,
    series_search,
)
from hbench.reconcile.strokes.series import Pair, Strokes, pairs_of
from hbench.reconcile.verdict import rest, what_is_missing
from hbench.records import (
    AddedEffect,
    Diagnosis,
    Gap,
    Provenance,
    ScreenedRun,
    Verdict,
)

_FEWEST = 4  # loads with two strokes each way
_SAME_AREA = 0.002
_WORDS = {"force_band": "what turns with the direction", "force_middle": "what does not"}
_GAIN = (
    "load_cell_gain stands for every wrong gain between pressure and force: that of the load cell, "
    "of the pressure transducer, or a piston whose area is not the model's. Steady strokes show "
    "the same with each."
)
_TELLS = {
    "load_cell_gain": "known weights on the load cell, and the piston's bore measured",
    "load_cell_offset": "the load cell's zero without load",
    "pressure_offset": "the pressure transducer's zero in open air",
    "direction_asymmetry": "the same strokes with the cylinder turned around, or other seals in it",
    "load_friction": "the same strokes with another seal in this cylinder",
    "seal_pressure_friction": "the same strokes with another seal in this cylinder",
}


@dataclass(frozen=True)
class StrokeTask:
    """What is to be reconciled: the series asked for stands first."""

    provenance: Provenance
    model: str  # file name
    plant: StrokePlant  # of the model
    plant_data: Mapping[str, Any]  # its sections, as its file has them
    series: Mapping[str, Sequence[ScreenedRun]]  # by label


def diagnose_strokes(task: StrokeTask) -> Diagnosis:
    """Find what the friction of steady strokes lacks; see ``Diagnosis``.

    Other series of the same cylinder are evidence too. Raises ``ConfigError`` where the model's
    cylinder is not the one that was measured.
    """
    (label, screened), *others = task.series.items()
    left_out = tuple(
        f"run {one.run.plan.run}: {'; '.join(one.reasons)}" for one in screened if not one.accepted
    )
    plans = [one.run.plan for one in screened if one.accepted]
    missing = what_is_missing(plans)
    pairs = _repeated(screened)
    loads = len({pair.plan for pair in pairs})
    if loads < _FEWEST:
        few = (
            f"loads or pressures with two strokes each way or more: {loads}, of {_FEWEST} at least"
        )
        return too_little(task, (few, *missing), left_out)
    _check_area(task, pairs)
    same = {label: pairs}
    for other, runs in others:
        more = _repeated(runs)
        if len({one.plan for one in more}) >= _FEWEST:
            if more[0].plan.specimen == pairs[0].plan.specimen:
                same[other] = more
    series = [series_search(Strokes(task.plant, own)) for own in same.values()]
    return _assembled(task, list(same), series, missing, left_out)


def _repeated(screened: Sequence[ScreenedRun]) -> tuple[Pair, ...]:
    pairs = pairs_of(screened)
    plans = [pair.plan for pair in pairs]
    return tuple(pair for pair in pairs if plans.count(pair.plan) > 1)


def _check_area(task: StrokeTask, pairs: Sequence[Pair]) -> None:
    told, own = pairs[0].plan.specimen.area_piston_m2, task.plant.test_cylinder.area_piston_m2
    if abs(own / told - 1) > _SAME_AREA:
        raise ConfigError(
            f"{task.model}: test_cylinder has a piston of {1e4 * own:.4g} cm^2; the campaign's "
            f"has {1e4 * told:.4g} cm^2",
            "Correct test_cylinder.piston_diameter there, or the import's map.",
        )


def _assembled(
    task: StrokeTask,
    labels: Sequence[str],
    series: Sequence[tuple[SeriesSearch, Linear]],
    missing: tuple[str, ...],
    left_out: tuple[str, ...],
) -> Diagnosis:
    search, given = series[0]
    found = search_strokes(series)
    names, measured = found.names, search.measured
    best = search.estimates(found.final, names)
    ruled_out = {name: why for step in found.steps for name, why in step.ruled_out.items()}
    nothing = "changes nothing in the mean of a steady stroke"
    not_tried = {name: nothing for name in EFFECTS if name not in search.candidates}
    alternatives = tuple(one for step in found.steps for one in step.close)
    unsettled = {step.balance for step in found.steps if step.close}
    left = tuple(one for one in rest(_ranked(measured, found.final)) if one.name not in unsettled)
    verdict, why = _judged(found, left)
    trial = without_each(search, given, names)
    held = table(trial)
    points = frozenset(given.lacking.points)
    every = np.arange(len(points))
    train = table([stages_at(search, given, names, every)], floor(measured, best))
    return Diagnosis(
        provenance=task.provenance,
        model=task.model,
        verdict=verdict,
        why=why,
        where=_ranked(measured, found.refitted),
        regions=regions(found.refitted.lacking),
        effects=_added(found, best, every),
        alternatives=alternatives,
        rest=left,
        next_experiment=_next(alternatives),
        next_schedule=None,
        gap_heldout=with_floor(held, train),
        gap_train=train,
        gap_runs=(),
        ranking=found.steps[0].tried,
        threshold=found.steps[0].tried[0].threshold,
        refitted=best.factors(),
        residuals_before=residual_map(found.refitted, points),
        residuals_after=residual_map(found.final, points),
        overlays=(),
        heldout_runs=tuple(one.run.plan.run for one in task.series[labels[0]] if one.accepted),
        not_tried=not_tried | ruled_out,
        missing=missing,
        left_out=left_out,
        revised=revised(task.plant_data, best.factors(), best.hypothesis(best.beta)),
        notes=tuple(_notes(labels, search, given, found, trial)),
    )


def _ranked(measured: Strokes, model: Linear) -> tuple[Gap, ...]:
    own = measured.windows(model.hypothesis, measured.measured)
    return gaps(own, measured.windows(model.hypothesis, model.runs))[0]


def _judged(found: StrokesFound, left: Sequence[Gap]) -> tuple[Verdict, str]:
    words = []
    if found.names:
        words.append(f"Adding {', then '.join(found.names)} explains what loads left out lack.")
    for step in found.steps:
        if step.close:
            scores = " or ".join(f"{one.name} ({one.score:.0f})" for one in step.close)
            words.append(
                f"Of {_WORDS[step.balance]}, these data can't tell apart, scores in nats: {scores}."
            )
    if left:
        where = ", ".join(f"{one.name} ({one.gap:.1f})" for one in left)
        words.append(f"No effect of the catalogue explains the gap of {where} trial scatters.")
    if found.names:
        return "named", " ".join(words)
    if any(step.close for step in found.steps):
        return "ambiguous", " ".join(words)
    if left:
        return "unknown", " ".join(words)
    return "none", "No balance of the refitted model lacks more than its trials scatter."


def _next(alternatives: Sequence) -> str | None:
    tells = dict.fromkeys(_TELLS[one.name] for one in alternatives if one.name in _TELLS)
    return f"These would tell: {'; '.join(tells)}." if tells else None


def _added(found: StrokesFound, best: Estimates, points: np.ndarray) -> tuple[AddedEffect, ...]:
    effects = []
    for step in found.steps:
        if step.taken is not None:
            gap = tuple(
                touched_gap(one.lacking, (step.balance,), points)
                for one in (step.before, found.final)
            )
            tried = [one for one in step.tried if one.name not in step.ruled_out]
            effects.append(added_effect(step.taken, tried, best, gap))
    return tuple(effects)


def _notes(
    labels: Sequence[str],
    search: SeriesSearch,
    given: Linear,
    found: StrokesFound,
    trial: Sequence[Stages],
) -> Iterator[str]:
    yield (
        "Each load was left out in turn: gaps of held-out runs are predictions with parameters "
        "from the other loads. The choice of effects saw all loads."
    )
    yield f"Error at loads left out, root mean square of both directions: {errors(trial)}."
    sets = [one.name for step in found.steps for one in step.close]
    for name in sets:
        more = without_each(search, given, (*found.names, name))
        yield f"The same with {name} besides: {errors(more)}."
    if "load_cell_gain" in (*sets, *found.names):
        yield _GAIN
    if len(labels) > 1:
        yield (
            f"Evidence too, taken as the same cylinder with other seals: {', '.join(labels[1:])}. "
            f"Only {' and '.join(OF_THE_SEAL)} may differ between them."
        )
