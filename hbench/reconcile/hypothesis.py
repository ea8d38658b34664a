"""Hypothesis: the given plant with factors on its nuisance parameters, effects, learned laws.

And the disturbances of its measurement. A step in one parameter makes a column by finite
differences.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from hbench.config.scaling import scaled
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.column_names import (
    CoefficientKey,
    coefficient_name,
    coefficient_of,
    factor_path,
    is_disturbance,
)
from hbench.reconcile.learned.table import Table
from hbench.units import parse_unit


@dataclass(frozen=True)
class Hypothesis:
    """Factors on nuisance parameters by dotted path, coefficients of effects in SI, tables.

    ``disturbances`` by column, in standard deviations of their priors (see ``disturbances.py``).
    """

    factors: Mapping[str, float] = field(default_factory=dict)
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    tables: tuple[Table, ...] = ()
    disturbances: Mapping[str, float] = field(default_factory=dict)

    def plant(self, given: Any) -> Any:
        """Return the given plant, or part of a plant, with the factors and effects applied."""
        changed = scaled(given, self.factors)
        update: dict[str, Any] = {"effects": {**given.effects, **self.section()}}
        if self.tables:
            update["learned"] = (*given.learned, *(table.law for table in self.tables))
        return changed.model_copy(update=update)

    def section(self) -> dict[str, dict[str, str]]:
        """Return the effects as in a file, in the units of the catalogue."""
        return {
            name: {
                key: _quantity(value, EFFECTS[name].coefficients[key].unit)
                for key, value in coefficients.items()
            }
            for name, coefficients in self.effects.items()
        }

    def with_coefficients(self, values: Mapping[CoefficientKey, float]) -> "Hypothesis":
        """Return the hypothesis with coefficients [SI] changed or added."""
        effects = {name: dict(coefficients) for name, coefficients in self.effects.items()}
        for (name, key), value in values.items():
            effects.setdefault(name, {})[key] = value
        return replace(self, effects=effects)

    def coefficient(self, which: CoefficientKey) -> float:
        """Return a coefficient [SI], or its default where it is not set."""
        name, key = which
        row = EFFECTS[name].coefficients[key]
        return self.effects.get(name, {}).get(key, row.to_si(row.default))


def effect_coefficients(name: str) -> tuple[CoefficientKey, ...]:
    """Return the coefficients of an effect that switch it on."""
    rows = EFFECTS[name].coefficients.items()
    return tuple((name, key) for key, row in rows if row.typical)


def shape_coefficients(name: str) -> tuple[CoefficientKey, ...]:
    """Return the coefficients of an effect that only change the shape of its law."""
    rows = EFFECTS[name].coefficients.items()
    return tuple((name, key) for key, row in rows if not row.typical)


def coefficient_names(effects: Iterable[str]) -> list[str]:
    """Return the names of the columns of the coefficients that switch some effects on."""
    return [coefficient_name(which) for name in effects for which in effect_coefficients(name)]


def typical_size(which: CoefficientKey) -> float:
    """Return a coefficient's typical size [SI]; for a shape a quarter of its default, or 0.25."""
    row = EFFECTS[which[0]].coefficients[which[1]]
    return row.to_si(row.typical or 0.25 * (row.default or 1.0))


def stepped(
    hypothesis: Hypothesis, name: str, widths: Mapping[str, float], size: float
) -> tuple[Hypothesis, float]:
    """Return a hypothesis with one parameter changed, and the change in its units.

    ``name`` is that of a column; ``widths`` are the priors' standard deviations of the factors.
    ``size`` is the step: of a factor's logarithm, or a share of a coefficient's typical size or a
    disturbance's standard deviation. It is reversed at a coefficient's upper limit.
    """
    if path := factor_path(name):
        factor = hypothesis.factors.get(path, 1.0) * float(np.exp(size))
        factors = {**hypothesis.factors, path: factor}
        return replace(hypothesis, factors=factors), size / widths[path]
    if is_disturbance(name):
        value = hypothesis.disturbances.get(name, 0.0) + size
        disturbances = {**hypothesis.disturbances, name: value}
        return replace(hypothesis, disturbances=disturbances), size
    which = effect, key = coefficient_of(name)
    row, current = EFFECTS[effect].coefficients[key], hypothesis.coefficient(which)
    step = max(size * typical_size(which), row.to_si(row.low) - current)
    if current + step > row.to_si(row.high):
        step = -step
    return hypothesis.with_coefficients({which: current + step}), step / typical_size(which)


def _quantity(si: float, unit: str) -> str:
    return f"{si / parse_unit(unit).factor:.9g} {unit}"
