"""Friction of one cylinder in a bench or plant file: one class for each law (section 3.2)."""

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from hbench.config import quantity as q
from hbench.config.files.loading import validate
from hbench.config.quantity import ConfigSection

Viscous = Annotated[float, q.quantity("N s/m", ge=0, le=1e7)]
Slope = Annotated[float, q.quantity("N s/m", ge=-1e7, le=1e7)]
BristleStiffness = Annotated[float, q.quantity("N/m", gt=0, le=1e8)]
SealFriction = Annotated[float, q.quantity("N/bar", ge=0, le=1e-2)]


class _Friction(ConfigSection):
    """Keys of every law."""

    scatter: q.Ratio = 0.0  # standard deviation of the level from stroke to stroke


class _Seals(_Friction):
    """Terms after equation 3.7, and viscous friction."""

    viscous: Viscous = 0.0
    piston_seal: SealFriction = 0.0  # per |P_p - P_r|
    rod_seal: SealFriction = 0.0  # per P_r


class _Stribeck(_Seals):
    """The steady curve of equation 3.13."""

    coulomb: q.Force
    stiction: q.Force
    stribeck_velocity: q.Speed
    stribeck_exponent: Annotated[q.Number, Field(le=20)] = 1.0


class Tustin(_Stribeck):
    """Equation 3.2."""

    law: Literal["tustin"]


class LuGre(_Stribeck):
    """Equations 3.8 to 3.12."""

    law: Literal["lugre"]
    bristle_stiffness: BristleStiffness = 3e5  # sigma_0
    bristle_damping: Viscous = 0.0  # sigma_1


class Leuven(_Stribeck):
    """The modified Leuven law, equations 3.14 to 3.20."""

    law: Literal["leuven"]
    elements: tuple[q.Force, ...] = Field(min_length=1, max_length=20)  # theta_i
    presliding: q.Length  # Delta_max: deflection at which the last element slips
    shape: q.Number = 1.0  # n
    bristle_damping: Viscous = 0.0  # sigma_1

    @model_validator(mode="after")
    def _carries_the_stiction(self) -> "Leuven":
        carried = sum(self.elements)
        if carried < self.stiction:
            raise ValueError(
                f"the elements carry {carried:g} N, less than stiction = {self.stiction:g} N, so "
                "friction never reaches the steady curve; increase them"
            )
        return self


class Lines(ConfigSection):
    """Two straight lines of friction over speed, each by its value at zero and its slope."""

    low_force: q.Force
    low_slope: Slope
    high_force: q.Force
    high_slope: Slope

    @model_validator(mode="after")
    def _low_line_is_higher_at_rest(self) -> "Lines":
        if self.low_force < self.high_force or self.low_slope > self.high_slope:
            raise ValueError(
                "low_force must be at least high_force, and low_slope at most high_slope, so that "
                "the low-speed line begins above the high-speed line and falls below it"
            )
        return self


class MartonLantos(_Friction):
    """Equations 3.3 to 3.6, for either direction."""

    law: Literal["marton_lantos"]
    extend: Lines
    retract: Lines


class PressureBased(_Seals):
    """Equation 3.7, for both signs of velocity."""

    law: Literal["pressure_based"]
    stribeck_force: q.Force  # k1
    stribeck_rate: Annotated[float, q.quantity("s/m", ge=-1e4, le=100)]  # k2


Friction = Annotated[
    Tustin | LuGre | Leuven | MartonLantos | PressureBased, Field(discriminator="law")
]


class FrictionPair(ConfigSection):
    """Friction of both cylinders."""

    test: Friction
    load: Friction


class _One(ConfigSection):
    friction: Friction


def parse_friction(data: dict[str, Any], source: str) -> Friction:
    """Check the mapping of one cylinder's friction. Raises ``ConfigError``."""
    return validate(_One, {"friction": data}, source).friction
