"""Candidate effects: evaluation by signature or by simulation, and acceptance.

The searches in campaigns (``search.py``) and in imported strokes (``strokes/stroke_search.py``)
share this evaluation.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hbench.reconcile.evidence import (
    CrossValidation,
    cost,
    cross_validate,
    log_likelihood,
    maximum_likelihood,
    score,
)
from hbench.reconcile.gaps.columns import ModelColumn
from hbench.reconcile.hypothesis import CoefficientKey, Hypothesis, Simulate, typical_size
from hbench.reconcile.linearised import LinearisedModel, hypothesis_at, linearise
from hbench.reconcile.measured_campaign import MeasurementInterface
from hbench.records import Candidate

TIE = 1e-6  # nats: candidates whose scores differ by rounding keep the catalogue's order
NULLS = 200  # random null data sets
_QUANTILE = 0.98  # of the largest null scores
_AMBIGUOUS_NATS, _AMBIGUOUS_SHARE = 3.0, 0.1  # of the best score; the larger one counts
_REFIT_ROUNDS = 2  # of simulation and fit
_NEGLIGIBLE_STEP = 0.05  # priors of nuisances and typical sizes; no new simulation below


@dataclass(frozen=True)
class AcceptanceCriteria:
    """Least score, explained share and size of an effect that may be added to a model."""

    score: float  # nats: least threshold
    explained: float  # share of the excess gap in the balances that the effect touches
    size: float  # largest coefficient, in typical sizes

    def threshold(self, null_scores: np.ndarray) -> float:
        """Return the score to exceed, from the largest scores (n,) of null data sets."""
        return max(self.score, float(np.quantile(null_scores, _QUANTILE)))

    def accepts(self, candidate: Candidate) -> bool:
        """Return whether a candidate exceeds its own threshold and meets the other criteria."""
        return (
            candidate.score > candidate.threshold
            and candidate.explained > self.explained
            and candidate.size >= self.size
        )


# 5 nats are odds of 150 to 1. A quarter is enough: the remainder may be other effects.
CRITERIA = AcceptanceCriteria(score=5.0, explained=0.25, size=0.2)


def indistinguishable(accepted: Sequence[Candidate]) -> tuple[Candidate, ...]:
    """Return the candidates whose scores are close to that of the first, the best one."""
    best = accepted[0].score
    least = best - max(_AMBIGUOUS_NATS, _AMBIGUOUS_SHARE * best)
    return tuple(candidate for candidate in accepted if candidate.score >= least)


@dataclass(frozen=True)
class EvaluatedCandidate:
    """Candidate effect, with the model about its own simulation if it was simulated."""

    candidate: Candidate
    model: LinearisedModel | None


@dataclass(frozen=True)
class CandidateEvaluator:
    """Evaluation of candidate effects on one set of measurements."""

    measured: MeasurementInterface
    simulate: Simulate
    trials: int
    signatures: Mapping[CoefficientKey, ModelColumn]
    train: np.ndarray  # indices of the operating points in use
    candidates: tuple[str, ...]

    def simulate_at(self, hypothesis: Hypothesis) -> LinearisedModel | None:
        """Simulate a hypothesis and linearise about it; None where the board stops."""
        (runs,) = self.simulate([hypothesis], self.trials)
        if runs is None:
            return None
        return linearise(self.measured, hypothesis, runs, self.signatures)

    def refit(self, start: LinearisedModel, effects: Sequence[str]) -> LinearisedModel:
        """Refit the nuisances and the coefficients of ``effects``; never return a worse model."""
        coefficients = start.coefficients_of(effects)
        current, current_cost = start, self._cost(start, coefficients)
        for _ in range(_REFIT_ROUNDS):
            chosen = current.index(coefficients)
            beta = maximum_likelihood(current.data, current.priors, chosen, self.train)[0]
            if np.abs(beta).max() < _NEGLIGIBLE_STEP:
                break
            refitted = self.simulate_at(
                hypothesis_at(current, self.measured.plant, coefficients, beta)
            )
            if refitted is None:
                break
            refitted_cost = self._cost(refitted, coefficients)
            if refitted_cost > current_cost + CRITERIA.score:
                break
            current, current_cost = refitted, refitted_cost
        return current

    def _cost(self, model: LinearisedModel, coefficients: Sequence[CoefficientKey]) -> float:
        return cost(model.data, model.priors, model.index(coefficients), self.train)

    def _cross_validate(self, model: LinearisedModel, effects: Sequence[str]) -> CrossValidation:
        chosen = model.index(model.coefficients_of(effects))
        return cross_validate(model.data, model.priors, chosen, self.train)

    def _evaluate_by_signature(
        self, model: LinearisedModel, base: Sequence[int], name: str
    ) -> EvaluatedCandidate:
        coefficients = model.coefficients_of([name])
        more = [i for i in model.index(coefficients) if i not in base]
        joined = [*base, *more]
        gain = float(score(model.data, model.priors, base, more, self.train)[0])
        beta = maximum_likelihood(model.data, model.priors, joined, self.train)[0][len(base) :]
        before = cross_validate(model.data, model.priors, base, self.train)
        after = cross_validate(model.data, model.priors, joined, self.train)
        values = {
            which: float(step) * typical_size(which)
            for which, step in zip(coefficients, beta, strict=True)
        }
        share = explained_share(name, model, before, after)
        return EvaluatedCandidate(_candidate(name, gain, share, values, "linear"), None)

    def _evaluate_by_simulation(
        self, model: LinearisedModel, added: tuple[str, ...], names: Sequence[str]
    ) -> dict[str, EvaluatedCandidate]:
        """Simulate candidates with the coefficients of the linear fit and evaluate them."""
        before = self._cross_validate(model, added)
        hypotheses = []
        for name in names:
            coefficients = model.coefficients_of((*added, name))
            beta = maximum_likelihood(
                model.data, model.priors, model.index(coefficients), self.train
            )[0]
            hypotheses.append(hypothesis_at(model, self.measured.plant, coefficients, beta))
        evaluated = {}
        simulated = self.simulate(hypotheses, self.trials)
        for name, hypothesis, runs in zip(names, hypotheses, simulated, strict=True):
            if runs is None:
                continue
            with_effect = linearise(self.measured, hypothesis, runs, self.signatures, model.gap_map)
            chosen = with_effect.index(with_effect.coefficients_of((*added, name)))
            after = cross_validate(with_effect.data, with_effect.priors, chosen, self.train)
            gain = float((log_likelihood(after) - log_likelihood(before))[0])
            beta = maximum_likelihood(with_effect.data, with_effect.priors, chosen, self.train)[
                0
            ].tolist()
            steps = dict(zip(chosen, beta, strict=True))
            values = {
                which: hypothesis.coefficient(which)
                + steps[with_effect.column(which)] * typical_size(which)
                for which in with_effect.coefficients_of([name])
            }
            share = explained_share(name, model, before, after)
            candidate = _candidate(name, gain, share, values, "simulated")
            evaluated[name] = EvaluatedCandidate(candidate, with_effect)
        return evaluated


def explained_share(
    name: str, model: LinearisedModel, before: CrossValidation, after: CrossValidation
) -> float:
    """Return the share of the excess gap that an effect explains in the balances it changes."""
    columns = [model.column(which) for which in model.coefficients_of([name])]
    nonzero = np.einsum("pgjj->gj", model.data.columns)[:, columns].any(axis=1)
    balances = {
        balance for (balance, _), changed in zip(model.data.groups, nonzero, strict=True) if changed
    }
    touched = np.isin([balance for balance, _ in model.data.groups], list(balances))

    def excess(prediction: CrossValidation) -> float:
        above_noise = np.maximum(prediction.variance[0] - prediction.noise, 0.0)
        return float((above_noise * prediction.windows)[touched].sum())

    total = excess(before)
    return 1 - excess(after) / total if total > 0 else 0.0


def _candidate(
    name: str,
    gain: float,
    share: float,
    values: Mapping[CoefficientKey, float],
    tried: Literal["simulated", "linear"],
) -> Candidate:
    size = max((abs(value) / typical_size(which) for which, value in values.items()), default=0.0)
    parameters = {key: value for (_, key), value in values.items()}
    return Candidate(name, gain, share, size, parameters, tried, CRITERIA.score)
