"""Linearised model about a hypothesis: residuals of the balances and their columns.

The columns (see ``evidence/likelihood.py``) are the derivatives of the measured residuals by the
parameters. Units: factors in standard deviations of their priors (of the logarithm), coefficients
in typical sizes, disturbances and modes of learned laws in standard deviations of their priors.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.column_names import (
    CoefficientKey,
    coefficient_name,
    coefficient_of,
    factor_name,
    factor_path,
    is_coefficient,
    is_disturbance,
    is_mode,
    mode_of,
)
from hbench.reconcile.evidence.likelihood import Priors
from hbench.reconcile.evidence.products import Products
from hbench.reconcile.evidence.window_sums import products
from hbench.reconcile.gaps.gap_map import GapMap, column_means
from hbench.reconcile.hypothesis import (
    Hypothesis,
    effect_coefficients,
    typical_size,
)
from hbench.reconcile.measured.disturbances import limits
from hbench.reconcile.nuisance import BOUND, REPLACED, nuisances, standard_deviation
from hbench.records.reconcile.diagnosis import LEAST_EXPLAINED

_COEFFICIENT_PRIOR = 10.0  # typical sizes
_SHAPE_PRIOR = 3.0  # quarters of the default
_FIXED = 0.01  # standard deviation of a factor that is not refitted, in those of its prior
_LARGEST_MODE = 30.0  # of a learned law, in standard deviations of its prior
_Prior = tuple[float, float, float, float]  # of one column, as ``Priors``
_OFF = (0.0, np.nan, 0.0, 0.0)  # prior of a column that no fit has unless its effect is tried
Columns = Mapping[str, np.ndarray]  # by name: change of the residuals (w, c) by one unit


class Measured(Protocol):
    """Measurement side of the search."""

    @property
    def plant(self) -> Any:
        """The given model: a ``Plant`` or part of one."""

    @property
    def tolerances(self) -> Mapping[CoefficientKey, float]:
        """Limits [SI] of the coefficients that are nuisances within them, about the start."""

    @property
    def start(self) -> Hypothesis:
        """The given model, with the values of all coefficients that are nuisances."""

    def gap_map(self, hypothesis: Hypothesis, reference: GapMap | None = None) -> GapMap:
        """Return the residuals of the measured runs with a hypothesis.

        Their scatter is that of a ``reference``, if there is one.
        """

    def columns(self, hypothesis: Hypothesis, names: Iterable[str]) -> Columns:
        """Return the columns ``names`` at a hypothesis."""


@dataclass(frozen=True)
class LinearisedModel:
    """Linearised model about a hypothesis: residuals, and products of columns."""

    hypothesis: Hypothesis
    gap_map: GapMap
    columns: Columns
    data: Products
    tight: Priors  # coefficients with a tolerance are within it
    wide: Priors  # they are not

    def coefficients_of(self, names: Iterable[str]) -> tuple[CoefficientKey, ...]:
        """Return the coefficients of some effects that have a column, in column order."""
        wanted = set(names)
        every = map(coefficient_of, filter(is_coefficient, self.data.names))
        return tuple(which for which in every if which[0] in wanted)

    def column(self, which: CoefficientKey) -> int:
        """Return the index of a coefficient's column."""
        return self.data.names.index(coefficient_name(which))

    @property
    def nuisances(self) -> tuple[int, ...]:
        """Indices of the columns that take part in every fit."""
        return tuple(np.flatnonzero(np.isfinite(self.tight.sigma)).tolist())

    def index(self, names: Iterable[str]) -> list[int]:
        """Return the indices of the columns of all nuisances and of some effects."""
        chosen = {*self.nuisances, *(self.column(c) for c in self.coefficients_of(names))}
        return sorted(chosen)

    def about_itself(self, names: Iterable[str]) -> "LinearisedModel":
        """Return the model for data of its own: tolerances of ``names`` about its coefficients."""
        shift = np.zeros(len(self.data.names))
        for which in self.coefficients_of(names):
            shift[self.column(which)] = self.hypothesis.coefficient(which) / typical_size(which)
        return replace(self, tight=self.tight.shifted(-shift))

    def priors(self, names: Iterable[str]) -> Priors:
        """Return the priors of all columns where only the effects ``names`` may be any size.

        Factors that these replace are those of the given model.
        """
        wanted = set(names)
        own = np.zeros(len(self.data.names), bool)
        own[[self.column(which) for which in self.coefficients_of(wanted)]] = True
        priors = Priors(
            *(
                np.where(own, getattr(self.wide, name), getattr(self.tight, name))
                for name in ("centre", "sigma", "low", "high")
            )
        )
        replaced = {factor_name(path) for effect, path in REPLACED.items() if effect in wanted}
        at = np.array([name in replaced for name in self.data.names], bool)
        return replace(priors, sigma=np.where(at, _FIXED, priors.sigma))

    def alternative_priors(self, names: Iterable[str]) -> list[Priors]:
        """Return the priors of all columns, several where an effect is an error of one sensor.

        Of its coefficients one alone is beyond its tolerance, another one in each of the priors,
        unless one is in the hypothesis. Transducers that are all wrong by a share are another
        effect: a wrong load cell.
        """
        wanted = list(names)
        every = [self.priors(wanted)]
        for effect in (name for name in wanted if EFFECTS[name].alone):
            own = np.array([self.column(which) for which in self.coefficients_of([effect])])
            if len(own) and (self.wide.high[own] > self.tight.high[own]).all():
                every = [self._tight_but(p, own, alone) for p in every for alone in own.tolist()]
        return every

    def _tight_but(self, priors: Priors, own: np.ndarray, alone: int) -> Priors:
        """Return priors that are tight for the columns ``own`` but one."""
        others = np.isin(np.arange(len(self.data.names)), own[own != alone])
        names = ("centre", "sigma", "low", "high")
        pairs = ((getattr(self.tight, name), getattr(priors, name)) for name in names)
        return Priors(*(np.where(others, tight, given) for tight, given in pairs))


def linearise(
    measured: Measured,
    hypothesis: Hypothesis,
    columns: Columns,
    reference: GapMap | None = None,
) -> LinearisedModel:
    """Linearise about a hypothesis with these columns; ``reference`` provides the scatter."""
    residuals = measured.gap_map(hypothesis, reference)
    return linearise_residuals(measured, hypothesis, residuals, columns)


def linearise_residuals(
    measured: Measured,
    hypothesis: Hypothesis,
    residuals: GapMap,
    columns: Columns,
    known: Products | None = None,
) -> LinearisedModel:
    """Linearise about a hypothesis whose residuals are known.

    ``known`` are the products of other residuals with the same columns and scatter.
    """
    widths = nuisances(measured.plant)
    rows = [_tight_and_wide(measured, hypothesis, name, widths) for name in columns]
    tight, wide = np.array(rows).reshape(-1, 2, 4).transpose(1, 2, 0)
    data = products(residuals, columns, known)
    return LinearisedModel(hypothesis, residuals, columns, data, Priors(*tight), Priors(*wide))


def _tight_and_wide(
    measured: Measured, hypothesis: Hypothesis, name: str, widths: Mapping[str, float]
) -> tuple[_Prior, _Prior]:
    """Return both priors of a step from the hypothesis; only those of a coefficient differ."""
    if is_coefficient(name):
        return _priors_of_coefficient(measured, hypothesis, coefficient_of(name))
    if path := factor_path(name):
        at, low, high = np.log(hypothesis.factors.get(path, 1.0)) / widths[path], -BOUND, BOUND
    elif is_disturbance(name):
        at, (low, high) = hypothesis.disturbances.get(name, 0.0), limits(name)
    else:
        table, mode = mode_of(name)
        at, low, high = hypothesis.tables[table].modes[mode], -_LARGEST_MODE, _LARGEST_MODE
    prior = -at, 1.0, low - at, high - at
    return prior, prior


def _priors_of_coefficient(
    measured: Measured, hypothesis: Hypothesis, which: CoefficientKey
) -> tuple[_Prior, _Prior]:
    effect, key = which
    row, size = EFFECTS[effect].coefficients[key], typical_size(which)
    at, neutral = hypothesis.coefficient(which) / size, row.to_si(row.default)
    sigma = _COEFFICIENT_PRIOR if row.typical else _SHAPE_PRIOR
    low, high = min(row.to_si(row.low), neutral) / size - at, row.to_si(row.high) / size - at
    limit = measured.tolerances.get(which, 0.0) / size
    off = measured.start.coefficient(which) / size - at if limit else 0.0
    within = off, standard_deviation(limit), max(off - limit, low), min(off + limit, high)
    beside = EFFECTS[effect].alone and _beyond(measured, hypothesis, effect) - {which}
    wide = within if beside else (neutral / size - at, sigma, low, high)
    return within if limit else _OFF, wide


def _beyond(measured: Measured, hypothesis: Hypothesis, effect: str) -> set[CoefficientKey]:
    """Return the coefficients of an effect that are beyond their tolerances."""
    limits = {which: limit for which, limit in measured.tolerances.items() if which[0] == effect}
    return {
        which
        for which, limit in limits.items()
        if abs(hypothesis.coefficient(which) - measured.start.coefficient(which)) > limit
    }


def hypothesis_at(
    model: LinearisedModel, plant: Any, chosen: Sequence[int], beta: np.ndarray
) -> Hypothesis:
    """Return the hypothesis at steps ``beta`` (q,) of the ``chosen`` columns."""
    before, widths = model.hypothesis, nuisances(plant)
    factors, values, tables = dict(before.factors), {}, list(before.tables)
    disturbances = dict(before.disturbances)
    for i, step in zip(chosen, beta.tolist(), strict=True):
        name = model.data.names[i]
        if path := factor_path(name):
            factors[path] = float(factors.get(path, 1.0) * np.exp(step * widths[path]))
        elif is_disturbance(name):
            disturbances[name] = disturbances.get(name, 0.0) + step
        elif is_mode(name):
            table, mode = mode_of(name)
            tables[table] = tables[table].stepped(mode, step)
        else:
            which = coefficient_of(name)
            values[which] = _allowed(which, before.coefficient(which) + step * typical_size(which))
    changed = replace(before, factors=factors, tables=tuple(tables), disturbances=disturbances)
    return changed.with_coefficients(values)


def _allowed(which: CoefficientKey, value: float) -> float:
    """Return a coefficient [SI] that a file may contain: a step from 0 may end below the limit."""
    row = EFFECTS[which[0]].coefficients[which[1]]
    if value == row.to_si(row.default):
        return value
    return min(max(value, row.to_si(row.low)), row.to_si(row.high))


def changed_balances(
    without: GapMap, model: LinearisedModel, name: str, points: np.ndarray
) -> frozenset[str]:
    """Return the balances that an effect of a model changes enough to explain a quarter of a gap.

    The gap is that ``without`` it at some ``points``. Refitted values move it in other balances,
    which is no evidence of the effect. All that the effect touches where it changes none so much.
    """
    touched = EFFECTS[name].balances
    windows, change = np.isin(without.point, points), np.zeros_like(without.difference)
    for which in effect_coefficients(name):
        if (column := model.columns.get(coefficient_name(which))) is not None:
            change += model.hypothesis.coefficient(which) / typical_size(which) * column
    with np.errstate(divide="ignore", invalid="ignore"):
        squares = column_means((change / without.scatter)[windows] ** 2)
    excess = column_means(without.excess[windows])
    enough = squares > LEAST_EXPLAINED * np.maximum(excess, 0.0)
    changed = (each for each, large in zip(without.names, enough, strict=True) if large)
    return frozenset(touched).intersection(changed) or frozenset(touched)
