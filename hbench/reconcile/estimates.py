"""The parameters of the revised model: factors on nuisances and coefficients, with intervals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.intervals import Bound
from hbench.analysis.statistics.student import student_factor
from hbench.config.bench import Plant
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.evidence import fit, intervals
from hbench.reconcile.linearised import Coefficient, Hypothesis, Linear, moved, typical
from hbench.reconcile.nuisance import nuisances
from hbench.records import FitParameter
from hbench.units import parse_unit

_AT_BOUND = 1e-6  # priors and typical sizes


@dataclass(frozen=True)
class Estimates:
    """The most likely parameters around a model: nuisances, then the coefficients ``which``."""

    plant: Plant
    around: Linear
    which: tuple[Coefficient, ...]
    beta: np.ndarray  # (q,)
    spread: np.ndarray  # (q, q)
    dof: np.ndarray  # (q,)
    low: np.ndarray  # (q,)
    high: np.ndarray  # (q,)

    def hypothesis(self, beta: np.ndarray) -> Hypothesis:
        """Return the hypothesis at some beta (q,)."""
        return moved(self.around, self.plant, self.which, beta)

    def factors(self) -> dict[str, FitParameter]:
        """Return the factors on the nuisances, by dotted path."""
        values = self.hypothesis(self.beta).factors
        found = {}
        for i, (path, prior) in enumerate(nuisances(self.plant).items()):
            value, wide = values[path], prior * self._half(i)
            ends = (float(value * np.exp(-wide)), float(value * np.exp(wide)))
            se = prior * value * float(np.sqrt(self.spread[i, i]))
            found[path] = self._parameter(i, value, se, ends, "1")
        return found

    def coefficients(self, name: str) -> dict[str, FitParameter]:
        """Return an effect's coefficients in the units of the catalogue."""
        at = self.hypothesis(self.beta)
        first, found = len(self.beta) - len(self.which), {}
        for i, one in enumerate(self.which, start=first):
            if one[0] != name:
                continue
            unit = EFFECTS[name].coefficients[one[1]].unit
            size = typical(one) / parse_unit(unit).factor
            value = at.coefficient(one) / parse_unit(unit).factor
            wide, se = size * self._half(i), size * float(np.sqrt(self.spread[i, i]))
            found[one[1]] = self._parameter(i, value, se, (value - wide, value + wide), unit)
        return found

    def draws(self, count: int, seed: int = 1) -> list[Hypothesis]:
        """Return hypotheses drawn from the parameters' uncertainty, within their bounds."""
        rng = np.random.default_rng(seed)
        drawn = rng.multivariate_normal(self.beta, self.spread, count, method="svd")
        return [self.hypothesis(np.clip(one, self.low, self.high)) for one in drawn]

    def _parameter(
        self, i: int, value: float, se: float, ends: tuple[float, float], unit: str
    ) -> FitParameter:
        bound = self._bound(i)
        if bound is None:
            return FitParameter(value, se, ends, None, unit)
        ci95 = (value, ends[1]) if bound == "lower" else (ends[0], value)
        return FitParameter(value, None, ci95, bound, unit)

    def _half(self, i: int) -> float:
        return float(student_factor(whole_dof(self.dof[i])) * np.sqrt(self.spread[i, i]))

    def _bound(self, i: int) -> Bound:
        if self.beta[i] <= self.low[i] + _AT_BOUND:
            return "lower"
        return "upper" if self.beta[i] >= self.high[i] - _AT_BOUND else None


def whole_dof(dof: float) -> int:
    """Return degrees of freedom rounded down, but not where rounding alone is missing."""
    return int(dof * (1 + ROUNDING))


def estimate(plant: Plant, around: Linear, names: Sequence[str], train: np.ndarray) -> Estimates:
    """Return the most likely nuisances and coefficients of the effects ``names``."""
    which = around.coefficients_of(names)
    chosen = around.index(which)
    beta = fit(around.data, around.free, chosen, train)[0]
    spread, dof = intervals(around.data, around.free, chosen, beta, train)
    own = around.free.of(chosen)
    return Estimates(plant, around, which, beta, spread, dof, own.low, own.high)
