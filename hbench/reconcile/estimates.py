"""Parameter estimates of the revised model: nuisance factors and coefficients, with intervals."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.special import fdtri

from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.intervals import Bound
from hbench.analysis.statistics.student import student_factor
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.column_names import (
    CoefficientKey,
    coefficient_name,
    coefficient_of,
    delayed_channel,
    factor_path,
)
from hbench.reconcile.evidence.likelihood import maximum_likelihood, spread
from hbench.reconcile.gaps.gap_map import GapMap, column_means
from hbench.reconcile.hypothesis import (
    Hypothesis,
    effect_coefficients,
    typical_size,
)
from hbench.reconcile.linearised import LinearisedModel, hypothesis_at
from hbench.reconcile.measured.disturbances import DELAY_S
from hbench.reconcile.nuisance import nuisances
from hbench.records import FitParameter
from hbench.records.reconcile.diagnosis import REST_M_S
from hbench.units import parse_unit

_MS = 1e3 * DELAY_S  # of a delay's standard deviation
_LIKE_SPEED = 0.2  # of a speed
_AT_BOUND = 1e-6  # priors and typical sizes


@dataclass(frozen=True)
class ParameterEstimates:
    """Most likely parameters about a linearised model: nuisances and coefficients of effects."""

    plant: Any  # the given model: a ``Plant`` or part of one
    model: LinearisedModel
    chosen: tuple[int, ...]  # (q,) indices of the model's columns
    beta: np.ndarray  # (q,)
    covariance: np.ndarray  # (q, q)
    sandwich: np.ndarray  # (q, q) covariance by the residuals alone; see ``likelihood.spread``
    dof: np.ndarray  # (q,)
    low: np.ndarray  # (q,)
    high: np.ndarray  # (q,)

    @cached_property
    def hypothesis(self) -> Hypothesis:
        """The most likely hypothesis."""
        return hypothesis_at(self.model, self.plant, self.chosen, self.beta)

    def factors(self) -> dict[str, FitParameter]:
        """Return the factors on the nuisances that change what is compared, by dotted path."""
        values, priors = self.hypothesis.factors, nuisances(self.plant)
        factors = {}
        for i, name in enumerate(self._names):
            path = factor_path(name)
            if not path or not self._is_shown(name):
                continue
            value, half_width = values[path], priors[path] * self._half_width(i)
            ends = (float(value * np.exp(-half_width)), float(value * np.exp(half_width)))
            se = priors[path] * value * self._standard_error(i)
            factors[path] = self._parameter(i, value, se, ends, "1")
        return factors

    def of_effect(self, name: str) -> dict[str, FitParameter]:
        """Return an effect's coefficients in the catalogue's units, where data show them."""
        parameters = {}
        for i, column in enumerate(self._names):
            which = effect, key = coefficient_of(column)
            if effect != name or not self._is_shown(column):
                continue
            unit = EFFECTS[name].coefficients[key].unit
            size = typical_size(which) / parse_unit(unit).factor
            start = self.model.hypothesis.coefficient(which) / parse_unit(unit).factor
            parameters[key] = self._scaled(i, start + size * float(self.beta[i]), size, unit)
        return parameters

    def delays(self) -> dict[str, FitParameter]:
        """Return the delays that matter against the position, by channel; see ``disturbances.py``.

        They are not 0 (95 %), and without one a balance would deviate by more than what is
        material.
        """
        gap_map, values = self.model.gap_map, self.hypothesis.disturbances
        delays = {}
        for i, name in enumerate(self._names):
            if not (channel := delayed_channel(name)):
                continue
            change = np.sqrt(column_means((self.model.columns[name] / gap_map.scatter) ** 2))
            if not np.any(np.abs(values[name]) * change > gap_map.material):
                continue
            if abs(values[name]) >= self._half_width(i):
                delays[channel] = self._scaled(i, _MS * values[name], _MS, "ms")
        return delays

    def may_be_zero(self, name: str) -> bool:
        """Return whether an effect's coefficients together do not differ from 0 (95 %).

        Wald's test, with F for k coefficients, also where each of k intervals contains 0. The
        shape of the law is the fitted one: of an effect that is 0 no data determine it, and where
        size and shape are a product neither alone differs from 0. Coefficients that change nothing
        in these data, as of a bench without a load cylinder, do not count.
        """
        known = effect_coefficients(name)
        shown = [
            which
            for which in self.model.coefficients_of([name])
            if self._is_shown(coefficient_name(which))
        ]
        keys = [which for which in shown if which in known]
        if not keys:
            return True
        rows, shapes = (
            [self.chosen.index(self.model.column(which)) for which in some]
            for some in (keys, [which for which in shown if which not in known])
        )
        off = np.array([self.model.hypothesis.coefficient(w) / typical_size(w) for w in keys])
        off += self.beta[rows]
        together = self.covariance[np.ix_(rows, shapes)]
        given = together @ np.linalg.solve(self.covariance[np.ix_(shapes, shapes)], together.T)
        square = off @ np.linalg.solve(self.covariance[np.ix_(rows, rows)] - given, off)
        return bool(square <= len(rows) * fdtri(len(rows), self.dof[rows].min(), 0.95))

    def degrees_of_freedom(self, which: CoefficientKey) -> float:
        """Return the degrees of freedom of a coefficient."""
        return float(self.dof[self.chosen.index(self.model.column(which))])

    def _is_shown(self, name: str) -> bool:
        """Return whether a parameter changes any of the residuals."""
        return bool(np.nan_to_num(self.model.columns[name]).any())

    @property
    def _names(self) -> tuple[str, ...]:
        return tuple(self.model.data.names[i] for i in self.chosen)

    def _scaled(self, i: int, value: float, size: float, unit: str) -> FitParameter:
        """Return a parameter with a value, of which ``size`` is one unit of its beta."""
        half_width = size * self._half_width(i)
        ends = value - half_width, value + half_width
        return self._parameter(i, value, size * self._standard_error(i), ends, unit)

    def _parameter(
        self, i: int, value: float, se: float, ends: tuple[float, float], unit: str
    ) -> FitParameter:
        bound = self._bound(i)
        if bound is None:
            return FitParameter(value, se, ends, None, unit)
        ci95 = (value, ends[1]) if bound == "lower" else (ends[0], value)
        return FitParameter(value, None, ci95, bound, unit)

    def _half_width(self, i: int) -> float:
        return student_factor(whole_dof(self.dof[i])) * self._standard_error(i)

    def _standard_error(self, i: int) -> float:
        return float(np.sqrt(self.covariance[i, i]))

    def _bound(self, i: int) -> Bound:
        if self.beta[i] <= self.low[i] + _AT_BOUND:
            return "lower"
        return "upper" if self.beta[i] >= self.high[i] - _AT_BOUND else None


def times(parameter: FitParameter, factor: float) -> FitParameter:
    """Return a parameter that is ``factor`` times another."""
    se, ends = parameter.se, parameter.ci95
    return replace(
        parameter,
        value=factor * parameter.value,
        se=None if se is None else factor * se,
        ci95=None if ends is None else (factor * ends[0], factor * ends[1]),
    )


def whole_dof(dof: float) -> int:
    """Return degrees of freedom rounded down, except where only rounding errors are missing."""
    return int(dof * (1 + ROUNDING))


def fit_coefficients(
    plant: Any, model: LinearisedModel, names: Sequence[str], train: np.ndarray
) -> ParameterEstimates:
    """Fit the nuisances and the coefficients of the effects ``names`` to the points ``train``."""
    chosen, priors = tuple(model.index(names)), model.priors(names)
    beta = maximum_likelihood(model.data, priors, chosen, train)
    of_fit = spread(model.data, priors, chosen, beta, train, _like_speeds(model.gap_map))
    bounds = priors.select(chosen)
    return ParameterEstimates(plant, model, chosen, beta, *of_fit, bounds.low, bounds.high)


def _like_speeds(gap_map: GapMap) -> np.ndarray:
    """Return an index (p,) of each operating point, the same for about the same usual speed."""
    speeds = np.array(
        [
            np.median(np.abs(gap_map.v_m_s[gap_map.point == i])) + REST_M_S
            for i in range(len(gap_map.points))
        ]
    )
    return np.unique(np.round(np.log(speeds) / _LIKE_SPEED), return_inverse=True)[1]
