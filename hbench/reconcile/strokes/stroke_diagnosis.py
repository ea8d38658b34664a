"""Diagnosis of the steady strokes of another bench: verdict, intervals, leave-one-out gaps.

The gaps of held-out runs are those of each load in turn, with parameters from the other loads. The
effects of the model were chosen with all loads: four loads are too few to choose by three.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from hbench.config.sensors import Instruments
from hbench.config.stroke_model import StrokePlant
from hbench.errors import ConfigError
from hbench.reconcile.diagnosis_fields import (
    ModelledData,
    added_effect,
    insufficient_data_diagnosis,
    residual_map,
)
from hbench.reconcile.estimates import ParameterEstimates
from hbench.reconcile.gaps.log_map import unexplained_gaps
from hbench.reconcile.gaps.regions import regions
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.linearised import LinearisedModel
from hbench.reconcile.nuisance import nuisances, zero_tolerances
from hbench.reconcile.revised_model import revised
from hbench.reconcile.separation.missing_data import missing_experiments
from hbench.reconcile.strokes.leave_one_out import (
    StageGaps,
    gap_floor,
    gap_table,
    gaps_at,
    held_out_loads,
    leave_each_load_out,
    with_floor,
)
from hbench.reconcile.strokes.pairs import (
    StrokePair,
    has_force_sensor,
    repeats,
    stroke_pairs,
    with_unknown_load,
)
from hbench.reconcile.strokes.series import MeasuredStrokes
from hbench.reconcile.strokes.stroke_practice import strokes_in_practice
from hbench.reconcile.strokes.stroke_search import (
    SeriesSearch,
    StrokeSearchResult,
    search_series,
    start_search,
)
from hbench.reconcile.strokes.stroke_words import (
    BALANCE_TEXTS,
    DRIFT_NOTE,
    NO_SENSOR_NOTE,
    next_experiment,
    not_tried,
    stroke_notes,
)
from hbench.reconcile.verdict import (
    NO_RESIDUALS,
    named_words,
    scores,
    unexplained_words,
)
from hbench.records import (
    AddedEffect,
    Candidate,
    Diagnosis,
    Gap,
    ScreenedRun,
    Verdict,
)

FEWEST_LOADS = 4  # with two strokes in each direction at one speed
_SAME_AREA = 0.002
_NOT_OF_STROKES = ("reversals", "steps", "hold")  # experiments that this method does not use
_APPLIED_FORCE = (
    "the applied force; without a force sensor set f_applied_n to 0 N in the constants of the "
    "import map, and the friction band alone is compared"
)


@dataclass(frozen=True, kw_only=True)
class StrokeTask(ModelledData):
    """Task of a diagnosis: series of steady strokes and a model of the cylinder."""

    plant: StrokePlant  # of the model
    series: Mapping[str, Sequence[ScreenedRun]]  # by label, the requested one first
    instruments: Instruments | None = None  # as the campaign states them


def diagnose_strokes(task: StrokeTask) -> Diagnosis:
    """Determine the effects behind the residuals of steady strokes; see ``Diagnosis``.

    Other series of the same cylinder are evidence too. Raises ``ConfigError`` where the model's
    cylinder is not the one that was measured.
    """
    (label, screened), *others = task.series.items()
    left_out = tuple(
        f"run {run.run.plan.run}: {'; '.join(run.reasons)}" for run in screened if not run.accepted
    )
    accepted = [run.run for run in screened if run.accepted]
    usable = missing_experiments(accepted).items()
    missing = tuple(text for code, text in usable if code not in _NOT_OF_STROKES)
    sensor, pairs = has_force_sensor(screened), _repeated(screened)
    loads = len({pair.plan for pair in pairs})
    if loads < FEWEST_LOADS:
        shortfall = (
            f"at least {FEWEST_LOADS} loads or pressures with two or more strokes in each "
            f"direction at one speed{'' if sensor else ' and at the same positions'}; these runs "
            f"have {loads}"
        )
        no_force = all(run.run.f_applied_n is None for run in screened)
        shortfalls = (*([_APPLIED_FORCE] if no_force else []), shortfall, *missing)
        found = insufficient_data_diagnosis(task, shortfalls, left_out)
        return found if sensor else replace(found, notes=(NO_SENSOR_NOTE, DRIFT_NOTE))
    _check_areas(task, pairs)
    of_cylinder = {label: pairs}
    for other, runs in others:
        more = _repeated(runs)
        if len({pair.plan for pair in more}) >= FEWEST_LOADS:
            if more[0].plan.specimen == pairs[0].plan.specimen and has_force_sensor(runs) == sensor:
                of_cylinder[other] = more
    series = [
        start_search(MeasuredStrokes(task.plant, of_series, sensor, task.instruments))
        for of_series in of_cylinder.values()
    ]
    return _assembled(task, list(of_cylinder), series, missing, left_out)


def _repeated(screened: Sequence[ScreenedRun]) -> tuple[StrokePair, ...]:
    pairs = stroke_pairs(screened)
    if not has_force_sensor(screened):
        pairs = with_unknown_load(pairs)
    return tuple(pair for runs in repeats(pairs).values() for run in runs for pair in run)


def _check_areas(task: StrokeTask, pairs: Sequence[StrokePair]) -> None:
    """Raise ``ConfigError`` if an area on which a pressure acts is not that of the campaign."""
    measured, modelled = pairs[0].plan.specimen, task.plant.test_cylinder
    sides = [("piston area", measured.area_piston_m2, modelled.area_piston_m2, "piston_diameter")]
    if any(stroke.p_tr_pa for pair in pairs for stroke in (pair.extend, pair.retract)):
        sides += [("rod-side area", measured.area_rod_m2, modelled.area_rod_m2, "rod_diameter")]
    for name, of_campaign, of_model, key in sides:
        if abs(of_model - of_campaign) > _SAME_AREA * of_campaign:
            raise ConfigError(
                f"{task.model}: test_cylinder has a {name} of {1e4 * of_model:.4g} cm^2, the "
                f"campaign's cylinder {1e4 * of_campaign:.4g} cm^2 "
                f"(limit: {_SAME_AREA:.1%} difference)",
                f"Correct test_cylinder.{key} in {task.model}, or the import's map.",
            )


class _Fitted(NamedTuple):
    """Model with some effects, and the gaps of each load outside its fit."""

    model: LinearisedModel
    estimates: ParameterEstimates
    by_load: list[StageGaps]


def _fitted(
    search: SeriesSearch, start: LinearisedModel, model: LinearisedModel, names: Sequence[str]
) -> _Fitted:
    by_load = leave_each_load_out(search, start, names)
    return _Fitted(model, search.estimates(model, names), by_load)


def _assembled(
    task: StrokeTask,
    labels: Sequence[str],
    series: Sequence[tuple[SeriesSearch, LinearisedModel]],
    missing: tuple[str, ...],
    left_out: tuple[str, ...],
) -> Diagnosis:
    """Search all series, and return the diagnosis of the first one."""
    search, start = series[0]
    strokes, result = search.measured, search_series(series)
    found = _fitted(search, start, result.final, result.names)
    effects = _added_effects(search, start, result, found)
    names = tuple(effect.name for effect in effects if effect.confirmed)
    kept = found
    if names != result.names:
        kept = _fitted(search, start, search.refit(result.refitted, names), names)
    factors, best = search.factors(kept.estimates), kept.estimates.hypothesis
    alternatives = tuple(
        replace(candidate, balance=step.balance)
        for step in result.steps
        for candidate in step.ambiguous
    )
    with_alternative = {
        candidate.name: (*names, *_best_elsewhere(result, candidate), candidate.name)
        for candidate in alternatives
    }
    fits = dict.fromkeys(result.names, found.estimates) | {
        name: search.estimates(search.refit(start, joined), joined)
        for name, joined in with_alternative.items()
    }
    unexplained = _unexplained(strokes, result, best)
    unconfirmed = [effect.name for effect in effects if not effect.confirmed]
    verdict, why = _decide_verdict(result, unconfirmed, unexplained)
    point, practice = strokes_in_practice(strokes, best, fits)
    sections, priors = revised(task.plant_data, factors, best), nuisances(strokes.plant)
    return Diagnosis(
        provenance=task.provenance,
        model=task.model,
        verdict=verdict,
        why=why,
        effects=effects,
        alternatives=alternatives,
        rest=unexplained,
        next_experiment=next_experiment(result),
        ranking=result.steps[0].evaluated,
        threshold=result.steps[0].evaluated[0].threshold,
        refitted=factors,
        refit_priors={path: priors[path] for path in factors},
        heldout_runs=tuple(run.run.plan.run for run in task.series[labels[0]] if run.accepted),
        not_tried=not_tried(search),
        ruled_out={name: why for step in result.steps for name, why in step.ruled_out.items()},
        missing=missing,
        left_out=left_out,
        revised=sections,
        within_tolerance=tuple(
            name
            for name in dict.fromkeys(name for name, _ in strokes.tolerances)
            if name in sections.get("effects", {})
        ),
        zero_tolerances=zero_tolerances(strokes.tolerances),
        notes=tuple(stroke_notes(labels, search, names, alternatives)),
        working_point=point,
        practice=practice,
        **_residual_fields(strokes, result, best),
        **_gap_fields(search, start, names, kept, with_alternative),
    )


def _unexplained(
    strokes: MeasuredStrokes, result: StrokeSearchResult, best: Hypothesis
) -> tuple[Gap, ...]:
    """Return the gaps of the best model that no effect or ambiguous set explains."""
    undecided = {step.balance for step in result.steps if step.ambiguous}
    gaps = unexplained_gaps(strokes.ranked_gaps(best))
    return tuple(gap for gap in gaps if gap.name not in undecided)


def _residual_fields(
    strokes: MeasuredStrokes, result: StrokeSearchResult, best: Hypothesis
) -> dict[str, Any]:
    """Return the diagnosis's fields on residuals: of the refitted and of the best model."""
    before = result.refitted.gap_map
    after, points = strokes.gap_map(best, before), frozenset(before.points)
    return {
        "where": strokes.ranked_gaps(result.refitted.hypothesis),
        "regions": regions(before),
        "regions_after": regions(after),
        "residuals_before": residual_map(before, points, "N"),
        "residuals_after": residual_map(after, points, "N"),
    }


def _gap_fields(
    search: SeriesSearch,
    start: LinearisedModel,
    names: Sequence[str],
    kept: _Fitted,
    with_alternative: Mapping[str, Sequence[str]],
) -> dict[str, Any]:
    """Return the diagnosis's fields on gaps: with all loads in the fit, and of held-out loads.

    ``with_alternative`` are the effects of the model with each candidate of an ambiguous set.
    """
    whole = gaps_at(search, start, names, np.arange(len(start.gap_map.points)))
    train = gap_table([whole], gap_floor(kept.model, kept.estimates))
    of_alternatives = {
        name: leave_each_load_out(search, start, joined)
        for name, joined in with_alternative.items()
    }
    return {
        "gap_heldout": with_floor(gap_table(kept.by_load), train),
        "gap_train": train,
        "held_out_loads": held_out_loads(kept.by_load, of_alternatives),
    }


def _decide_verdict(
    result: StrokeSearchResult, unconfirmed: Sequence[str], unexplained: Sequence[Gap]
) -> tuple[Verdict, str]:
    sentences = [named_words(result.names, unconfirmed)] if result.names else []
    for step in result.steps:
        if step.ambiguous:
            sentences.append(
                f"Not distinguishable for {BALANCE_TEXTS[step.balance]}, scores in nats: "
                f"{scores(step.ambiguous)}."
            )
    if unexplained:
        sentences.append(unexplained_words(unexplained))
    if result.names:
        return "named", " ".join(sentences)
    if any(step.ambiguous for step in result.steps):
        return "ambiguous", " ".join(sentences)
    if unexplained:
        return "unknown", " ".join(sentences)
    return "none", NO_RESIDUALS


def _best_elsewhere(result: StrokeSearchResult, candidate: Candidate) -> tuple[str, ...]:
    """Return the best of each ambiguous set to which a candidate does not belong."""
    return tuple(
        step.ambiguous[0].name
        for step in result.steps
        if step.ambiguous and step.balance != candidate.balance
    )


def _added_effects(
    search: SeriesSearch,
    start: LinearisedModel,
    result: StrokeSearchResult,
    found: _Fitted,
) -> tuple[AddedEffect, ...]:
    """Return the added effects of the model ``found``; their gaps are those of held-out loads."""
    effects, held_out = list[AddedEffect](), gap_table(found.by_load)
    for step in result.steps:
        if step.added is not None:
            earlier = result.names[: len(effects)]
            without = gap_table(leave_each_load_out(search, start, earlier))
            candidates = [each for each in step.evaluated if each.name not in step.ruled_out]
            effects.append(
                added_effect(
                    step.added,
                    candidates,
                    found.estimates,
                    without.balances[step.balance].after,
                    held_out.balances[step.balance].after,
                )
            )
    return tuple(effects)
