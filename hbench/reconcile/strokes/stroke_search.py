"""Search for effects in steady strokes: few operating points, two balances, several series.

The band and the middle are searched one after the other, so that effects that change sign with the
direction are separated from those that do not. Where several candidates explain the band equally
well, the middle is searched with the best of them, since part of a friction effect may appear in
it. Operating points are few, so null data sets are drawn by rotation (``rotated``).

Series of one cylinder on one bench differ only in the seal, so they share the verdict: scores and
null scores are summed. Effects that do not depend on the seal must have one coefficient in all
series; an effect whose coefficients differ beyond their 95 % intervals is ruled out. So is an
effect in the middle that can't cause its change within a stroke (``within_stroke.py``), and one
that would be more friction than was measured.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from hbench.analysis.rounding import ranked
from hbench.analysis.statistics.student import student_factor
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.acceptance import (
    NULLS,
    TIE,
    AcceptanceCriteria,
    indistinguishable,
    threshold_of,
)
from hbench.reconcile.column_names import (
    coefficient_name,
    coefficient_of,
    factor_name,
    is_coefficient,
)
from hbench.reconcile.estimates import ParameterEstimates, fit_coefficients, times, whole_dof
from hbench.reconcile.evidence.cross_validation import rotated
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.linearised import LinearisedModel, linearise
from hbench.reconcile.nuisance import nuisances
from hbench.reconcile.search.candidates import CandidateEvaluator, EvaluatedCandidate
from hbench.reconcile.strokes.series import MeasuredStrokes
from hbench.records import Candidate, FitParameter

_FORM_ERROR = 0.1  # of the gap: what a law of another form than the true one may not explain
OF_THE_SEAL = ("seal_pressure_friction", "direction_asymmetry")
# 3 nats are odds of 20 to 1, which four operating points can reach.
_CRITERIA = AcceptanceCriteria(score=3.0, explained=0.5, size=0.1)


@dataclass(frozen=True)
class SeriesSearch(CandidateEvaluator):
    """Evaluation of candidates on the strokes of one series.

    The search starts with the given model's friction at the level that was measured, so a first
    guess of it has no influence.
    """

    measured: MeasuredStrokes  # levelled
    levels: Mapping[str, float]  # factors by which the given model was levelled
    before: GapMap  # residuals of the given model

    def refit(
        self,
        start: LinearisedModel,
        effects: Sequence[str],
        renewed: Sequence[str] | None = None,
    ) -> LinearisedModel:
        """Refit the nuisances and the coefficients of ``effects``; all columns at the result."""
        model = super().refit(start, effects, renewed)
        return self.with_columns(model, model.columns)

    def evaluate(
        self, model: LinearisedModel, added: tuple[str, ...], names: Sequence[str]
    ) -> dict[str, EvaluatedCandidate]:
        """Evaluate candidates at their fitted coefficients, with the textbook's shape."""
        return {name: self._evaluate_at_best(model, model, added, name) for name in names}

    def null_scores(
        self, model: LinearisedModel, added: tuple[str, ...], name: str, seed: int
    ) -> np.ndarray:
        """Return a candidate's scores on null data sets."""
        return self.score_of(model, added, name, rotated(model.data, NULLS, seed))

    def estimates(self, model: LinearisedModel, names: Sequence[str]) -> ParameterEstimates:
        """Return the parameters about a model with the effects ``names``."""
        return fit_coefficients(self.measured.plant, model, names, self.train)

    def factors(self, estimates: ParameterEstimates) -> dict[str, FitParameter]:
        """Return the factors on the given model's values, by dotted path."""
        return {
            path: times(parameter, self.levels.get(path, 1.0))
            for path, parameter in estimates.factors().items()
        }


@dataclass(frozen=True)
class StrokeSearchStep:
    """Step of the search in one balance, with the summed scores of the candidates."""

    balance: str
    before: LinearisedModel  # of the first series
    evaluated: tuple[Candidate, ...]  # best first: values of the first series, scores of all
    added: str | None
    ambiguous: tuple[Candidate, ...]
    ruled_out: dict[str, str]  # reason by candidate


@dataclass(frozen=True)
class StrokeSearchResult:
    """Models and steps of the search in the first series."""

    refitted: LinearisedModel
    steps: tuple[StrokeSearchStep, ...]
    final: LinearisedModel

    @property
    def names(self) -> tuple[str, ...]:
        """The effects that were added, in order."""
        return tuple(step.added for step in self.steps if step.added)


def start_search(strokes: MeasuredStrokes) -> tuple[SeriesSearch, LinearisedModel]:
    """Return the search of a series and the levelled model. Raises ``DataError``."""
    measured = strokes.levelled
    names = [*map(factor_name, nuisances(measured.plant))]
    names += map(coefficient_name, measured.observable)
    start = linearise(measured, Hypothesis(), measured.columns(Hypothesis(), names))
    points = np.arange(len(start.gap_map.points))
    effects = tuple(dict.fromkeys(name for name, _ in measured.observable))
    before = strokes.gap_map(Hypothesis(), start.gap_map)
    return SeriesSearch(measured, points, effects, strokes.levels, before), start


def search_series(series: Sequence[tuple[SeriesSearch, LinearisedModel]]) -> StrokeSearchResult:
    """Search for effects; ``series`` are those of one cylinder, the requested one first."""
    searches = [search for search, _ in series]
    start = models = [search.refit(given, ()) for search, given in series]
    steps: list[StrokeSearchStep] = []
    assumed: tuple[str, ...] = ()
    for balance in searches[0].measured.balances:
        while True:
            step, extended = _step(searches, models, assumed, balance)
            steps.append(step)
            best = step.added or (step.ambiguous[0].name if step.ambiguous else None)
            if best is None:
                break
            models, assumed = extended, (*assumed, best)
            if step.added is None:
                break
    steps = [_beside_the_others(searches, start, assumed, step) for step in steps]
    names = tuple(step.added for step in steps if step.added)
    final = models[0] if assumed == names else searches[0].refit(start[0], names)
    return StrokeSearchResult(start[0], tuple(steps), final)


def _beside_the_others(
    searches: Sequence[SeriesSearch],
    start: Sequence[LinearisedModel],
    assumed: Sequence[str],
    step: StrokeSearchStep,
) -> StrokeSearchStep:
    """Return a step beside the effects that were found after it, if it adds another one there.

    Where the middle is far off, errors of the sensors within their tolerances are fitted to it, and
    their part of the band lets one of two equal laws look better than the other.
    """
    if step.added is None or assumed[-1] == step.added:
        return step
    others = tuple(name for name in assumed if name != step.added)
    models = [search.refit(model, others) for search, model in zip(searches, start, strict=True)]
    again, _ = _step(searches, models, others, step.balance)
    return step if again.added == step.added else again


def _step(
    searches: Sequence[SeriesSearch],
    models: list[LinearisedModel],
    added: tuple[str, ...],
    balance: str,
) -> tuple[StrokeSearchStep, list[LinearisedModel]]:
    """Return a step, and the models with its best accepted candidate."""
    visible = [_visible_effects(model, balance) for model in models]
    names = [
        name
        for name in searches[0].candidates
        if name not in added and all(name in effects for effects in visible)
    ]
    evaluated = [
        search.evaluate(model, added, names) for search, model in zip(searches, models, strict=True)
    ]
    summed = [
        replace(
            evaluated[0][name].candidate,
            score=sum(of_series[name].candidate.score for of_series in evaluated),
            threshold=_CRITERIA.score,
        )
        for name in names
    ]
    if any(_CRITERIA.accepts(candidate) for candidate in summed):
        nulls = _largest_null_scores(searches, models, added, names)
        threshold = max(_CRITERIA.score, threshold_of(nulls, families=2))  # band and middle
        summed = [replace(candidate, threshold=threshold) for candidate in summed]
    candidates = tuple(ranked(tuple(summed), lambda candidate: candidate.score, TIE))
    with_effect = {name: [_model_of(of_series[name]) for of_series in evaluated] for name in names}
    accepted = [candidate for candidate in candidates if _CRITERIA.accepts(candidate)]
    reasons = {
        each.name: _reason_against(searches, with_effect[each.name], added, each.name, balance)
        for each in accepted
    }
    ruled_out = {name: reason for name, reason in reasons.items() if reason}
    accepted = [candidate for candidate in accepted if candidate.name not in ruled_out]
    rejected = (candidate for candidate in candidates if candidate not in accepted)
    candidates = (*accepted, *rejected)
    step = StrokeSearchStep(balance, models[0], candidates, None, (), ruled_out)
    if not accepted:
        return step, models
    ambiguous, name = _not_distinguishable(accepted), accepted[0].name
    several = len(ambiguous) > 1
    step = replace(step, ambiguous=ambiguous) if several else replace(step, added=name)
    extended = [
        search.refit(model, (*added, name))
        for search, model in zip(searches, with_effect[name], strict=True)
    ]
    return step, extended


def _reason_against(
    searches: Sequence[SeriesSearch],
    models: Sequence[LinearisedModel],
    added: tuple[str, ...],
    name: str,
    balance: str,
) -> str:
    """Return why an effect is ruled out although its score suffices; empty if it is not.

    ``models`` are those of the series with the effect.
    """
    if balance == "force_middle":
        contradictions = (search.measured.contradiction(name) for search in searches)
        if reason := next(filter(None, contradictions), ""):
            return reason
    estimates = [
        search.estimates(model, (*added, name))
        for search, model in zip(searches, models, strict=True)
    ]
    for search, each in zip(searches, estimates, strict=True):
        if reason := search.measured.excess_friction(each.hypothesis, name):
            return reason
    return "" if name in OF_THE_SEAL else _inconsistency(estimates, name)


def _not_distinguishable(accepted: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Return the best candidate and those that the strokes do not distinguish from it.

    Where the scatter is small, the score of two laws that explain nearly all is decided by the form
    of the laws, which is idealised.
    """
    best, close = accepted[0], indistinguishable(accepted)
    return tuple(
        each
        for each in accepted
        if each in close
        or (
            each.explained >= best.explained - _FORM_ERROR
            and EFFECTS[each.name].balances == EFFECTS[best.name].balances
        )
    )


def _largest_null_scores(
    searches: Sequence[SeriesSearch],
    models: Sequence[LinearisedModel],
    added: tuple[str, ...],
    names: Sequence[str],
) -> np.ndarray:
    """Return the largest score (n,) of any candidate on each null data set, over all series."""
    largest = np.zeros(NULLS)
    for name in names:
        scores = [
            search.null_scores(model, added, name, seed)
            for seed, (search, model) in enumerate(zip(searches, models, strict=True))
        ]
        largest = np.maximum(largest, np.sum(scores, axis=0))
    return largest


def _model_of(evaluated: EvaluatedCandidate) -> LinearisedModel:
    assert evaluated.model is not None  # candidates are always evaluated in full
    return evaluated.model


def _visible_effects(model: LinearisedModel, balance: str) -> set[str]:
    """Return the effects with a nonzero column in a balance."""
    groups = [i for i, (name, _) in enumerate(model.data.groups) if name == balance]
    visible = np.flatnonzero(model.data.columns.nonzero[groups].any(axis=0))
    names = [model.data.names[j] for j in visible]
    return {coefficient_of(name)[0] for name in names if is_coefficient(name)}


def _inconsistency(estimates: Sequence[ParameterEstimates], name: str) -> str:
    """Return where a coefficient differs between two series beyond its 95 % interval.

    A coefficient at a bound has no standard error and is not compared.
    """
    for pair in combinations(estimates, 2):
        of_series = [each.of_effect(name) for each in pair]
        for key, a in of_series[0].items():
            b = of_series[1][key]
            if a.se is None or b.se is None:
                continue
            dof = whole_dof(min(each.degrees_of_freedom((name, key)) for each in pair))
            if abs(a.value - b.value) > student_factor(dof) * np.hypot(a.se, b.se):
                return (
                    f"its coefficient '{key}' differs between series of this cylinder with "
                    f"different seals: {a.value:.3g} and {b.value:.3g} {a.unit}, standard errors "
                    f"{a.se:.1g} and {b.se:.1g}; only an effect of the seal may differ"
                )
    return ""
