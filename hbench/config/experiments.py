"""Experiments of a schedule file, one class per velocity profile (chapter 5 of the source)."""

from typing import Annotated, Any, Literal, get_args

from pydantic import Discriminator, Field, Tag, model_validator

from hbench.config import quantity as q
from hbench.config.quantity import ConfigSection
from hbench.config.velocities import AdaptiveSpeeds, Velocities
from hbench.records import KINDS, Direction

NOT_ADAPTIVE = (
    "order: {order} is not possible with adaptive velocities, which need all trials of a speed to "
    "choose the next"
)


class Travel(ConfigSection):
    """Part of the stroke that a run may use; a retracting run goes from ``end`` to ``start``."""

    start: q.Position
    end: q.Position

    @model_validator(mode="after")
    def _ordered(self) -> "Travel":
        if not self.start < self.end:
            raise ValueError("'start' must be less than 'end'")
        return self


class ExperimentBase(ConfigSection):
    """Keys that all kinds share."""

    kind: str  # its row of KINDS chooses the class
    label: str = ""  # distinguishes series of one campaign
    trials: q.WholeNumber = Field(default=3, ge=1, le=20)
    # Trials of a reference one after the other, or as passes over all references.
    order: Literal["row", "passes"] = "row"


class LoadedExperiment(ExperimentBase):
    """Experiment under load."""

    p_lr: q.Pressure  # reference of the load cylinder's rod side
    # Of F_L; positive opposes extension.
    loads: tuple[q.SignedForce, ...] = Field(min_length=1, max_length=50)


class HeldExperiment(LoadedExperiment):
    """Experiment under load with the same rest before each run."""

    hold: q.Duration  # at rest under load before each run


class Steady(HeldExperiment):
    """Runs at constant velocity and load (section 5.3)."""

    direction: Direction
    velocities: Velocities
    travel: Travel
    acceleration: q.Acceleration
    window: Annotated[float, q.quantity("s", gt=0.1, le=60)]  # longest steady window

    @model_validator(mode="after")
    def _follows_friction(self) -> "Steady":
        if isinstance(self.velocities, AdaptiveSpeeds):
            if self.order == "passes":
                raise ValueError(NOT_ADAPTIVE.format(order=self.order))
            if self.trials < 2:
                raise ValueError(
                    "adaptive velocities need trials: 2 or more, to distinguish noise from "
                    "curvature"
                )
        return self


class Ramp(HeldExperiment):
    """Velocity ramps from rest to ``speed``, or to the travel's end, at each acceleration (5.3)."""

    direction: Direction
    speed: q.Speed
    accelerations: tuple[q.Acceleration, ...] = Field(min_length=1, max_length=20)
    travel: Travel


class Settling(ConfigSection):
    """Condition that ends a triangle early: two cycles in a row changed by at most ``within``.

    The quantity is a cycle's mean: ``friction`` falls while the oil warms up; ``speed_error``,
    the lag behind the reference, falls while trapped air leaves.
    """

    quantity: Literal["friction", "speed_error"]
    within: q.Ratio


class Triangle(HeldExperiment):
    """Triangular velocity between +speed and -speed over the whole travel (section 5.2).

    Its slope is speed^2 / (end - start). For hysteresis, and to warm up and purge the bench.
    """

    speed: q.Speed
    cycles: q.WholeNumber = Field(ge=1, le=1000)  # at most
    until: Settling | None = None
    travel: Travel
    trials: q.WholeNumber = Field(default=1, ge=1, le=20)


class Steps(HeldExperiment):
    """Velocity steps (section 5.4); the first level leads away from the start position."""

    levels: tuple[q.Velocity, ...] = Field(min_length=1, max_length=50)
    dwell: Annotated[float, q.quantity("s", gt=0, le=600)]
    acceleration: q.Acceleration = 100.0  # of the reference: practically a step
    travel: Travel


class ProfilePiece(ConfigSection):
    """Segment of a velocity profile: to a velocity at a slope, then constant."""

    velocity: q.Velocity
    acceleration: q.Acceleration
    duration: Annotated[float, q.quantity("s", gt=0, le=600)]


class Verification(HeldExperiment):
    """Velocity profile with steady and unsteady parts, to verify friction models (section 5.5)."""

    profile: tuple[ProfilePiece, ...] = Field(min_length=1, max_length=100)
    travel: Travel


class Hold(HeldExperiment):
    """Rest under load with all valves closed: chamber pressures decay by leakage alone."""

    positions: tuple[q.Position, ...] = Field(min_length=1, max_length=50)
    duration: Annotated[float, q.quantity("s", gt=0, le=3600)]


class Breakaway(LoadedExperiment):
    """Push on a resting piston until it moves: F_T rises at a given rate after each dwell."""

    direction: Direction
    position: q.Position
    # At rest under load, up to a day.
    dwells: tuple[Annotated[float, q.quantity("s", ge=0, le=86400)], ...] = Field(
        min_length=1, max_length=20
    )
    rate: Annotated[float, q.quantity("N/s", ge=1, le=1e6)]
    rise: Annotated[float, q.quantity("N", gt=0, le=1e6)]  # at most; the push then ends
    displacement: Annotated[float, q.quantity("mm", ge=1e-4, le=0.1)] = 0.02  # ends the push


class Check(ExperimentBase):
    """Zero check of the sensors: with the supply off, all chambers are vented, then closed."""

    # Of the levelled chambers; by default the tank's. Its error is at most the uncertainty.
    pressure: q.Pressure | None = None
    uncertainty: q.Pressure = 1e4
    load_cell: Literal["coupled", "free"] = "coupled"  # free: it carries no force
    vent: Annotated[float, q.quantity("s", ge=1, le=600)] = 10.0
    duration: Annotated[float, q.quantity("s", ge=1, le=600)] = 2.0  # closed
    trials: q.WholeNumber = Field(default=1, ge=1, le=20)


def _profile(experiment: Any) -> str | None:
    """Return the velocity profile of an experiment's kind; None for an unknown or missing kind."""
    if isinstance(experiment, dict):
        kind = experiment.get("kind")
    else:  # a section, or anything that a file has in its place
        kind = getattr(experiment, "kind", None)
    return KINDS[kind].profile if isinstance(kind, str) and kind in KINDS else None


_OfProfile = (
    Annotated[Steady, Tag("constant_speed")]
    | Annotated[Ramp, Tag("acceleration_ramp")]
    | Annotated[Triangle, Tag("triangle")]
    | Annotated[Steps, Tag("velocity_steps")]
    | Annotated[Verification, Tag("stretches")]
    | Annotated[Hold, Tag("at_rest")]
    | Annotated[Breakaway, Tag("force_ramp")]
    | Annotated[Check, Tag("levelled")]
)
PROFILE_SECTIONS = {tag.tag: section for section, tag in map(get_args, get_args(_OfProfile))}
_NAMES = ", ".join(kind.name for kind in KINDS.values() if kind.profile in PROFILE_SECTIONS)
ExperimentSection = Annotated[
    _OfProfile,
    Discriminator(
        _profile,
        custom_error_type="unknown_kind",
        custom_error_message=f"must be one of {_NAMES}",
    ),
]
