"""Search for effects of the catalogue that a model does not contain, one after another.

Each candidate is first evaluated about the refitted model by its columns (``Comparison.score``).
The best are then evaluated in full, at their fitted coefficients. An effect is added if, by
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

What becomes of added effects is ``refinement.py``. An ambiguous set that was found beside an
effect that is then ruled out is searched again without this effect.
"""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.rounding import distinct_texts, ranked
from hbench.parallel.threads import map_on_threads
from hbench.reconcile.acceptance import CRITERIA, SMALL, TIE, indistinguishable, may_be_rival
from hbench.reconcile.gaps.gap_map import GapMap
from hbench.reconcile.gaps.log_map import unexplained_at
from hbench.reconcile.hypothesis import coefficient_names, typical_size
from hbench.reconcile.linearised import LinearisedModel, linearise
from hbench.reconcile.search.candidates import EvaluatedCandidate
from hbench.reconcile.search.refinement import EffectRefinement
from hbench.reconcile.search.refits import NEGLIGIBLE_GAIN
from hbench.reconcile.search_result import SearchResult, SearchStep, SmallEffects, added_names
from hbench.reconcile.separation.separability import Separation
from hbench.records import Candidate

_MOST_IN_FULL = 6  # candidates
_MOST_AFRESH = 3  # candidates; their columns are far from the fit, so a score says little
_LEAST_PROMISING = 0.5  # of the least threshold; candidates below are not evaluated in full
_MOST_EFFECTS = 4
_REFUSED = (
    "Refitting the poorly known values of the model would increase the gap of the held-out runs "
    "from {} to {}, so the values of the model file are kept."
)


@dataclass(frozen=True)
class CampaignSearch(EffectRefinement):
    """Search in the runs of a campaign."""

    def run(self) -> SearchResult:
        """Refit the nuisances of the given model, then search for effects."""
        self.stage("refitting the poorly known values of the model")
        given, refitted, refused = self._refitted()
        refitted = self._with_candidates(refitted)
        current, steps = self._searched(refitted, (), ())
        final, ruled_out = self.refined_and_named(current, added_names(steps))
        search, gone = self, ruled_out
        while gone and steps[-1].ambiguous:  # the set was found beside an effect that is not there
            self.stage(f"searching again without {', '.join(gone)}")
            left = tuple(name for name in search.candidates if name not in gone)
            search = replace(search, candidates=left)
            final = search._with_candidates(final)
            current, steps = search._searched(final, steps[:-1], ruled_out)
            final, gone = search.refined_and_named(current, added_names(steps, ruled_out))
            ruled_out = ruled_out | gone
        return SearchResult(given, refitted, steps, final, refused, ruled_out=ruled_out)

    def _searched(
        self,
        model: LinearisedModel,
        known: Sequence[SearchStep],
        ruled_out: Collection[str],
    ) -> tuple[LinearisedModel, tuple[SearchStep, ...]]:
        """Return the model with all effects that are found, and the steps after the ``known``."""
        current, steps = model, list(known)
        while len(steps) < _MOST_EFFECTS:
            added = added_names(steps, ruled_out)
            so_far = f" beside {', '.join(added)}" if added else ""
            self.stage(f"searching for an effect{so_far} among {len(self.candidates)} candidates")
            step, with_effect = self._step(current, added)
            if so_far and not (step.added or step.ambiguous) and self._has_gaps(current):
                self.stage(f"searching again from the given values{so_far}")
                step, with_effect = self._step_afresh(current, added, step)
            if step.ambiguous and len(steps) < _MOST_EFFECTS - 1:
                self.stage(f"searching beside each of {', '.join(_names(step.ambiguous))}")
                step, with_effect = self._step_beside_each(current, added, step)
            if with_effect is None:
                steps.append(step)
                break
            joined = added_names([*steps, step], ruled_out)
            current, dropped = self.without_superfluous(with_effect, joined)
            steps.append(replace(step, dropped=dropped))
        return current, tuple(steps)

    def _with_candidates(self, model: LinearisedModel) -> LinearisedModel:
        """Return a model with the columns of all candidates."""
        wanted = coefficient_names(self.candidates)
        return self.with_columns(model, [name for name in wanted if name not in model.columns])

    def small_effects(self, model: LinearisedModel) -> SmallEffects | None:
        """Return effects too small to be named with which a model has no unexplained gap.

        None where there are none, and where the model has no unexplained gap without them.
        """
        every, current = np.arange(len(model.gap_map.points)), self._with_candidates(model)
        search, steps = replace(self, criteria=SMALL), list[SearchStep]()
        while unexplained_at(current.gap_map, every):
            self.stage("searching for effects that are too small to be named")
            step, with_effect = search._step(current, added_names(steps))
            if with_effect is None or len(steps) == _MOST_EFFECTS:
                return None
            if step.added_size >= CRITERIA.size:  # it is not named for another reason
                return None
            steps.append(step)
            current = with_effect
        return SmallEffects(current, tuple(steps)) if steps else None

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
        if refitted is first:  # no step is better with the columns at the given model
            renewed = self.refit(self.with_columns(first, first.columns), ())
            if self._cost(renewed, ()) < self._cost(first, ()) - NEGLIGIBLE_GAIN:
                refitted = renewed
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
        accepted: list[EvaluatedCandidate] = []
        for i, each in enumerate(evaluated):
            if i == 0:
                each = self._refitted_if_small(model, added, each)
            if accepted and not may_be_rival(each.candidate, accepted[0].candidate):
                continue
            if accepted and each.model is None and self.criteria.accepts(each.candidate):
                each = self._evaluate_in_full(model, added, each.candidate.name)
            evaluated[i] = tested = self._with_threshold(each, added, names)
            if tested.model and self.criteria.accepts(tested.candidate):
                accepted.append(tested)
        if not accepted:
            return SearchStep(model, tuple(evaluated), None, ()), None
        evaluated, accepted = list(_best_first(evaluated)), list(_best_first(accepted))
        ambiguous = indistinguishable(
            [each.candidate for each in accepted], self._alike(accepted, added)
        )
        refitted = {
            each.candidate.name: self._refitted_with(each, added)
            for each in accepted
            if each.candidate in ambiguous
        }
        best, *rivals = refitted
        if not all(
            self._is_missing(refitted[one], (*added, one), other)
            for rival in rivals
            for one, other in ((best, rival), (rival, best))
        ):
            return SearchStep(model, tuple(evaluated), None, ambiguous), None
        return SearchStep(model, tuple(evaluated), best, ()), refitted[best]

    def _refitted_if_small(
        self, model: LinearisedModel, added: tuple[str, ...], best: EvaluatedCandidate
    ) -> EvaluatedCandidate:
        """Return the best candidate, refitted where nothing but its size is too small."""
        too_small = SMALL.accepts(best.candidate) and not CRITERIA.accepts(best.candidate)
        return self._refitted_candidate(model, added, best) if too_small and best.model else best

    def _alike(
        self, accepted: Sequence[EvaluatedCandidate], added: tuple[str, ...]
    ) -> tuple[str, ...]:
        """Return the accepted candidates that the runs hardly distinguish from the first one."""
        best, *rivals = accepted
        if best.model is None or not rivals:
            return ()
        name, model = best.candidate.name, best.model.about_itself([best.candidate.name])
        causes = np.zeros((1, len(model.data.names)))
        for which in model.coefficients_of([name]):
            causes[0, model.column(which)] = model.hypothesis.coefficient(which) / typical_size(
                which
            )
        others = [each.candidate.name for each in rivals]
        leads = Separation(model, self.train, added).leads({name: causes}, others)
        return tuple(rival for (_, rival), lead in leads.items() if not lead.distinguishable)

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
        return tested.model is not None and self.criteria.accepts(tested.candidate)


def _mean_square(residuals: GapMap, points: np.ndarray) -> float:
    """Return the mean square of the residuals at some operating points, in scatters."""
    chosen = residuals.select_points(points)
    return float(np.nanmean((chosen.difference / chosen.scatter) ** 2))


def _names(candidates: Iterable[Candidate]) -> list[str]:
    return [each.name for each in candidates]


def _promising(linear: Sequence[EvaluatedCandidate]) -> list[str]:
    """Return the candidates, best first, whose linear score suffices for an evaluation in full."""
    least = _LEAST_PROMISING * CRITERIA.score
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
