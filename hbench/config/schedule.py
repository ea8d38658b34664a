"""The schedule file: which runs to make, and when a run counts as steady."""

from typing import Any, Literal

from pydantic import Field, model_validator

from hbench.config import quantity as q
from hbench.config.loading import validate
from hbench.config.quantity import Section


class Velocities(Section):
    """Speeds v_i = a i + b i^2 (i = 1..count) from ``first`` to ``last``: dense where slow.

    The source's own spacing (section 5.3 and 5.6.1).
    """

    first: q.Speed
    last: q.Speed
    count: int = Field(ge=2, le=100)

    @model_validator(mode="after")
    def _rises(self) -> "Velocities":
        if not self.count * self.first <= self.last:
            raise ValueError(
                "steps would not grow: 'last' must be at least count * first "
                f"= {self.count * self.first:g} m/s, or give the speeds as a list"
            )
        return self


class Travel(Section):
    """The piece of the stroke a run may use; a retracting run goes from ``end`` to ``start``."""

    start: q.Position
    end: q.Position

    @model_validator(mode="after")
    def _ordered(self) -> "Travel":
        if not self.start < self.end:
            raise ValueError("'start' must be less than 'end'")
        return self


class Steady(Section):
    """Runs at constant velocity and load (section 5.3)."""

    kind: Literal["steady"]
    direction: Literal["extend", "retract"]
    p_lr: q.Pressure  # reference of the load cylinder's rod side
    loads: tuple[q.SignedForce, ...] = Field(
        min_length=1, max_length=50
    )  # positive opposes extension
    velocities: Velocities | tuple[q.Speed, ...]
    trials: int = Field(default=3, ge=1, le=20)
    travel: Travel
    acceleration: q.Acceleration
    hold: q.Duration  # at rest under load before each run
    window: q.quantity("s", gt=0.1, le=60)  # longest steady window


class Screening(Section):
    """When a run counts. Every limit that rejects a run stands here."""

    settle_time: q.Duration = 0.3  # from reaching the reference to the window
    settle_travel: q.Length = 0.02  # and this much travel: about ten lengths of presliding
    min_window: q.Duration = 0.3
    high_speed: q.Speed = 0.15  # the source's limit holds above this
    high_speed_error: q.Speed = 0.002
    low_speed_error: q.Speed = 0.0005  # below it: the larger of the absolute ...
    low_speed_error_relative: q.Ratio = 0.03  # ... and the relative limit
    speed_ripple: q.Speed = 0.002  # standard deviation of speed over 0.1 s means ...
    speed_ripple_relative: q.Ratio = 0.05  # ... the larger of the two
    speed_oscillation: q.Speed = 0.003  # standard deviation of the controller's velocity ...
    speed_oscillation_relative: q.Ratio = 0.05  # ... the larger of the two
    friction_drift: q.Force = 40.0  # change of friction over the window ...
    friction_drift_relative: q.Ratio = 0.10  # ... the larger of the two
    end_stop_margin: q.Length = 0.002
    max_gap: q.Duration = 0.1  # longest step between two samples of a foreign log


class Schedule(Section):
    """A campaign to run: experiments in order."""

    name: str
    bench: str | None = None  # path of the bench file, from the schedule's own folder
    experiments: tuple[Steady, ...] = Field(min_length=1, max_length=100)
    screening: Screening = Screening()


def parse_schedule(data: dict[str, Any], source: str) -> Schedule:
    """Check the mapping of a schedule file. Raises ``ConfigError``."""
    return validate(Schedule, data, source)
