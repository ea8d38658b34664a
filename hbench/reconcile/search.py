"""Search for effects of the catalogue that a model does not contain, one after another.

Each candidate is first evaluated about the refitted model by its columns (``evidence.score``). The
best are then evaluated in full, at their fitted coefficients. An effect is added if, by
cross-validation over operating points,

    its score exceeds 5 nats and what candidates for the same balances score on null data sets: the
    candidate's own residuals with random signs,
    it explains more than a quarter of the excess gap in the balances it touches, all together or on
    average of those that it can change so much, and
    its coefficient is at least a quarter of the typical size, and beyond its tolerance.

Candidates whose scores are close to the best one are rivals. Where each would be accepted beside
the best one, and the best one beside each, they are all present and the best one is added.
Otherwise they form an ambiguous set, and none is added. An effect that would be accepted beside
each of them is present whichever is right: it is added, and the search continues.

Refitted nuisances may have taken the part of an effect that is still missing, such as a level of
friction that of friction under load: then no step from their refitted values leads to it. Where
gaps remain after an effect was added and no candidate is accepted, the best candidates are
therefore fitted once more from the given values of the nuisances.

In a round without a missing effect a null score exceeds its threshold with a probability of 5 %,
over all candidates, and the search ends with the first round that adds none. The expected share of
false names is then below 5 % (ForwardStop: G'Sell, Wager, Chouldechova and Tibshirani, Journal of
the Royal Statistical Society B 78, 2016), as far as random signs imitate residuals without an
effect.

After each addition the earlier effects are evaluated again beside the others. One is dropped where
the refitted model without it loses at most 5 nats in cross-validation, and it no longer meets these
criteria about that model. At the end the effects found are refined: refitted with the nuisances,
now with the deviations below what is material, which a search for names leaves out, and with the
shape of each law that cross-validation supports. An effect that is then smaller than these criteria
ask for, or whose coefficients together do not differ from 0 (95 %), is left out again.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.rounding import distinct_texts, ranked
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
from hbench.reconcile.diagnosis_fields import gap_of_balances
from hbench.reconcile.estimates import fit_coefficients
from hbench.reconcile.evidence import log_likelihood
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.gaps.log_map import unexplained_at
from hbench.reconcile.hypothesis import Hypothesis, effect_coefficients, shape_coefficients
from hbench.reconcile.linearised import LinearisedModel, linearise, linearise_residuals
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.search_result import SearchResult, SearchStep, added_names
from hbench.records import Candidate

_MOST_IN_FULL = 6  # candidates
_MOST_AFRESH = 3  # candidates; their columns are far from the fit, so a score says little
_LEAST_SHARE = 0.3  # of the best score; candidates below are not evaluated in full
_LEAST_PROMISING = 0.5  # of the least threshold; candidates below are not evaluated in full
_MOST_EFFECTS = 4
_AS_SMALL = 1.02  # times the smallest gap: no reason to prefer a model
_REFUSED = (
    "Refitting the poorly known values of the model would increase the gap of the held-out runs "
    "from {} to {}, so the values of the model file are kept."
)


def silent(stage: str) -> None:
    """Take no notice of a stage."""


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
            so_far = f" beside {', '.join(added_names(steps))}" if steps else ""
            self.stage(f"searching for an effect{so_far} among {len(self.candidates)} candidates")
            step, with_effect = self._step(current, added_names(steps))
            if so_far and not (step.added or step.ambiguous) and self._has_gaps(current):
                self.stage(f"searching again from the given values{so_far}")
                step, with_effect = self._step_afresh(current, added_names(steps), step)
            if step.ambiguous and len(steps) < _MOST_EFFECTS - 1:
                self.stage(f"searching beside each of {', '.join(_names(step.ambiguous))}")
                step, with_effect = self._step_beside_each(current, added_names(steps), step)
            if with_effect is None:
                steps.append(step)
                break
            current, dropped = self.without_superfluous(with_effect, added_names([*steps, step]))
            steps.append(replace(step, dropped=dropped))
        final, vanished = self._refined_and_named(current, added_names(steps))
        return SearchResult(given, refitted, tuple(steps), final, refused, vanished=vanished)

    def _refined_and_named(
        self, model: LinearisedModel, names: tuple[str, ...]
    ) -> tuple[LinearisedModel, tuple[str, ...]]:
        """Return the refined model, and the effects that are now too small to be named, if any.

        They are left out one at a time, the last added first: of two alike, each may be 0 beside
        the other, and not both.
        """
        vanished: tuple[str, ...] = ()
        while names:
            self.stage(f"refining {', '.join(names)}")
            refined = self.refined(model, names)
            gone = [name for name in names if not self._remains(refined, names, name)][-1:]
            if not gone:
                return refined, vanished
            names = tuple(name for name in names if name not in gone)
            model, vanished = self.without(refined, gone, names), (*vanished, *gone)
        return model, vanished

    def within_tolerance(self, model: LinearisedModel, names: tuple[str, ...]) -> tuple[str, ...]:
        """Return the errors of sensors among the effects of a model that are no longer effects."""
        tolerated = self._tolerated(names)
        return tuple(name for name in tolerated if not self._remains(model, names, name))

    def _remains(self, model: LinearisedModel, names: tuple[str, ...], name: str) -> bool:
        """Return whether one of the effects of a refined model is large enough, and not 0.

        Its size is that of the model or of the linear fit about it, which the diagnosis states: the
        smaller.
        """
        estimates = fit_coefficients(self.measured.plant, model, names, self.train)
        fitted = self._values(model, name, estimates.chosen, estimates.beta)
        both = (self._own_values(model, name), fitted)
        sizes = [self._candidate(name, 0.0, 0.0, each, "full").size for each in both]
        return min(sizes) >= CRITERIA.size and not estimates.may_be_zero(name)

    def without_superfluous(
        self, model: LinearisedModel, names: tuple[str, ...]
    ) -> tuple[LinearisedModel, tuple[str, ...]]:
        """Return the model without the effects that the last of ``names`` makes superfluous."""
        dropped: list[str] = []
        for name in names[:-1]:
            others = tuple(each for each in names if each not in (name, *dropped))
            without = self.without(model, [name], others)
            if self._lost(model, without, (*others, name), others) > CRITERIA.score:
                continue
            without = self.with_columns(without, _columns_of(model, [name]))
            evaluated = self._evaluate_in_full(without, others, name)
            evaluated = self._with_threshold(evaluated, others, [name])
            if not CRITERIA.accepts(evaluated.candidate):
                dropped.append(name)
                model = without
        return model, tuple(dropped)

    def without(
        self, model: LinearisedModel, removed: Sequence[str], others: Sequence[str]
    ) -> LinearisedModel:
        """Return the model without some effects, refitted with the ``others``."""
        start = self.linearise_at(model, self._hypothesis_without(model, removed))
        return self.refit(start, others, _columns_of(model, others))

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

    def _hypothesis_without(self, model: LinearisedModel, removed: Sequence[str]) -> Hypothesis:
        """Return a model's hypothesis with some effects at their start."""
        kept = {key: c for key, c in model.hypothesis.effects.items() if key not in removed}
        start = {k: c for k, c in self.measured.start.effects.items() if k in removed}
        return replace(model.hypothesis, effects=kept | start)

    def refined(self, model: LinearisedModel, names: tuple[str, ...]) -> LinearisedModel:
        """Return the model with effects ``names`` and their shapes refitted to all deviations.

        All columns are computed at ``model`` first: with those of the model without an effect no
        step may be better. Those of the nuisances then stay, as refinement changes them little.

        Deviations that do not matter may determine an effect, but where the law of another one is
        wrong they can also cost more of those that do. So the nuisances are then refitted to what
        matters alone. Of the refined model, this one and the one before, the first is returned
        whose gap of the training points is about the smallest.
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
        fine = linearise(self.measured, best.hypothesis, best.columns, model.gap_map)
        settled = self.refit(fine, self._tolerated(names), renewed=())
        models = (fine, settled, model)
        gaps = [gap_of_balances(one.gap_map, one.gap_map.names, self.train) for one in models]
        return next(
            one for one, gap in zip(models, gaps, strict=True) if gap <= _AS_SMALL * min(gaps)
        )

    def _tolerated(self, names: Iterable[str]) -> list[str]:
        """Return the effects among ``names`` that are nuisances within a tolerance."""
        known = {effect for effect, _ in self.measured.tolerances}
        return [name for name in names if name in known]

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
            _REFUSED.format(*distinct_texts(before**0.5, after**0.5)),
        )

    def _step(
        self, model: LinearisedModel, added: tuple[str, ...]
    ) -> tuple[SearchStep, LinearisedModel | None]:
        """Return a step of the search, and the refitted model if an effect was added."""
        linear = self._linear(model, added)
        in_full = map_on_threads(
            lambda name: self._evaluate_in_full(model, added, name), _promising(linear)
        )
        return self._decided(model, added, _replaced(linear, in_full))

    def _has_gaps(self, model: LinearisedModel) -> bool:
        """Return whether gaps at training points are structured, material and too large."""
        return bool(unexplained_at(model.gap_map, self.train))

    def _step_afresh(
        self, model: LinearisedModel, added: tuple[str, ...], step: SearchStep
    ) -> tuple[SearchStep, LinearisedModel | None]:
        """Return a step from the given values of the nuisances, or ``step`` if it adds nothing."""
        start = self.measured.start
        found = {name: own for name, own in model.hypothesis.effects.items() if name in added}
        fresh = self.linearise_at(model, replace(start, effects={**start.effects, **found}))
        fresh = self.with_columns(fresh, fresh.columns)
        again = self.refit(fresh, added)
        if self._lost(again, model, added, added) > 0:
            model = again

        def fitted(name: str) -> EvaluatedCandidate:
            joined = (*added, name)
            return self._evaluate_at_best(model, self.refit(fresh, joined), added, name)

        best = [each.candidate for each in self._linear(fresh, added)[:_MOST_AFRESH]]
        in_full = map_on_threads(fitted, [each.name for each in best if each.score > 0])
        known = _replaced(step.evaluated, in_full)
        again_step, with_effect = self._decided(model, added, known)
        return (step, None) if with_effect is None else (again_step, with_effect)

    def _step_beside_each(
        self, model: LinearisedModel, added: tuple[str, ...], step: SearchStep
    ) -> tuple[SearchStep, LinearisedModel | None]:
        """Return a step that adds an effect missing beside each rival, or ``step``."""
        names = _names(step.ambiguous)
        first, *others = (
            ((*added, each.candidate.name), self._refitted_with(each, added))
            for each in step.evaluated
            if each.candidate.name in names
        )
        found = self._step(first[1], first[0])[0].added
        if not found or found in names:
            return step, None
        if not all(self._is_missing(rival, joined, found) for joined, rival in others):
            return step, None
        evaluated = self._evaluate_in_full(model, added, found)
        if evaluated.model is None:
            return step, None
        known = _replaced(step.evaluated, [evaluated])
        return SearchStep(model, known, found, ()), self._refitted_with(evaluated, added)

    def _linear(
        self, model: LinearisedModel, added: tuple[str, ...]
    ) -> tuple[EvaluatedCandidate, ...]:
        """Return all candidates, evaluated by their columns, best first."""
        names = [
            name for name in self.candidates if name not in added and model.coefficients_of([name])
        ]
        return _best_first(
            map_on_threads(lambda name: self._evaluate_linearly(model, added, name), names)
        )

    def _decided(
        self,
        model: LinearisedModel,
        added: tuple[str, ...],
        candidates: Sequence[EvaluatedCandidate],
    ) -> tuple[SearchStep, LinearisedModel | None]:
        """Return the step that candidates, best first, give, and the refitted model."""
        evaluated, names = list(candidates), [each.candidate.name for each in candidates]
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
        refitted = {
            each.name: self._refitted_with(accepted[each.name], added) for each in ambiguous
        }
        best, *rivals = refitted
        if not all(
            self._is_missing(refitted[one], (*added, one), other)
            for rival in rivals
            for one, other in ((best, rival), (rival, best))
        ):
            return SearchStep(model, tuple(evaluated), None, ambiguous), None
        return SearchStep(model, tuple(evaluated), best, ()), refitted[best]

    def _refitted_with(
        self, evaluated: EvaluatedCandidate, added: tuple[str, ...]
    ) -> LinearisedModel:
        assert evaluated.model is not None  # it was evaluated in full
        return self.refit(evaluated.model, (*added, evaluated.candidate.name))

    def _is_missing(self, model: LinearisedModel, added: tuple[str, ...], name: str) -> bool:
        """Return whether an effect would be accepted in addition to those of a model.

        Rivals of which each is, with the other one in the model, are both present.
        """
        evaluated = self._evaluate_in_full(model, added, name)
        tested = self._with_threshold(evaluated, added, [name])
        return tested.model is not None and CRITERIA.accepts(tested.candidate)

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


def _names(candidates: Iterable[Candidate]) -> list[str]:
    return [each.name for each in candidates]


def _columns_of(model: LinearisedModel, names: Iterable[str]) -> list[str]:
    """Return the names of the columns that some effects have in a model."""
    return [".".join(which) for which in model.coefficients_of(names)]


def _promising(linear: Sequence[EvaluatedCandidate]) -> list[str]:
    """Return the candidates, best first, whose linear score suffices for an evaluation in full."""
    highest = linear[0].candidate.score if linear else 0.0
    least = max(_LEAST_SHARE * highest, _LEAST_PROMISING * CRITERIA.score)
    names = [each.candidate.name for each in linear if each.candidate.score > least]
    return names[:_MOST_IN_FULL]


def _replaced(
    evaluated: Iterable[EvaluatedCandidate], in_full: Iterable[EvaluatedCandidate]
) -> tuple[EvaluatedCandidate, ...]:
    """Return candidates, best first, with those that were evaluated in full."""
    better = {each.candidate.name: each for each in in_full}
    return _best_first(better.get(each.candidate.name, each) for each in evaluated)


def _best_first(evaluated: Iterable[EvaluatedCandidate]) -> tuple[EvaluatedCandidate, ...]:
    return tuple(ranked(tuple(evaluated), lambda each: each.candidate.score, TIE))
