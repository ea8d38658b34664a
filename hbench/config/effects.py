"""Physical effects in a bench or plant file: names, and coefficients with their units and ranges.

    effects:
      internal_leakage: {test: 0.003 l/min/bar}
      valve_deadband: {test: 50 mV, load: 50 mV}

An effect that the file does not name is off. The catalogue is ``model/effects/catalogue.py``.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from hbench.errors import ConfigError
from hbench.units import from_si, parse_unit, to_si

Effects = dict[str, dict[str, float | str]]  # as in the file


@dataclass(frozen=True)
class Coefficient:
    """Coefficient of an effect; its numbers are in ``unit``."""

    unit: str
    typical: float  # of a clear effect in a campaign; 0 where another coefficient switches it
    low: float  # physical limits
    high: float
    default: float = 0.0  # where the file gives none

    def to_si(self, number: float) -> float:
        """Convert a number in this unit to SI."""
        return number * parse_unit(self.unit).factor

    def read(self, value: object) -> float:
        """Read a quantity in SI; its default is always allowed. Raises ``ValueError``."""
        si = to_si(value, self.unit)
        number = from_si(si, self.unit)
        slack = 1e-12 * max(abs(self.low), abs(self.high))
        if number != self.default and not self.low - slack <= number <= self.high + slack:
            raise ValueError(f"must be between {self.low:g} and {self.high:g} {self.unit}")
        return si


Specification = Mapping[str, Mapping[str, Coefficient]]


def parse_effects(data: Effects, known: Specification) -> dict[str, dict[str, float]]:
    """Return the coefficients [SI] of a section's effects, with defaults for those not given.

    Raises ``ConfigError`` with all faults, including names that are not ``known``.
    """
    effects, faults = {}, []
    for name, given in data.items():
        coefficients = known.get(name)
        if coefficients is None:
            faults.append(f"effects.{name}: no such effect; known are {', '.join(sorted(known))}")
            continue
        values = {key: c.to_si(c.default) for key, c in coefficients.items()}
        for key, value in given.items():
            if key not in coefficients:
                names = ", ".join(coefficients)
                faults.append(f"effects.{name}.{key}: no such coefficient; known are {names}")
                continue
            try:
                values[key] = coefficients[key].read(value)
            except ValueError as error:
                faults.append(f"effects.{name}.{key} = {value!r}: {error}")
        effects[name] = values
    if faults:
        raise ConfigError("\n".join(faults), "hbench/model/effects/README.md lists the effects.")
    return effects
