"""The bench file and the plant file.

``Plant`` has the physics, which the virtual rig simulates; ``Bench`` adds controllers, limits and
the tolerances of the instruments. A plant file has any keys of ``Plant``, which replace those of
the bench file one by one.
"""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from hbench.config import quantity as q
from hbench.config.effects import Effects, LearnedLaw
from hbench.config.files.loading import validate
from hbench.config.friction import FrictionPair
from hbench.config.identity import Identified
from hbench.config.oil.record import OilRecord
from hbench.config.quantity import ConfigSection
from hbench.config.sensors import Instruments, Sensors


class Bore(ConfigSection):
    """Diameters of a cylinder; ``rod_diameter`` is 0 without a rod."""

    piston_diameter: q.Length
    rod_diameter: q.Position = 0.0

    @property
    def area_piston_m2(self) -> float:
        """A_p."""
        return np.pi / 4 * self.piston_diameter**2

    @property
    def area_rod_m2(self) -> float:
        """A_r, the annulus."""
        return np.pi / 4 * (self.piston_diameter**2 - self.rod_diameter**2)

    @model_validator(mode="after")
    def _rod_fits(self) -> "Bore":
        if self.rod_diameter >= self.piston_diameter:
            raise ValueError("rod_diameter must be smaller than piston_diameter")
        return self


class Cylinder(Bore):
    """One cylinder; ``rod_diameter`` is 0 for equal areas, as with a rod on both sides."""

    rod_diameter: q.Position
    stroke: q.Length
    dead_volume_piston: q.Volume
    dead_volume_rod: q.Volume
    offset: q.Offset = 0.0  # of its piston against the test cylinder's (x_0)


class MovingMass(ConfigSection):
    """Moving masses on both sides of the load cell."""

    test: q.Mass
    load: q.Mass


class Oil(OilRecord):
    """The oil with its effective bulk modulus. The plant's density does not change."""

    bulk_modulus: q.BulkModulus
    density: q.Density
    # In the tank of the virtual rig at the session's start; ``effects.oil_warming`` adds to it.
    temperature: q.Temperature = 313.15


class Pump(ConfigSection):
    """Pump with pressure compensator, relief valve and line (see model/supply.py)."""

    flow: q.Flow  # maximum
    cut_off: q.Pressure  # at which it delivers nothing
    # Pressure range below cut_off over which the pump swivels out.
    band: Annotated[float, q.quantity("bar", gt=0, le=1e8)]
    compensator_lag: q.TimeConstant
    swash_lag: q.TimeConstant
    relief: q.Pressure
    relief_gain: Annotated[float, q.quantity("l/min/bar", ge=0, le=1e-6)]
    leakage: Annotated[float, q.quantity("l/min/bar", ge=0, le=1e-6)]
    capacity: Annotated[float, q.quantity("cm^3/bar", gt=0, le=1e-6)]  # of line and accumulator


class Supply(ConfigSection):
    """Supply and tank pressure; the supply is constant unless ``pump`` is given."""

    pressure: q.PositivePressure
    tank: q.Pressure
    pump: Pump | None = None


class Valve(ConfigSection):
    """The three identical servo valves: static gain 2.15, dynamics 2.16."""

    gain: Annotated[float, q.quantity("m^2/V", gt=0, le=1e-3)]
    # Large piloted valves have 2 Hz, the fastest servo valves 1 kHz; above 3 kHz the plant's steps
    # of 0.1 ms are unstable.
    bandwidth: Annotated[float, q.quantity("Hz", ge=1, le=3000)]
    damping: q.Number
    limit: Annotated[float, q.quantity("V", gt=0, le=10)]  # the board's converter has +-10 V


class EndStop(ConfigSection):
    """The cylinder heads as a stiff spring and damper."""

    stiffness: Annotated[float, q.quantity("N/m", gt=0, le=1e10)]
    damping: Annotated[float, q.quantity("N s/m", ge=0, le=1e7)]


class Plant(ConfigSection):
    """The physics of a bench."""

    test_cylinder: Cylinder
    load_cylinder: Cylinder
    moving_mass: MovingMass
    oil: Oil
    supply: Supply
    valve: Valve
    friction: FrictionPair
    end_stop: EndStop
    sensors: Sensors | None = None  # None: readings are in SI, as in imported logs
    effects: Effects = Field(default_factory=dict)
    learned: tuple[LearnedLaw, ...] = ()


class VelocityLoop(ConfigSection):
    """Gain and time constant of the velocity PI (equation 4.36)."""

    gain: Annotated[float, q.quantity("V/m", gt=0, le=1e6)]
    time_constant: q.TimeConstant


class PressureLoop(ConfigSection):
    """Gain and time constant of a pressure PI (equation 4.36)."""

    gain: Annotated[float, q.quantity("V/(Pa s)", gt=0, le=1)]
    time_constant: q.TimeConstant


class Feedforward(ConfigSection):
    """Velocity feedforward of the pressure loops (equations 4.27 and 4.28)."""

    enabled: bool
    rod: Annotated[float, q.quantity("V s/m", ge=0, le=1e4)]
    piston: Annotated[float, q.quantity("V s/m", ge=0, le=1e4)]


class LoadFriction(ConfigSection):
    """Friction of the load cylinder as the board computes it (equation 3.2)."""

    coulomb: q.Force
    stiction: q.Force
    stribeck_velocity: q.Speed
    viscous: Annotated[float, q.quantity("N s/m", ge=0, le=1e7)]


class LoadControl(ConfigSection):
    """What the load piston's valve controls, so that the load cylinder's friction is or is not
    part of the force between the cylinders (see firmware/core/control.h).
    """

    by: Literal["pressures", "load_cell", "friction_law"] = "pressures"
    time_constant: q.TimeConstant = 0.1  # of the loop around the load cell
    friction: LoadFriction | None = None

    @model_validator(mode="after")
    def _law_has_friction(self) -> "LoadControl":
        if (self.by == "friction_law") != (self.friction is not None):
            raise ValueError("'friction' belongs to 'by: friction_law'")
        return self


class Controllers(ConfigSection):
    """Controllers of the board and their rates."""

    rate: q.Frequency
    log_rate: q.Frequency
    velocity: VelocityLoop
    rod_pressure: PressureLoop
    piston_pressure: PressureLoop
    velocity_filter: q.TimeConstant  # tau_c of D.11
    pressure_filter: q.TimeConstant  # tau of D.29
    feedforward: Feedforward
    load: LoadControl = LoadControl()
    pressure_slew: q.PressureRate
    return_speed: q.Speed  # back to the start position
    acceleration: q.BoardAcceleration  # default of a run, and for braking


class Limits(ConfigSection):
    """Limits at which the board stops itself: valves to neutral, cause latched."""

    travel_min: q.Position
    travel_max: q.Position
    pressure_max: Annotated[float, q.quantity("bar", gt=0, le=1e8)]
    speed_max: Annotated[float, q.quantity("mm/s", gt=0, le=0.6)]  # a log word holds 0.65 m/s
    # With closed valves the piston moves on by its speed times this.
    stopping_time: Annotated[float, q.quantity("ms", ge=0, le=1)]
    speed_error: q.Speed  # from the reference ...
    speed_error_time: Annotated[float, q.quantity("s", ge=0, le=60)]  # ... for longer than this
    # Longest time without a message of the host, which repeats a request for 2 s.
    heartbeat: Annotated[float, q.quantity("s", ge=1, le=60)]

    @property
    def highest_reference(self) -> float:
        """Highest speed of a schedule [m/s], below the limit at which the board stops."""
        return 0.9 * self.speed_max


class Programmer(ConfigSection):
    """External program that flashes the board, e.g. over JTAG."""

    command: tuple[str, ...] = Field(min_length=1)  # program and arguments; {image} is the file
    timeout: q.Duration

    @model_validator(mode="after")
    def _takes_the_image(self) -> "Programmer":
        if not any("{image}" in part for part in self.command[1:]):
            raise ValueError("command must have {image} in one of its arguments")
        return self


class Bench(Plant, Identified):
    """Bench: physics, controllers, limits and instruments."""

    name: str
    sensors: Sensors
    controllers: Controllers
    limits: Limits
    instruments: Instruments
    programmer: Programmer | None = None

    @model_validator(mode="after")
    def _consistent(self) -> "Bench":
        low, high, stroke = (
            f"{key} = {1e3 * length:g} mm"
            for key, length in (
                ("limits.travel_min", self.limits.travel_min),
                ("limits.travel_max", self.limits.travel_max),
                ("test_cylinder.stroke", self.test_cylinder.stroke),
            )
        )
        if self.limits.travel_min >= self.limits.travel_max:
            raise ValueError(f"{low} must be less than {high}")
        if self.limits.travel_max > self.test_cylinder.stroke:
            raise ValueError(f"{high} lies beyond {stroke}; lower it, and the schedules' travel")
        head = self.load_cylinder.stroke - self.load_cylinder.offset
        if self.limits.travel_max > head:
            raise ValueError(
                f"{high} lies beyond the load cylinder's head at {1e3 * head:g} mm "
                "(load_cylinder.stroke less load_cylinder.offset)"
            )
        if self.controllers.return_speed > self.limits.highest_reference:
            raise ValueError(
                f"controllers.return_speed = {1e3 * self.controllers.return_speed:g} mm/s is above "
                f"90 % of limits.speed_max = {1e3 * self.limits.speed_max:g} mm/s"
            )
        divider = self.controllers.rate / self.controllers.log_rate
        if abs(divider - round(divider)) > 1e-9 or not 1 <= divider <= 65535:
            raise ValueError(
                "controllers.rate must be a whole multiple of controllers.log_rate, up to 65535"
            )
        return self


def parse_bench(data: dict[str, Any], source: str) -> Bench:
    """Check the mapping of a bench file. Raises ``ConfigError``."""
    return validate(Bench, data, source)


def parse_plant(bench_data: dict[str, Any], plant_data: dict[str, Any], source: str) -> Plant:
    """Return the bench's physics with the values of a plant file. Raises ``ConfigError``.

    Of a whole bench file, which has a name, the physics alone counts.
    """
    return validate(Plant, plant_sections(bench_data, plant_data, source), source)


def plant_sections(
    bench_data: dict[str, Any], plant_data: dict[str, Any], source: str
) -> dict[str, Any]:
    """Return the mapping that ``parse_plant`` reads. Raises ``ConfigError``."""
    if "name" in plant_data:
        parse_bench(plant_data, source)
        return _physics(plant_data)
    return merge(_physics(bench_data), plant_data)


def _physics(bench_data: dict[str, Any]) -> dict[str, Any]:
    return {key: bench_data[key] for key in Plant.model_fields if key in bench_data}


def merge(base: dict[str, Any], over: dict[str, Any]) -> dict[str, Any]:
    """Return ``base`` with the values of ``over``, merged key by key at every depth.

    A section with another ``law`` replaces the whole section, since its keys have other meanings.
    """
    merged = dict(base)
    for key, value in over.items():
        below = base.get(key)
        merged[key] = value
        if isinstance(value, dict) and isinstance(below, dict):
            if value.get("law", below.get("law")) == below.get("law"):
                merged[key] = merge(below, value)
    return merged
