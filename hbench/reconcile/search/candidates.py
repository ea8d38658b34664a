"""Candidate effects: evaluation by their columns or in full.

The searches in campaigns (``campaign_search.py``) and in imported strokes (``strokes/``) share this
evaluation.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from hbench.model.effects.catalogue import EFFECTS, lookalikes
from hbench.parallel.threads import map_on_threads
from hbench.reconcile.acceptance import CRITERIA, AcceptanceCriteria, score_to_exceed
from hbench.reconcile.column_names import CoefficientKey, coefficient_name
from hbench.reconcile.evidence.cross_validation import Comparison, CrossValidation
from hbench.reconcile.evidence.likelihood import Fit
from hbench.reconcile.evidence.window_sums import STEADY, is_change, is_level
from hbench.reconcile.hypothesis import (
    effect_coefficients,
    shape_coefficients,
    typical_size,
)
from hbench.reconcile.linearised import LinearisedModel
from hbench.reconcile.search.refits import SHORTER, Refits
from hbench.records import Candidate

_FULL_ROUNDS = 3  # of a candidate, with the columns of the model without it


@dataclass(frozen=True)
class EvaluatedCandidate:
    """Candidate effect, with the model at its fitted coefficients if it was tried there."""

    candidate: Candidate
    model: LinearisedModel | None


@dataclass(frozen=True)
class CandidateEvaluator(Refits):
    """Evaluation of candidate effects on one set of measurements."""

    candidates: tuple[str, ...]
    criteria: AcceptanceCriteria = field(default=CRITERIA, kw_only=True)

    def _evaluate_linearly(
        self, model: LinearisedModel, added: tuple[str, ...], name: str
    ) -> EvaluatedCandidate:
        joined = (*added, name)
        gain = self._promise(model, added, name)
        chosen, beta = model.index(joined), self._fit(model, joined)
        values = self._values(model, name, chosen, beta)
        before, after = (self._cross_validate(model, effects) for effects in (added, joined))
        share = explained_share(name, model, before, after, self._squares(model, values))
        return EvaluatedCandidate(self._candidate(name, gain, share, values, "linear"), None)

    def _promise(self, model: LinearisedModel, added: Sequence[str], name: str) -> float:
        """Return a candidate's linear score: the largest of four gains.

        They are those of the windows' values, of the changes between windows, of both, and of the
        levels of runs. A large effect is far from linear, and the error of its columns shows in the
        changes, which are small. A law of another form than the bench's can explain the levels of
        runs while it errs at every start and stop.
        """
        comparison = self._comparison(model, added, name)
        groups, gains = comparison.gains()
        change = np.array([is_change(model.data.groups[g][1]) for g in groups], bool)
        levels = np.flatnonzero([is_level(kind) for _, kind in model.data.groups])
        of_levels = comparison.gains(within=levels)[1]
        parts = (gains[0, change], gains[0, ~change], gains[0], of_levels[0])
        return max(float(part.sum()) for part in parts)

    def score_of(
        self,
        model: LinearisedModel,
        added: Sequence[str],
        name: str,
        signs: np.ndarray | None,
    ) -> np.ndarray:
        """Return a candidate's score (b,) about a model, or its scores on nulls."""
        return self._comparison(model, added, name).score(signs)

    def null_threshold(
        self,
        model: LinearisedModel,
        added: Sequence[str],
        family: Sequence[str],
        score: float,
        families: int,
    ) -> float:
        """Return what a ``score`` must exceed: the threshold of the ``family`` of candidates.

        Null data sets are the residuals of ``model`` with random signs.
        """

        def scores(signs: np.ndarray) -> list[np.ndarray]:
            return map_on_threads(lambda name: self.score_of(model, added, name, signs), family)

        return score_to_exceed(score, scores, len(model.gap_map.points), families)

    def _comparison(self, model: LinearisedModel, added: Sequence[str], name: str) -> Comparison:
        """Return the comparison of the fits without and with a candidate."""
        joined = (*added, name)
        return Comparison(
            model.data,
            Fit(model.index(added), model.priors(added)),
            Fit(model.index(joined), model.priors(joined)),
            [model.column(which) for which in model.coefficients_of([name])],
            self.train,
        )

    def _values(
        self, model: LinearisedModel, name: str, chosen: Sequence[int], beta: np.ndarray
    ) -> dict[CoefficientKey, float]:
        """Return an effect's coefficients [SI] after steps ``beta`` (c,) of columns ``chosen``."""
        steps = dict(zip(chosen, beta.tolist(), strict=True))
        return {
            which: model.hypothesis.coefficient(which)
            + steps[model.column(which)] * typical_size(which)
            for which in model.coefficients_of([name])
        }

    def _own_values(self, model: LinearisedModel, name: str) -> dict[CoefficientKey, float]:
        """Return an effect's coefficients [SI] in a model."""
        return {
            which: model.hypothesis.coefficient(which) for which in model.coefficients_of([name])
        }

    def _evaluate_in_full(
        self, model: LinearisedModel, added: tuple[str, ...], name: str
    ) -> EvaluatedCandidate:
        """Evaluate a candidate at its fitted coefficients, and with its shape where that helps."""
        best = self._evaluate_at_best(model, model, added, name)
        shapes = list(map(coefficient_name, shape_coefficients(name)))
        if shapes and best.model is not None and best.candidate.score > 0:
            shaped = self.with_columns(best.model, shapes)
            if best.candidate.explained <= CRITERIA.explained:  # another form may explain far more
                shaped = self.refit(shaped, (*added, name))
            with_shape = self._evaluate_at_best(model, shaped, added, name)
            if with_shape.candidate.score > best.candidate.score + CRITERIA.score:
                return with_shape
        return best

    def _evaluate_at_best(
        self, model: LinearisedModel, start: LinearisedModel, added: tuple[str, ...], name: str
    ) -> EvaluatedCandidate:
        """Evaluate a candidate about ``model`` at the best steps from ``start``.

        Where no step is better, its values are those of the linear fit.
        """
        joined = (*added, name)
        before, with_effect = self._cross_validate(model, added), start
        for _ in range(_FULL_ROUNDS):
            better, _ = self._better(with_effect, joined, SHORTER)
            if better is with_effect:
                break
            with_effect = better
        candidate = self._assess(model, before, with_effect, joined)
        evaluated = EvaluatedCandidate(candidate, with_effect)
        if candidate.score > CRITERIA.score and candidate.explained <= CRITERIA.explained:
            evaluated = self._refitted_candidate(model, added, evaluated)
        if evaluated.model is start:
            values = self._values(start, name, start.index(joined), self._fit(start, joined))
            at_fit = self._candidate(
                name, candidate.score, candidate.explained, values, candidate.tried
            )
            evaluated = EvaluatedCandidate(at_fit, start)
        return evaluated

    def _refitted_candidate(
        self, model: LinearisedModel, added: tuple[str, ...], evaluated: EvaluatedCandidate
    ) -> EvaluatedCandidate:
        """Return a candidate refitted with columns at its coefficients, if its score is higher.

        Laws are not linear: there it may explain more, or be larger.
        """
        assert evaluated.model is not None
        joined = (*added, evaluated.candidate.name)
        refitted = self.refit(evaluated.model, joined)
        candidate = self._assess(model, self._cross_validate(model, added), refitted, joined)
        better = candidate.score > evaluated.candidate.score
        return EvaluatedCandidate(candidate, refitted) if better else evaluated

    def _assess(
        self,
        model: LinearisedModel,
        before: CrossValidation,
        with_effect: LinearisedModel,
        joined: tuple[str, ...],
    ) -> Candidate:
        """Assess the last of the effects ``joined`` at its coefficients in ``with_effect``.

        ``before`` is the cross-validation of ``model``, which has the others.
        """
        name = joined[-1]
        after = self._cross_validate(with_effect, joined)
        gain = float(after.gains_over(before)[0].sum())
        values = self._own_values(with_effect, name)
        squares = self._squares(with_effect, values)
        share = explained_share(name, model, before, after, squares)
        if is_constant_force(name) and not self._shows_in_steady_motion(model, joined[:-1], name):
            share = 0.0
        return self._candidate(name, gain, share, values, "full")

    def _shows_in_steady_motion(
        self, model: LinearisedModel, added: Sequence[str], name: str
    ) -> bool:
        """Return whether an effect gains in steady motion alone, with nuisances fitted to it.

        Where offsets within their tolerance explain the same there, what remains are starts and
        reversals, in which another law of friction does as much. True where no offset is fitted.
        """
        if ("load_cell_offset", "force") not in self.measured.tolerances:
            return True
        steady = np.flatnonzero([kind in STEADY for _, kind in model.data.groups])
        gains = self._comparison(model, added, name).gains(within=steady)[1]
        return float(gains.sum()) > CRITERIA.score

    def _squares(
        self, model: LinearisedModel, values: Mapping[CoefficientKey, float]
    ) -> np.ndarray:
        """Return the sums of squares (g,) that coefficients of an effect make of its columns."""
        beta = np.zeros((1, len(model.data.names)))
        for which, value in values.items():
            if which in effect_coefficients(which[0]):
                beta[0, model.column(which)] = value / typical_size(which)
        whole = model.data.part(self.train)
        return model.data.summed_columns(whole).squares(beta[None])[0, 0]

    def _candidate(
        self,
        name: str,
        gain: float,
        share: float,
        values: Mapping[CoefficientKey, float],
        tried: Literal["full", "linear"],
    ) -> Candidate:
        """Return a candidate; its size is the largest of its values over their typical sizes.

        One within its tolerance has the size 0. So has one that needs several sensors beyond their
        tolerances where the effect is that of one: linear fits have such values.
        """
        limits = self.measured.tolerances
        sizes = {w: abs(value) for w, value in values.items() if w in effect_coefficients(name)}
        beyond = sum(value > limits.get(which, 0.0) for which, value in sizes.items())
        largest = max((value / typical_size(which) for which, value in sizes.items()), default=0.0)
        parameters = {key: value for (_, key), value in values.items()}
        size = largest if beyond and (beyond == 1 or not EFFECTS[name].alone) else 0.0
        return Candidate(name, gain, share, size, parameters, tried, CRITERIA.score)


def is_constant_force(name: str) -> bool:
    """Return whether an effect acts in steady motion like an offset of the load cell.

    An effect of a sensor does not count: it is such an error itself.
    """
    return not EFFECTS[name].of_sensor and "load_cell_offset" in lookalikes(name)


def explained_share(
    name: str,
    model: LinearisedModel,
    before: CrossValidation,
    after: CrossValidation,
    squares: np.ndarray,
) -> float:
    """Return the share of the excess gap that an effect explains in the balances it changes.

    The share of the values, of the changes between windows or of the levels of runs, the largest:
    an effect that acts for a moment is a small part of the values, and of one that differs from run
    to run little is left in the windows without the levels. It is that of all balances, or the mean
    of the balances of which the effect's own ``squares`` (g,) are enough to explain a quarter: the
    excess of another balance may be that of a far larger effect.
    """
    columns = [model.column(which) for which in model.coefficients_of([name])]
    changed = np.flatnonzero(model.data.columns.nonzero[:, columns].any(axis=1))
    balances = {model.data.groups[i][0] for i in changed}
    balance = np.array([each for each, _ in model.data.groups])
    change = np.array([is_change(kind) for _, kind in model.data.groups])
    level = np.array([is_level(kind) for _, kind in model.data.groups])
    excess, left = _excess(before), _excess(after)

    def shares(kinds: np.ndarray) -> Iterator[float]:
        every = kinds & np.isin(balance, list(balances))
        yield _share(excess[every].sum(), left[every].sum())
        own = [kinds & (balance == each) for each in balances]
        large = [g for g in own if squares[g].sum() > CRITERIA.explained * excess[g].sum() > 0]
        if large:
            yield float(np.mean([_share(excess[g].sum(), left[g].sum()) for g in large]))

    return float(max((*shares(~change), *shares(change), *shares(level))))


def _share(total: float, left: float) -> float:
    return 1 - left / total if total > 0 else 0.0


def _excess(prediction: CrossValidation) -> np.ndarray:
    """Return the sums of squares (g,) above those of the noise."""
    above_noise = np.maximum(prediction.variance[0] - prediction.noise, 0.0)
    return above_noise * prediction.windows
