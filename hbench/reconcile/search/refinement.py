"""What becomes of effects that were added to a model: each is dropped, refined, or left out.

After each addition the earlier effects are evaluated again beside the others. One is dropped where
the refitted model without it loses at most 5 nats in cross-validation, and it no longer meets the
criteria of a candidate about that model. At the end the effects found are refined: refitted with
the nuisances, now with the deviations below what is material, which a search for names leaves out,
and with the shape of each law that cross-validation supports. An effect that is then smaller than
these criteria ask for is left out again. So is one with a coefficient at its bound, and one whose
coefficients together do not differ from 0 (95 %) and without which the refitted model loses at most
5 nats, or deviates no more in runs outside the fit.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hbench.analysis.rounding import distinct_texts
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.acceptance import CRITERIA
from hbench.reconcile.column_names import coefficient_name
from hbench.reconcile.estimates import fit_coefficients
from hbench.reconcile.hypothesis import Hypothesis, shape_coefficients
from hbench.reconcile.linearised import (
    LinearisedModel,
    changed_balances,
    linearise,
    linearise_residuals,
)
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.search.candidates import CandidateEvaluator, EvaluatedCandidate

_AS_SMALL = 1.02  # times the smallest gap; less is no reason to prefer a model


@dataclass(frozen=True)
class EffectRefinement(CandidateEvaluator):
    """Refinement of the effects that were added to a model of a campaign."""

    measured: MeasuredCampaign
    stage: Callable[[str], None] = lambda stage: None  # receives a description of each stage

    def refined_and_named(
        self, model: LinearisedModel, names: tuple[str, ...]
    ) -> tuple[LinearisedModel, dict[str, str]]:
        """Return the refined model, and the effects that it does not need, each with the reason.

        They are left out one at a time, the last added first: of two alike, each may be 0 beside
        the other, and not both.
        """
        ruled_out: dict[str, str] = {}
        while names:
            self.stage(f"refining {', '.join(names)}")
            refined = self.refined(model, names)
            reasons = self._not_needed(refined, names, names)
            if not reasons:
                return refined, ruled_out
            last, reason = reasons.popitem()
            names = tuple(name for name in names if name != last)
            model, ruled_out = self.without(refined, [last], names), ruled_out | {last: reason}
        return model, ruled_out

    def no_longer_errors(self, model: LinearisedModel, names: tuple[str, ...]) -> dict[str, str]:
        """Return the errors of sensors that a model does not need, each with the reason."""
        return self._not_needed(model, names, self._tolerated(names))

    def _not_needed(
        self, model: LinearisedModel, names: tuple[str, ...], which: Iterable[str]
    ) -> dict[str, str]:
        reasons = {name: self._why_not_needed(model, names, name) for name in which}
        return {name: reason for name, reason in reasons.items() if reason}

    def _why_not_needed(self, model: LinearisedModel, names: tuple[str, ...], name: str) -> str:
        """Return why a refined model does not need one of its effects; empty where it does.

        Its size is that of the model or of the linear fit about it, which the diagnosis states: the
        smaller.
        """
        estimates = fit_coefficients(self.measured.plant, model, names, self.train)
        fitted = self._values(model, name, estimates.chosen, estimates.beta)
        both = (self._own_values(model, name), fitted)
        sizes = [self._candidate(name, 0.0, 0.0, each, "full").size for each in both]
        if min(sizes) == 0.0 and self._tolerated([name]):
            return "it is within its tolerance"
        if min(sizes) < CRITERIA.size:
            size, needed = distinct_texts(min(sizes), CRITERIA.size)
            return f"it is too small: {size} of a typical size, {needed} needed"
        if at := self._at_bound(model, name):
            return f"{at} is at its bound, where the law is no longer that of the effect"
        if estimates.may_be_zero(name) and not self._is_needed(model, names, name):
            return "it is not distinguishable from 0, and the model without it is about as good"
        return ""

    def _at_bound(self, model: LinearisedModel, name: str) -> str:
        """Return a coefficient of an effect that is as large as the catalogue allows, if any is."""
        for (_, key), value in self._own_values(model, name).items():
            row = EFFECTS[name].coefficients[key]
            bounds = [each for each in (row.low, row.high) if each != row.default]
            if row.typical and any(np.isclose(value, row.to_si(b), atol=0.0) for b in bounds):
                return key
        return ""

    def _is_needed(self, model: LinearisedModel, names: tuple[str, ...], name: str) -> bool:
        """Return whether the refitted model without one of its effects is clearly worse.

        It loses over 5 nats, and leaves a gap outside the fit in the balances of this effect, which
        the effect reduces. Levels of friction do not count there as far as they may wander.
        """
        others = tuple(each for each in names if each != name)
        without = self.without(model, [name], others)
        if self._lost(model, without, names, others) <= CRITERIA.score:
            return False
        out = np.setdiff1d(np.arange(len(model.gap_map.points)), self.train)
        if not len(out):
            return True
        gaps = [each.gap_map.without_levels() for each in (without, model)]
        balances = changed_balances(gaps[0], model, name, out)
        before, after = (each.gap(balances, out) for each in gaps)
        return before > max(after, 1.0)

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
            if not self.criteria.accepts(evaluated.candidate):
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
        return float(before.gains_over(after)[0].sum())

    def _hypothesis_without(self, model: LinearisedModel, removed: Sequence[str]) -> Hypothesis:
        """Return a model's hypothesis with some effects at their start."""
        kept = {key: c for key, c in model.hypothesis.effects.items() if key not in removed}
        start = {k: c for k, c in self.measured.start.effects.items() if k in removed}
        return replace(model.hypothesis, effects=kept | start)

    def refined(self, model: LinearisedModel, names: tuple[str, ...]) -> LinearisedModel:
        """Return the model with effects ``names`` and their shapes refitted to all deviations.

        Deviations too small to matter can help to determine an effect. Where the law of another
        effect is wrong, fitting them can also enlarge those that matter. Three models are therefore
        compared by the gap of the training points: the refined one (``fine``), the same with its
        nuisances refitted to what matters alone (``settled``), and ``model``. The first whose gap
        is at most 2 % above the smallest is returned.
        """
        best = self._refitted_to_all(model, names)
        fine = linearise(self.measured, best.hypothesis, best.columns, model.gap_map)
        settled = self.refit(fine, self._tolerated(names), renewed=())
        models = (fine, settled, model)
        gaps = [each.gap_map.gap(each.gap_map.names, self.train) for each in models]
        return next(
            each for each, gap in zip(models, gaps, strict=True) if gap <= _AS_SMALL * min(gaps)
        )

    def _refitted_to_all(self, model: LinearisedModel, names: tuple[str, ...]) -> LinearisedModel:
        """Return the model refitted to all deviations, with the shapes that predict better.

        All columns are computed at ``model`` first: with those of the model without an effect no
        step may be better. Those of the nuisances then stay, as refinement changes them little.
        """
        taking_part = [model.data.names[i] for i in model.index(names)]
        residuals = replace(model.gap_map, material=np.zeros(len(model.gap_map.names)))
        columns = {key: model.columns[key] for key in taking_part}
        start = linearise_residuals(self.measured, model.hypothesis, residuals, columns)
        start = self.with_columns(start, taking_part)
        best = self.refit(start, names, _columns_of(start, names))
        for name in names:
            shapes = map(coefficient_name, shape_coefficients(name))
            if new := [shape for shape in shapes if shape not in best.columns]:
                shaped = self.with_columns(best, new)
                shaped = self.refit(shaped, names, _columns_of(shaped, names))
                if self._lost(shaped, best, names, names) > 0:
                    best = shaped
        return best

    def _tolerated(self, names: Iterable[str]) -> list[str]:
        """Return the effects among ``names`` that are nuisances within a tolerance."""
        known = {effect for effect, _ in self.measured.tolerances}
        return [name for name in names if name in known]

    def _with_threshold(
        self, evaluated: EvaluatedCandidate, added: tuple[str, ...], names: Sequence[str]
    ) -> EvaluatedCandidate:
        """Return a candidate with the threshold of its score, if it could be accepted.

        Null data sets are the residuals at its own coefficients with random signs, without the
        part that it explains.
        """
        candidate, model = evaluated.candidate, evaluated.model
        if model is None or not self.criteria.accepts(candidate):
            return evaluated
        balances = set(EFFECTS[candidate.name].balances)
        family = [name for name in names if balances.issuperset(EFFECTS[name].balances)]
        null = model.about_itself([candidate.name])
        threshold = self.null_threshold(null, added, family, candidate.score, families=len(names))
        return replace(evaluated, candidate=replace(candidate, threshold=threshold))


def _columns_of(model: LinearisedModel, names: Iterable[str]) -> list[str]:
    """Return the names of the columns that some effects have in a model."""
    return list(map(coefficient_name, model.coefficients_of(names)))
