"""Candidate effects: evaluation by their columns or in full, and acceptance.

The searches in campaigns (``campaign_search.py``) and in imported strokes (``strokes/``) share this
evaluation.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hbench.model.effects.catalogue import EFFECTS
from hbench.parallel.threads import map_on_threads
from hbench.reconcile.evidence import (
    Comparison,
    CrossValidation,
    Fit,
    cost,
    cross_validate,
    log_likelihood,
    maximum_likelihood,
    random_signs,
)
from hbench.reconcile.hypothesis import (
    CoefficientKey,
    Hypothesis,
    effect_coefficients,
    shape_coefficients,
    typical_size,
)
from hbench.reconcile.linearised import (
    LinearisedModel,
    Measured,
    hypothesis_at,
    linearise_residuals,
)
from hbench.reconcile.window_sums import is_change
from hbench.records import Candidate
from hbench.records.diagnosis import LEAST_EXPLAINED, LEAST_SIZE

TIE = 1e-6  # nats: candidates whose scores differ by rounding keep the catalogue's order
NULLS = 50  # random null data sets
_FEW_NULLS = 10  # suffice where a score is far above the threshold that they give
_FAR = 3.0  # times this threshold
_FALSE = 0.05  # probability that a round of a search accepts an effect where none is missing
_AMBIGUOUS_NATS, _AMBIGUOUS_SHARE = 3.0, 0.1  # of the best score; the larger one counts
_REFIT_ROUNDS = 16  # steps, or new columns
_FULL_ROUNDS = 3  # of a candidate, with the columns of the model without it
_NEGLIGIBLE_STEP = 0.02  # priors of nuisances and typical sizes; no new evaluation below
# Radius of a step's damping, in priors of nuisances and typical sizes, and shares of the step.
_SHORTER = ((np.inf, (1.0, 0.5, 0.25)),)
_DAMPED = tuple((radius, (1.0,)) for radius in (1.0, 0.3, 0.1))
_NEGLIGIBLE_GAIN = 0.5  # nats of a step, a tenth of what an effect must gain; it is the last one


@dataclass(frozen=True)
class AcceptanceCriteria:
    """Least score, explained share and size of an effect that may be added to a model."""

    score: float  # nats: least threshold
    explained: float  # share of the excess gap in the balances that the effect touches
    size: float  # largest coefficient, in typical sizes

    def threshold(self, null_scores: np.ndarray, families: int) -> float:
        """Return the score to exceed.

        ``null_scores`` (n,) are the largest scores of a family of candidates on null data sets. A
        further one exceeds the threshold with a probability of 5 % divided by the number of
        ``families`` in a round (Bonferroni). The tail above the median is taken as exponential, as
        that of a gain in ln L is (Wilks); with k scores above it the predictive distribution is
        P(excess > t) = (1 + t / (k mean))^-k.
        """
        median = float(np.median(null_scores))
        above = null_scores[null_scores > median] - median
        if not len(above):
            return self.score
        odds = (0.5 * families / _FALSE) ** (1 / len(above))
        return max(self.score, median + float(above.sum()) * (odds - 1))

    def accepts(self, candidate: Candidate) -> bool:
        """Return whether a candidate exceeds its own threshold and meets the other criteria."""
        return (
            candidate.score > candidate.threshold
            and candidate.explained > self.explained
            and candidate.size >= self.size
        )


# 5 nats are odds of 150 to 1. A quarter is enough: the remainder may be other effects.
CRITERIA = AcceptanceCriteria(score=5.0, explained=LEAST_EXPLAINED, size=LEAST_SIZE)


def ambiguity_margin(best: float) -> float:
    """Return the distance [nats] from the ``best`` score within which scores are close to it."""
    return max(_AMBIGUOUS_NATS, _AMBIGUOUS_SHARE * best)


def is_close(candidate: Candidate, best: Candidate) -> bool:
    """Return whether a candidate's score is close to that of the ``best`` one."""
    return candidate.score >= best.score - ambiguity_margin(best.score)


def indistinguishable(accepted: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Return the candidates whose scores are close to that of the first, the best one.

    An effect on other balances is no rival: it explains something else.
    """
    best = accepted[0]
    balances = set(EFFECTS[best.name].balances)
    return tuple(
        each
        for each in accepted
        if is_close(each, best) and not balances.isdisjoint(EFFECTS[each.name].balances)
    )


def score_to_exceed(
    score: float,
    scores_on_nulls: Callable[[np.ndarray], Sequence[np.ndarray]],
    points: int,
    families: int,
) -> float:
    """Return what a ``score`` must exceed: the threshold of a family of candidates.

    ``scores_on_nulls`` returns the scores (b,) of each candidate for random signs (b, ``points``).
    """
    signs = random_signs(NULLS, points, seed=1)
    for few in (signs[:_FEW_NULLS], signs):
        largest = np.max(scores_on_nulls(few), axis=0, initial=0.0)
        threshold = CRITERIA.threshold(largest, families)
        if score > _FAR * threshold:
            break
    return threshold


@dataclass(frozen=True)
class EvaluatedCandidate:
    """Candidate effect, with the model at its fitted coefficients if it was tried there."""

    candidate: Candidate
    model: LinearisedModel | None


@dataclass(frozen=True)
class CandidateEvaluator:
    """Evaluation of candidate effects on one set of measurements."""

    measured: Measured
    train: np.ndarray  # indices of the operating points in use
    candidates: tuple[str, ...]

    def linearise_at(self, start: LinearisedModel, hypothesis: Hypothesis) -> LinearisedModel:
        """Return the model at a hypothesis, with the columns of ``start``."""
        residuals = self.measured.gap_map(hypothesis, start.gap_map)
        return linearise_residuals(self.measured, hypothesis, residuals, start.columns, start.data)

    def with_columns(self, model: LinearisedModel, names: Iterable[str]) -> LinearisedModel:
        """Return a model with the columns ``names`` computed at its hypothesis."""
        columns = {**model.columns, **self.measured.columns(model.hypothesis, names)}
        return linearise_residuals(self.measured, model.hypothesis, model.gap_map, columns)

    def refit(
        self,
        start: LinearisedModel,
        effects: Sequence[str],
        renewed: Sequence[str] | None = None,
    ) -> LinearisedModel:
        """Refit the nuisances and the coefficients of ``effects``; never return a worse model.

        The columns ``renewed``, by default all that take part, are computed again once they gain
        no more: a step costs far less than its columns.
        """
        chosen = start.index(effects)
        names = [start.data.names[i] for i in chosen] if renewed is None else renewed
        current, stale = start, False
        for _ in range(_REFIT_ROUNDS):
            better = self._better(current, effects, _SHORTER + _DAMPED)
            gain = self._cost(current, effects) - self._cost(better, effects)
            current = better
            if gain >= _NEGLIGIBLE_GAIN:
                stale = True
            elif not stale:
                break
            else:
                current, stale = self.with_columns(current, names), False
        return self.with_columns(current, names) if stale else current

    def _better(
        self,
        current: LinearisedModel,
        effects: Sequence[str],
        steps: Sequence[tuple[float, Sequence[float]]],
    ) -> LinearisedModel:
        """Return the model at a better step from ``current``; the same model where none is.

        The balances are not linear: where the whole step is not better, shorter ones are tried, and
        then damped ones, which leave alone what the data hardly determine.
        """
        chosen, before = current.index(effects), self._cost(current, effects)
        for radius, shares in steps:
            beta = self._fit(current, effects, radius)
            for share in shares:
                if np.abs(share * beta).max(initial=0.0) < _NEGLIGIBLE_STEP:
                    return current
                hypothesis = hypothesis_at(current, self.measured.plant, chosen, share * beta)
                model = self.linearise_at(current, hypothesis)
                if self._cost(model, effects) < before:
                    return model
        return current

    def _fit(
        self, model: LinearisedModel, effects: Sequence[str], radius: float = np.inf
    ) -> np.ndarray:
        """Return the most likely steps of the columns of ``model.index(effects)``."""
        priors = model.priors(effects).damped(radius)
        return maximum_likelihood(model.data, priors, model.index(effects), self.train)[0]

    def _cost(self, model: LinearisedModel, effects: Sequence[str]) -> float:
        return cost(model.data, model.priors(effects), model.index(effects), self.train)

    def _cross_validate(self, model: LinearisedModel, effects: Sequence[str]) -> CrossValidation:
        return cross_validate(model.data, model.priors(effects), model.index(effects), self.train)

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
        """Return a candidate's linear score: of values, changes or both, whichever is the largest.

        A large effect is far from linear, and its error shows in changes, which are small.
        """
        groups, gains = self._comparison(model, added, name).gains()
        change = np.array([is_change(model.data.groups[g][1]) for g in groups], bool)
        return max(float(gains[0, part].sum()) for part in (change, ~change, change | ~change))

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
        steps = dict(zip(chosen, beta.tolist(), strict=True))
        return {
            which: model.hypothesis.coefficient(which)
            + steps[model.column(which)] * typical_size(which)
            for which in model.coefficients_of([name])
        }

    def _own_values(self, model: LinearisedModel, name: str) -> dict[CoefficientKey, float]:
        return {
            which: model.hypothesis.coefficient(which) for which in model.coefficients_of([name])
        }

    def _evaluate_in_full(
        self, model: LinearisedModel, added: tuple[str, ...], name: str
    ) -> EvaluatedCandidate:
        """Evaluate a candidate at its fitted coefficients, and with its shape where that helps."""
        best = self._evaluate_at_best(model, model, added, name)
        shapes = [".".join(which) for which in shape_coefficients(name)]
        if shapes and best.model is not None and best.candidate.score > 0:
            shaped = self.with_columns(best.model, shapes)
            with_shape = self._evaluate_at_best(model, shaped, added, name)
            if with_shape.candidate.score > best.candidate.score + CRITERIA.score:
                return with_shape
        return best

    def _evaluate_at_best(
        self, model: LinearisedModel, start: LinearisedModel, added: tuple[str, ...], name: str
    ) -> EvaluatedCandidate:
        joined = (*added, name)
        before, with_effect = self._cross_validate(model, added), start
        for _ in range(_FULL_ROUNDS):
            better = self._better(with_effect, joined, _SHORTER)
            if better is with_effect:
                break
            with_effect = better
        candidate = self._judged(model, before, with_effect, joined)
        if candidate.score > CRITERIA.score and candidate.explained <= CRITERIA.explained:
            # a large effect is far from linear: with columns at its coefficients it explains more
            with_effect = self.refit(with_effect, joined)
            candidate = self._judged(model, before, with_effect, joined)
        if with_effect is start:  # no step is better: what is known is the linear fit
            values = self._values(start, name, start.index(joined), self._fit(start, joined))
            candidate = self._candidate(
                name, candidate.score, candidate.explained, values, candidate.tried
            )
        return EvaluatedCandidate(candidate, with_effect)

    def _judged(
        self,
        model: LinearisedModel,
        before: CrossValidation,
        with_effect: LinearisedModel,
        joined: tuple[str, ...],
    ) -> Candidate:
        """Return the last of the effects ``joined`` at its coefficients in ``with_effect``."""
        name = joined[-1]
        after = self._cross_validate(with_effect, joined)
        gain = float((log_likelihood(after) - log_likelihood(before))[0])
        values = self._own_values(with_effect, name)
        squares = self._squares(with_effect, values)
        share = explained_share(name, model, before, after, squares)
        return self._candidate(name, gain, share, values, "full")

    def _squares(
        self, model: LinearisedModel, values: Mapping[CoefficientKey, float]
    ) -> np.ndarray:
        """Return the sums of squares (g,) that coefficients of an effect make of its columns."""
        beta = np.zeros((1, len(model.data.names)))
        for which, value in values.items():
            if which in effect_coefficients(which[0]):
                beta[0, model.column(which)] = value / typical_size(which)
        return model.data.summed_columns(self.train).squares(beta)[0]

    def _candidate(
        self,
        name: str,
        gain: float,
        share: float,
        values: Mapping[CoefficientKey, float],
        tried: Literal["full", "linear"],
    ) -> Candidate:
        """Return a candidate; one within its tolerance has the size 0."""
        limits = self.measured.tolerances
        sizes = {w: abs(value) for w, value in values.items() if w in effect_coefficients(name)}
        beyond = any(value > limits.get(which, 0.0) for which, value in sizes.items())
        largest = max((value / typical_size(which) for which, value in sizes.items()), default=0.0)
        parameters = {key: value for (_, key), value in values.items()}
        size = largest if beyond else 0.0
        return Candidate(name, gain, share, size, parameters, tried, CRITERIA.score)


def explained_share(
    name: str,
    model: LinearisedModel,
    before: CrossValidation,
    after: CrossValidation,
    squares: np.ndarray,
) -> float:
    """Return the share of the excess gap that an effect explains in the balances it changes.

    The share of the values or that of the changes between windows, whichever is larger: an effect
    that acts for a moment is a small part of the values. It is that of all balances, or the mean
    of the balances of which the effect's own ``squares`` (g,) are enough to explain a quarter: the
    excess of another balance may be that of a far larger effect.
    """
    columns = [model.column(which) for which in model.coefficients_of([name])]
    changed = np.flatnonzero(model.data.columns.nonzero[:, columns].any(axis=1))
    balances = {model.data.groups[i][0] for i in changed}
    balance = np.array([each for each, _ in model.data.groups])
    change = np.array([is_change(kind) for _, kind in model.data.groups])
    excess, left = _excess(before), _excess(after)

    def shares(kinds: np.ndarray) -> Iterator[float]:
        every = kinds & np.isin(balance, list(balances))
        yield _share(excess[every].sum(), left[every].sum())
        own = [kinds & (balance == each) for each in balances]
        large = [g for g in own if squares[g].sum() > CRITERIA.explained * excess[g].sum() > 0]
        if large:
            yield float(np.mean([_share(excess[g].sum(), left[g].sum()) for g in large]))

    return float(max((*shares(~change), *shares(change))))


def _share(total: float, left: float) -> float:
    return 1 - left / total if total > 0 else 0.0


def _excess(prediction: CrossValidation) -> np.ndarray:
    """Return the sums of squares (g,) above those of the noise."""
    above_noise = np.maximum(prediction.variance[0] - prediction.noise, 0.0)
    return above_noise * prediction.windows
