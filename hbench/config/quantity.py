"""Field types of the configuration: quantities with a unit and a range."""

import operator
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from hbench.units import from_si, to_si

_LIMITS = {
    "gt": (operator.gt, "greater than"),
    "ge": (operator.ge, "at least"),
    "lt": (operator.lt, "less than"),
    "le": (operator.le, "at most"),
}


def quantity(unit: str, **limits: float) -> BeforeValidator:
    """Return a validator that reads a quantity such as ``"150 bar"`` as a float in SI.

    ``unit`` is the unit of messages. ``limits`` (``gt``, ``ge``, ``lt``, ``le``) are in SI.
    """

    def read(value: object) -> float:
        si = to_si(value, unit)
        for name, limit in limits.items():
            compare, words = _LIMITS[name]
            if not compare(si, limit):
                raise ValueError(f"must be {words} {from_si(limit, unit):.6g} {unit}")
        return si

    return BeforeValidator(read)


def _as_text(value: object) -> object:
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return str(value) if is_number else value


def _no_truth_value(value: object) -> object:
    """Refuse true and false, which pydantic takes as 1 and 0."""
    if isinstance(value, bool):
        raise ValueError("must be a number; YAML reads yes, no, on and off as true or false")
    return value


# A quantity whose dimension is checked later; a number without a unit is refused then.
QuantityText = Annotated[str, BeforeValidator(_as_text)]


class ConfigSection(BaseModel):
    """Section of a configuration file: refuses unknown keys, and is frozen."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


Length = Annotated[float, quantity("mm", gt=0, le=20)]
Position = Annotated[float, quantity("mm", ge=0, le=20)]
Offset = Annotated[float, quantity("mm", ge=-20, le=20)]
Tolerance = Annotated[float, quantity("mm", ge=0, le=0.01)]
Angle = Annotated[float, quantity("deg", ge=0, le=0.5)]
Flow = Annotated[float, quantity("l/min", gt=0, le=1)]
Volume = Annotated[float, quantity("cm^3", ge=0, le=1)]
Mass = Annotated[float, quantity("kg", gt=0, le=1e5)]
Density = Annotated[float, quantity("kg/m^3", gt=100, le=2000)]
BulkModulus = Annotated[float, quantity("bar", ge=1e6, le=5e9)]  # water glycol: 3.5e9
Pressure = Annotated[float, quantity("bar", ge=0, le=1e8)]
PositivePressure = Annotated[float, quantity("bar", gt=0, le=1e8)]
PressureRate = Annotated[float, quantity("bar/s", ge=1e5, le=1e10)]
Speed = Annotated[float, quantity("mm/s", ge=1e-9, le=10)]
Velocity = Annotated[float, quantity("mm/s", ge=-10, le=10)]
Acceleration = Annotated[float, quantity("m/s^2", ge=1e-4, le=100)]
BoardAcceleration = Annotated[float, quantity("m/s^2", ge=0.01, le=100)]  # the firmware's limits
Force = Annotated[float, quantity("N", ge=0, le=1e7)]
PositiveForce = Annotated[float, quantity("N", gt=0, le=1e7)]
SignedForce = Annotated[float, quantity("N", ge=-1e7, le=1e7)]
Duration = Annotated[float, quantity("s", ge=0, le=3600)]
TimeConstant = Annotated[float, quantity("ms", ge=0, le=60)]
Frequency = Annotated[float, quantity("Hz", gt=0, le=1e6)]
Voltage = Annotated[float, quantity("V", ge=1e-6, le=100)]
NoiseVoltage = Annotated[float, quantity("mV", ge=0, le=1)]
SignedVoltage = Annotated[float, quantity("V", ge=-100, le=100)]
Temperature = Annotated[float, quantity("degC", ge=193.15, le=473.15)]  # -80 to 200 degC
Ratio = Annotated[float, quantity("%", ge=0, le=1)]
WholeNumber = Annotated[int, BeforeValidator(_no_truth_value)]
AnyNumber = Annotated[float, BeforeValidator(_no_truth_value)]
Number = Annotated[AnyNumber, Field(gt=0, allow_inf_nan=False)]
