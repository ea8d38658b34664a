"""Search for effects of the catalogue that a model does not contain, one after another.

Each candidate is first evaluated about the refitted model by its columns (``evidence.score``). The
best are then evaluated in full, at their fitted coefficients. An effect is added if, by
cross-validation over operating points,

    its score exceeds 5 nats and what candidates for the same balances score on null data sets: the
    candidate's own residuals with random signs,
    it explains more than a quarter of the excess gap in the balances it touches, and
    its coefficient is at least a quarter of the typical size, and beyond its tolerance.

Candidates whose scores are close to the best one form an ambiguous set, and none is added.

In a round without a missing effect a null score exceeds its threshold with a probability of 5 %,
over all candidates, and the search ends with the first round that adds none. The expected share of
false names is then below 5 % (ForwardStop: G'Sell, Wager, Chouldechova and Tibshirani, Journal of
the Royal Statistical Society B 78, 2016), as far as random signs imitate residuals without an
effect.

After each addition the earlier effects are evaluated again beside the others. One is dropped where
the refitted model without it loses at most 5 nats in cross-validation, and it no longer meets these
criteria about that model. At the end the effects found are refined: refitted with the nuisances,
now with the deviations below what is material, which a search for names leaves out, and with the
shape of each law that cross-validation supports.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.rounding import ranked
from hbench.model.effects.catalogue import EFFECTS
from hbench.parallel.threads import map_on_threads
from hbench.reconcile.candidates import (
    CRITERIA,
    TIE,
    CandidateEvaluator,
    EvaluatedCandidate,
    indistinguishable,
    is_close,
)
from hbench.reconcile.evidence import log_likelihood
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.hypothesis import Hypothesis, effect_coefficients, shape_coefficients
from hbench.reconcile.learned.table import LawFound
from hbench.reconcile.linearised import LinearisedModel, linearise, linearise_residuals
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.records import Candidate

_MOST_IN_FULL = 6  # candidates
_LEAST_SHARE = 0.3  # of the best score; candidates below are not evaluated in full
_LEAST_PROMISING = 0.5  # of the least threshold; candidates below are not evaluated in full
_MOST_EFFECTS = 4
_REFUSED = (
    "The refit of the model's parameters is refused: it increases the gap of the held-out runs by "
    "{increase:.2g} from {before:.2f}."
)


def silent(stage: str) -> None:
    """Take no notice of a stage."""


@dataclass(frozen=True)
class SearchStep:
    """Step of the search: evaluated candidates, best first, and the effect that was added."""

    before: LinearisedModel
    evaluated: tuple[EvaluatedCandidate, ...]
    added: str | None
    ambiguous: tuple[Candidate, ...]  # where none was added
    dropped: tuple[str, ...] = ()  # earlier effects that the added one makes superfluous


@dataclass(frozen=True)
class SearchResult:
    """Given and refitted model, steps of the search, and final model."""

    given: LinearisedModel
    refitted: LinearisedModel
    steps: tuple[SearchStep, ...]
    final: LinearisedModel
    refused: str = ""  # why the refit is refused; the refitted model is then the given one
    laws: tuple[LawFound, ...] = ()  # learned, in the final model
    unlearned: LinearisedModel | None = None  # the final model without them; None: it has none

    @property
    def names(self) -> tuple[str, ...]:
        """The effects that were added and not dropped, in order."""
        return _added(self.steps)

    @property
    def unchanged(self) -> bool:
        """Whether the final model is the given one: the refit is refused and nothing is added."""
        return bool(self.refused) and not self.names and not self.laws


@dataclass(frozen=True)
class CampaignSearch(CandidateEvaluator):
    """Search in the runs of a campaign."""

    measured: MeasuredCampaign
    stage: Callable[[str], None] = silent  # receives a description of each stage

    def run(self) -> SearchResult:
        """Refit the nuisances of the given model, then search for effects."""
        self.stage("refitting the poorly known values of the model")
        given, refitted, refused = self._refitted()
        keys = [".".join(c) for name in self.candidates for c in effect_coefficients(name)]
        new = [key for key in keys if key not in refitted.columns]
        current = refitted = self.with_columns(refitted, new)
        steps: list[SearchStep] = []
        while len(steps) < _MOST_EFFECTS:
            so_far = f" beside {', '.join(_added(steps))}" if steps else ""
            self.stage(f"searching for an effect{so_far} among {len(self.candidates)} candidates")
            step, with_effect = self._step(current, _added(steps))
            if with_effect is None:
                steps.append(step)
                break
            current, dropped = self.without_superfluous(with_effect, _added([*steps, step]))
            steps.append(replace(step, dropped=dropped))
        if names := _added(steps):
            self.stage(f"refining {', '.join(names)}")
            current = self.refined(current, names)
        return SearchResult(given, refitted, tuple(steps), current, refused)

    def without_superfluous(
        self, model: LinearisedModel, names: tuple[str, ...]
    ) -> tuple[LinearisedModel, tuple[str, ...]]:
        """Return the model without the effects that the last of ``names`` makes superfluous."""
        dropped: list[str] = []
        for name in names[:-1]:
            others = tuple(each for each in names if each not in (name, *dropped))
            start = self.linearise_at(model, self._hypothesis_without(model, name))
            without = self.refit(start, others, _columns_of(model, others))
            if self._lost(model, without, (*others, name), others) > CRITERIA.score:
                continue
            without = self.with_columns(without, _columns_of(model, [name]))
            evaluated = self._evaluate_in_full(without, others, name)
            evaluated = self._with_threshold(evaluated, others, [name])
            if not CRITERIA.accepts(evaluated.candidate):
                dropped.append(name)
                model = without
        return model, tuple(dropped)

    def _lost(
        self,
        model: LinearisedModel,
        without: LinearisedModel,
        effects: Sequence[str],
        fewer: Sequence[str],
    ) -> float:
        """Return the loss in cross-validated ln L of the refitted model with ``fewer`` effects.

        About that model the lost effect may have no score: a large rival can leave no way back.
        """
        before, after = self._cross_validate(model, effects), self._cross_validate(without, fewer)
        return float((log_likelihood(before) - log_likelihood(after))[0])

    def _hypothesis_without(self, model: LinearisedModel, name: str) -> Hypothesis:
        """Return a model's hypothesis with an effect at its start."""
        kept = {key: c for key, c in model.hypothesis.effects.items() if key != name}
        start = self.measured.start.effects
        return replace(model.hypothesis, effects=kept | {k: start[k] for k in start if k == name})

    def refined(self, model: LinearisedModel, names: tuple[str, ...]) -> LinearisedModel:
        """Return the model with effects ``names`` and their shapes refitted to all deviations.

        All columns are computed at ``model`` first: with those of the model without an effect no
        step may be better. Those of the nuisances then stay, as refinement changes them little.
        """
        taking_part = [model.data.names[i] for i in model.index(names)]
        residuals = replace(model.gap_map, material=np.zeros(len(model.gap_map.names)))
        start = linearise_residuals(
            self.measured,
            model.hypothesis,
            residuals,
            {key: model.columns[key] for key in taking_part},
        )
        start = self.with_columns(start, taking_part)
        best = self.refit(start, names, _columns_of(start, names))
        for name in names:
            shapes = [".".join(which) for which in shape_coefficients(name)]
            if new := [shape for shape in shapes if shape not in best.columns]:
                shaped = self.with_columns(best, new)
                shaped = self.refit(shaped, names, _columns_of(shaped, names))
                gain = [log_likelihood(self._cross_validate(m, names))[0] for m in (best, shaped)]
                best = shaped if gain[1] > gain[0] else best
        return linearise(self.measured, best.hypothesis, best.columns, model.gap_map)

    def _refitted(self) -> tuple[LinearisedModel, LinearisedModel, str]:
        """Return the given and the refitted model; if not better, the given one and the reason.

        The second refit has the scatter of the first, in which the given model's gaps have no part.
        For this scatter the columns at the given model do.
        """
        start = self.measured.start
        columns = self.measured.columns(start, self.measured.nuisance_columns)
        given = linearise(self.measured, start, columns)
        first = self.refit(given, (), renewed=())
        first = linearise(self.measured, first.hypothesis, first.columns)
        refitted = self.refit(first, ())
        held_out = np.setdiff1d(np.arange(len(given.gap_map.points)), self.train)
        held_out = held_out if len(held_out) else self.train
        before, after = (
            _mean_square(model.gap_map.in_units_of(first.gap_map), held_out)
            for model in (given, refitted)
        )
        if after <= before:
            return given, refitted, ""
        unchanged = linearise(self.measured, start, given.columns, first.gap_map)
        return (
            given,
            unchanged,
            _REFUSED.format(before=before**0.5, increase=after**0.5 - before**0.5),
        )

    def _step(
        self, model: LinearisedModel, added: tuple[str, ...]
    ) -> tuple[SearchStep, LinearisedModel | None]:
        """Return a step of the search, and the refitted model if an effect was added."""
        names = [
            name for name in self.candidates if name not in added and model.coefficients_of([name])
        ]
        linear = _best_first(
            map_on_threads(lambda name: self._evaluate_linearly(model, added, name), names)
        )
        highest = linear[0].candidate.score if linear else 0.0
        least = max(_LEAST_SHARE * highest, _LEAST_PROMISING * CRITERIA.score)
        promising = [each.candidate.name for each in linear if each.candidate.score > least]
        in_full = {
            each.candidate.name: each
            for each in map_on_threads(
                lambda name: self._evaluate_in_full(model, added, name), promising[:_MOST_IN_FULL]
            )
        }
        evaluated = list(_best_first(in_full.get(each.candidate.name, each) for each in linear))
        accepted: dict[str, EvaluatedCandidate] = {}
        for i, each in enumerate(evaluated):
            if accepted and not is_close(each.candidate, next(iter(accepted.values())).candidate):
                break  # it is neither the best one nor a rival
            evaluated[i] = tested = self._with_threshold(each, added, names)
            if tested.model and CRITERIA.accepts(tested.candidate):
                accepted[tested.candidate.name] = tested
        if not accepted:
            return SearchStep(model, tuple(evaluated), None, ()), None
        ambiguous = indistinguishable([each.candidate for each in accepted.values()])
        if len(ambiguous) > 1:
            return SearchStep(model, tuple(evaluated), None, ambiguous), None
        name, best = next(iter(accepted.items()))
        assert best.model is not None  # it was evaluated in full
        step = SearchStep(model, tuple(evaluated), name, ())
        return step, self.refit(best.model, (*added, name))

    def _with_threshold(
        self, evaluated: EvaluatedCandidate, added: tuple[str, ...], names: Sequence[str]
    ) -> EvaluatedCandidate:
        """Return a candidate with the threshold of its score, if it could be accepted.

        Null data sets are the residuals at its own coefficients with random signs, without the
        part that it explains.
        """
        candidate, model = evaluated.candidate, evaluated.model
        if model is None or not CRITERIA.accepts(candidate):
            return evaluated
        balances = set(EFFECTS[candidate.name].balances)
        family = [name for name in names if balances.issuperset(EFFECTS[name].balances)]
        null = model.about_itself([candidate.name])
        threshold = self.null_threshold(null, added, family, candidate.score, families=len(names))
        return replace(evaluated, candidate=replace(candidate, threshold=threshold))


def _mean_square(residuals: GapMap, points: np.ndarray) -> float:
    """Return the mean square of the residuals at some operating points, in scatters."""
    chosen = residuals.select_points(points)
    return float(np.nanmean((chosen.difference / chosen.scatter) ** 2))


def _columns_of(model: LinearisedModel, names: Iterable[str]) -> list[str]:
    """Return the names of the columns that some effects have in a model."""
    return [".".join(which) for which in model.coefficients_of(names)]


def _best_first(evaluated: Iterable[EvaluatedCandidate]) -> tuple[EvaluatedCandidate, ...]:
    return tuple(ranked(tuple(evaluated), lambda each: each.candidate.score, TIE))


def _added(steps: Sequence[SearchStep]) -> tuple[str, ...]:
    dropped = {name: i for i, step in enumerate(steps) for name in step.dropped}
    return tuple(
        step.added for i, step in enumerate(steps) if step.added and i >= dropped.get(step.added, 0)
    )
