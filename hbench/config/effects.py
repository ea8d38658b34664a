"""Physical effects in a bench or plant file: names, and coefficients with their units and ranges.

    effects:
      internal_leakage: {test: 0.003 l/min/bar}
      valve_deadband: {test: 50 mV, load: 50 mV}

An effect that the file does not name is off. The catalogue is ``model/effects/catalogue.py``.

``learned`` lists tables that ``hbench reconcile`` fitted where no effect explains the residuals:

    learned:
      - adds_to: friction_test
        over: {position: [50 mm, 150 mm, 250 mm]}
        values: [4 N, -8 N, 2 N]
"""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, get_args

from pydantic import model_validator

from hbench.config.quantity import ConfigSection
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
        if not given:
            nothing = f"effects.{name}: no coefficient is given, so it changes nothing"
            clear = [
                f"{key}: {c.typical:g} {c.unit}" for key, c in coefficients.items() if c.typical
            ]
            faults.append(f"{nothing}; '{clear[0]}' is a clear effect" if clear else nothing)
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


Target = Literal[
    "flow_tp", "flow_tr", "flow_lp", "flow_lr",
    "force_test", "force_load", "friction_test", "friction_load",
    "supply", "position_sensor",
]  # fmt: skip
"""Term of the plant's equations: inflow of a chamber, force against extension of a cylinder,
magnitude of a cylinder's dry friction, pressure of a source without pump, or travel of the piston
over that of the position sensor's reading, less 1."""
TARGETS: tuple[Target, ...] = get_args(Target)
# Quantities of learned laws. Those of a cylinder or a chamber are of the one that a law acts on.
QUANTITIES = {
    "velocity": "mm/s",
    "position": "mm",
    "piston_pressure": "bar",
    "rod_pressure": "bar",
    "pressure_drop": "bar",  # piston side less rod side
    "hydraulic_force": "N",
    "opening": "V",  # of the chamber's valve
    "drawn_flow": "l/min",  # from the supply into all valves
}
_OF_CYLINDER = tuple(QUANTITIES)[:6]
MOST_KNOTS, MOST_OF_TWO = 32, 8  # of a single quantity, and of each of two


def target_unit(target: Target) -> str:
    """Return the unit of a learned law's values."""
    units = {"flow": "l/min", "supply": "bar", "position": "%"}
    return units.get(target.partition("_")[0], "N")


def target_quantities(target: Target) -> tuple[str, ...]:
    """Return the quantities that a law of a target may depend on.

    The chambers' pressures follow that of the supply, so they are not among its causes.
    """
    others = {"supply": ("drawn_flow", "velocity"), "position_sensor": ("position",)}
    of_valve = ("opening",) if target.startswith("flow") else ()
    return others.get(target, (*_OF_CYLINDER, *of_valve))


class LearnedLaw(ConfigSection):
    """Unnamed law of one balance: a table over one or two quantities.

    It is linear between the knots and constant beyond the first and last.
    """

    adds_to: Target
    over: dict[str, tuple[float, ...]]  # knots [SI] by quantity
    # [SI]; over two quantities a row for each knot of the first
    values: tuple[float | tuple[float, ...], ...]

    @model_validator(mode="before")
    @classmethod
    def _in_si(cls, data: Any) -> Any:
        """Read knots and values with their units."""
        if not isinstance(data, Mapping) or not isinstance(data.get("over"), Mapping):
            return data
        if unknown := [name for name in data["over"] if name not in QUANTITIES]:
            raise ValueError(f"over.{unknown[0]}: known are {', '.join(QUANTITIES)}")
        unit = target_unit(data.get("adds_to", "force_test"))
        over = {name: _read(knots, QUANTITIES[name]) for name, knots in data["over"].items()}
        return {**data, "over": over, "values": _read(data.get("values"), unit)}

    @model_validator(mode="after")
    def _is_table(self) -> "LearnedLaw":
        if len(self.over) not in (1, 2):
            raise ValueError("over must have one or two quantities")
        known = target_quantities(self.adds_to)
        if others := [name for name in self.over if name not in known]:
            raise ValueError(f"{self.adds_to} has no over.{others[0]}, but {', '.join(known)}")
        for name, knots in self.over.items():
            most = MOST_KNOTS if len(self.over) == 1 else MOST_OF_TWO
            if not 2 <= len(knots) <= most or any(b <= a for a, b in pairwise(knots)):
                raise ValueError(f"over.{name} must have 2 to {most} ascending knots")
        shape = tuple(map(len, self.over.values()))
        rows = self.values if len(shape) == 2 else (self.values,)
        if len(shape) == 2 and len(rows) != shape[0]:
            raise ValueError(f"values must have {shape[0]} rows")
        if any(not isinstance(row, tuple) or len(row) != shape[-1] for row in rows):
            raise ValueError(f"values must have {shape[-1]} numbers for the knots of {name}")
        return self

    def section(self) -> dict[str, Any]:
        """Return the law as in a file."""
        return {
            "adds_to": self.adds_to,
            "over": {name: _written(knots, QUANTITIES[name]) for name, knots in self.over.items()},
            "values": _written(self.values, target_unit(self.adds_to)),
        }


def _read(values: Any, unit: str) -> Any:
    """Return nested lists of quantities in SI."""
    if isinstance(values, (list, tuple)):
        return tuple(_read(value, unit) for value in values)
    return to_si(values, unit)


def _written(values: Any, unit: str) -> Any:
    if isinstance(values, tuple):
        return [_written(value, unit) for value in values]
    return f"{values / parse_unit(unit).factor:.6g} {unit}"
