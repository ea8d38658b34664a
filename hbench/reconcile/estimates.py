"""Parameter estimates of the revised model: nuisance factors and coefficients, with intervals."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.intervals import Bound
from hbench.analysis.statistics.student import student_factor
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.evidence import intervals, maximum_likelihood
from hbench.reconcile.hypothesis import CoefficientKey, Hypothesis, typical_size
from hbench.reconcile.linearised import LinearisedModel, hypothesis_at
from hbench.reconcile.nuisance import nuisances
from hbench.records import FitParameter
from hbench.units import parse_unit

_AT_BOUND = 1e-6  # priors and typical sizes


@dataclass(frozen=True)
class ParameterEstimates:
    """Most likely parameters about a linearised model: nuisances, then ``coefficients``."""

    plant: Any  # the given model: a ``Plant`` or part of one
    model: LinearisedModel
    coefficients: tuple[CoefficientKey, ...]
    beta: np.ndarray  # (q,)
    covariance: np.ndarray  # (q, q)
    dof: np.ndarray  # (q,)
    low: np.ndarray  # (q,)
    high: np.ndarray  # (q,)

    def hypothesis(self, beta: np.ndarray) -> Hypothesis:
        """Return the hypothesis at some beta (q,)."""
        return hypothesis_at(self.model, self.plant, self.coefficients, beta)

    def factors(self) -> dict[str, FitParameter]:
        """Return the factors on the nuisances, by dotted path."""
        values = self.hypothesis(self.beta).factors
        factors = {}
        for i, (path, prior) in enumerate(nuisances(self.plant).items()):
            value, half_width = values[path], prior * self._half_width(i)
            ends = (float(value * np.exp(-half_width)), float(value * np.exp(half_width)))
            se = prior * value * float(np.sqrt(self.covariance[i, i]))
            factors[path] = self._parameter(i, value, se, ends, "1")
        return factors

    def of_effect(self, name: str) -> dict[str, FitParameter]:
        """Return an effect's coefficients in the units of the catalogue."""
        hypothesis = self.hypothesis(self.beta)
        first, parameters = len(self.beta) - len(self.coefficients), {}
        for i, which in enumerate(self.coefficients, start=first):
            if which[0] != name:
                continue
            unit = EFFECTS[name].coefficients[which[1]].unit
            size = typical_size(which) / parse_unit(unit).factor
            value = hypothesis.coefficient(which) / parse_unit(unit).factor
            half_width = size * self._half_width(i)
            se = size * float(np.sqrt(self.covariance[i, i]))
            ends = (value - half_width, value + half_width)
            parameters[which[1]] = self._parameter(i, value, se, ends, unit)
        return parameters

    def draws(self, count: int, seed: int = 1) -> list[Hypothesis]:
        """Return hypotheses drawn from the parameters' uncertainty, within their bounds."""
        rng = np.random.default_rng(seed)
        drawn = rng.multivariate_normal(self.beta, self.covariance, count, method="svd")
        return [self.hypothesis(np.clip(beta, self.low, self.high)) for beta in drawn]

    def _parameter(
        self, i: int, value: float, se: float, ends: tuple[float, float], unit: str
    ) -> FitParameter:
        bound = self._bound(i)
        if bound is None:
            return FitParameter(value, se, ends, None, unit)
        ci95 = (value, ends[1]) if bound == "lower" else (ends[0], value)
        return FitParameter(value, None, ci95, bound, unit)

    def _half_width(self, i: int) -> float:
        return float(student_factor(whole_dof(self.dof[i])) * np.sqrt(self.covariance[i, i]))

    def _bound(self, i: int) -> Bound:
        if self.beta[i] <= self.low[i] + _AT_BOUND:
            return "lower"
        return "upper" if self.beta[i] >= self.high[i] - _AT_BOUND else None


def whole_dof(dof: float) -> int:
    """Return degrees of freedom rounded down, except where only rounding errors are missing."""
    return int(dof * (1 + ROUNDING))


def fit_coefficients(
    plant: Any, model: LinearisedModel, names: Sequence[str], train: np.ndarray
) -> ParameterEstimates:
    """Fit the nuisances and the coefficients of the effects ``names`` to the points ``train``."""
    coefficients = model.coefficients_of(names)
    chosen = model.index(coefficients)
    beta = maximum_likelihood(model.data, model.priors, chosen, train)[0]
    covariance, dof = intervals(model.data, model.priors, chosen, beta, train)
    priors = model.priors.select(chosen)
    return ParameterEstimates(
        plant, model, coefficients, beta, covariance, dof, priors.low, priors.high
    )
