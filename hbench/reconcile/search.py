"""Search for effects of the catalogue that a model does not contain, one after another.

Each candidate is first evaluated about the refitted model by its signature (``evidence.score``).
The best are then simulated with their fitted coefficients and evaluated again. An effect is added
if, by cross-validation over operating points,

    its score exceeds 5 nats and the 98 % quantile of the largest null score: null data sets are the
    candidate's own residuals with random signs, over all candidates for the same balances,
    it explains more than a quarter of the excess gap in the balances it touches, and
    its coefficient is at least a fifth of the typical size.

Candidates whose scores are close to the best one form an ambiguous set, and none is added.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.rounding import ranked
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.candidates import (
    CRITERIA,
    NULLS,
    TIE,
    CandidateEvaluator,
    EvaluatedCandidate,
    indistinguishable,
)
from hbench.reconcile.evidence import log_likelihood, random_signs, score
from hbench.reconcile.gaps.columns import residuals_of_runs
from hbench.reconcile.hypothesis import shape_coefficients, typical_size
from hbench.reconcile.linearised import LinearisedModel, linearise
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.signatures import signature
from hbench.records import Candidate

_MOST_SIMULATED = 6  # candidates
_LEAST_SHARE = 0.3  # of the best score; candidates below are not simulated
_LEAST_PROMISING = 0.5  # of the least threshold; candidates below are not simulated
_MOST_EFFECTS = 4


@dataclass(frozen=True)
class SearchStep:
    """Step of the search: evaluated candidates, best first, and the effect that was added."""

    before: LinearisedModel
    evaluated: tuple[EvaluatedCandidate, ...]
    added: str | None
    ambiguous: tuple[Candidate, ...]  # where none was added


@dataclass(frozen=True)
class SearchResult:
    """Refitted model, steps of the search, and final model."""

    refitted: LinearisedModel
    steps: tuple[SearchStep, ...]
    final: LinearisedModel

    @property
    def names(self) -> tuple[str, ...]:
        """The effects that were added, in order."""
        return _added(self.steps)


@dataclass(frozen=True)
class CampaignSearch(CandidateEvaluator):
    """Search in the runs of a campaign."""

    measured: MeasuredCampaign

    def run(self, given: LinearisedModel) -> SearchResult:
        """Refit the nuisances of the given model, then search for effects."""
        current = refitted = self.refit(given, ())
        steps: list[SearchStep] = []
        search = self
        while len(steps) < _MOST_EFFECTS:
            step, with_effect = search._step(current, _added(steps))
            steps.append(step)
            if with_effect is None:
                break
            search, current = search._with_shape(with_effect, _added(steps))
        return SearchResult(refitted, tuple(steps), current)

    def _with_shape(
        self, model: LinearisedModel, added: tuple[str, ...]
    ) -> tuple["CampaignSearch", LinearisedModel]:
        """Give the effect that was added last the shape that cross-validation supports."""
        before = log_likelihood(self._cross_validate(model, added))
        balances = self.measured.balance_model(model.hypothesis)
        best_gain, best = CRITERIA.score, (self, model)
        for which in shape_coefficients(added[-1]):
            reshaped = model.hypothesis.with_coefficients(
                {which: model.hypothesis.coefficient(which) + typical_size(which)}
            )
            (runs,) = self.simulate([reshaped], 1)
            if runs is None:
                continue
            column = signature(
                which[0],
                residuals_of_runs(runs, balances),
                residuals_of_runs(model.runs, balances),
            )
            search = replace(self, signatures={**self.signatures, which: column})
            start = search._linearise_like(model, model)
            refitted = search.refit(start, added)
            scaled_alike = search._linearise_like(refitted, model)
            after = log_likelihood(search._cross_validate(scaled_alike, added))
            gain = float((after - before)[0])
            if gain > best_gain:
                best_gain, best = gain, (search, refitted)
        return best

    def _linearise_like(
        self, model: LinearisedModel, reference: LinearisedModel
    ) -> LinearisedModel:
        """Linearise about a model's hypothesis with the scatter of ``reference``."""
        return linearise(
            self.measured, model.hypothesis, model.runs, self.signatures, reference.gap_map
        )

    def _step(
        self, model: LinearisedModel, added: tuple[str, ...]
    ) -> tuple[SearchStep, LinearisedModel | None]:
        """Return a step of the search, and the refitted model if an effect was added."""
        base = model.index(model.coefficients_of(added))
        names = [
            name for name in self.candidates if name not in added and model.coefficients_of([name])
        ]
        by_signature = _best_first(self._evaluate_by_signature(model, base, name) for name in names)
        best = by_signature[0].candidate.score if by_signature else 0.0
        least = max(_LEAST_SHARE * best, _LEAST_PROMISING * CRITERIA.score)
        promising = [each.candidate.name for each in by_signature if each.candidate.score > least]
        simulated = self._evaluate_by_simulation(model, added, promising[:_MOST_SIMULATED])
        evaluated = _best_first(
            self._with_threshold(simulated.get(each.candidate.name, each), model, base, names)
            for each in by_signature
        )
        accepted = {
            each.candidate.name: (each.candidate, each.model)
            for each in evaluated
            if each.model and CRITERIA.accepts(each.candidate)
        }
        if not accepted:
            return SearchStep(model, evaluated, None, ()), None
        ambiguous = indistinguishable([candidate for candidate, _ in accepted.values()])
        if len(ambiguous) > 1:
            return SearchStep(model, evaluated, None, ambiguous), None
        name, (_, with_effect) = next(iter(accepted.items()))
        step = SearchStep(model, evaluated, name, ())
        return step, self.refit(with_effect, (*added, name))

    def _with_threshold(
        self,
        evaluated: EvaluatedCandidate,
        model: LinearisedModel,
        base: Sequence[int],
        names: Sequence[str],
    ) -> EvaluatedCandidate:
        """Return a candidate with the threshold of its score, if it could be accepted.

        Null data sets are the residuals about its own simulation with random signs, without the
        part that it explains.
        """
        candidate = evaluated.candidate
        if evaluated.model is None or not CRITERIA.accepts(candidate):
            return evaluated
        data = evaluated.model.data
        signs = random_signs(NULLS, len(model.gap_map.points), seed=1)
        largest = np.zeros(NULLS)
        balances = set(EFFECTS[candidate.name].balances)
        for name in names:
            if balances.issuperset(EFFECTS[name].balances):
                more = [i for i in model.index(model.coefficients_of([name])) if i not in base]
                null_scores = score(data, model.priors, base, more, self.train, signs)
                largest = np.maximum(largest, null_scores)
        threshold = CRITERIA.threshold(largest)
        return replace(evaluated, candidate=replace(candidate, threshold=threshold))


def _best_first(evaluated: Iterable[EvaluatedCandidate]) -> tuple[EvaluatedCandidate, ...]:
    return tuple(ranked(tuple(evaluated), lambda each: each.candidate.score, TIE))


def _added(steps: Sequence[SearchStep]) -> tuple[str, ...]:
    return tuple(step.added for step in steps if step.added)
