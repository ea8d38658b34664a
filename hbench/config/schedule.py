"""The schedule file: experiments, and the limits of the screening."""

from typing import Any, Literal

from pydantic import Field, model_validator

from hbench.config import quantity as q
from hbench.config.experiments import NOT_ADAPTIVE, ExperimentSection, Steady
from hbench.config.files.loading import validate
from hbench.config.identity import Identified
from hbench.config.quantity import ConfigSection
from hbench.config.velocities import AdaptiveSpeeds


class Screening(ConfigSection):
    """Limits of the screening; no other limit rejects a run."""

    settle_time: q.Duration = 0.3  # from reaching the reference to the window
    settle_travel: q.Length = 0.02  # and this much travel: about ten lengths of presliding
    min_window: q.Duration = 0.3
    high_speed: q.Speed = 0.15  # the source's limit holds above this
    high_speed_error: q.Speed | None = 0.002  # None: the limits below it hold above it too
    low_speed_error: q.Speed = 0.0005  # below it: the larger of the absolute ...
    low_speed_error_relative: q.Ratio = 0.03  # ... and the relative limit
    speed_ripple: q.Speed = 0.002  # standard deviation of speed over 0.1 s means ...
    speed_ripple_relative: q.Ratio = 0.05  # ... the larger of the two
    speed_oscillation: q.Speed = 0.003  # of the velocity, or of the speed over 20 ms ...
    speed_oscillation_relative: q.Ratio = 0.05  # ... the larger of the two
    friction_drift: q.Force = 40.0  # change of friction over the window ...
    friction_drift_relative: q.Ratio = 0.10  # ... the larger of the two
    end_stop_margin: q.Length = 0.002
    max_gap: q.Duration = 0.1  # longest step between two samples of a foreign log
    # Non-steady runs: speed over 0.1 s against its reference, root mean square ...
    tracking_error: q.Speed = 0.005
    tracking_error_relative: q.Ratio = 0.05  # ... of the top speed; the larger of the two
    rest_travel: q.Length = 0.0005  # of the piston in a hold

    def speed_limit(self, v_ref_m_s: float) -> float:
        """Return how far a mean speed may be off its reference [m/s]."""
        speed = abs(v_ref_m_s)
        if speed > self.high_speed and self.high_speed_error is not None:
            return self.high_speed_error
        return max(self.low_speed_error, self.low_speed_error_relative * speed)

    def ripple_limit(self, v_ref_m_s: float) -> float:
        """Return the largest standard deviation of the speed over 0.1 s means [m/s]."""
        return max(self.speed_ripple, self.speed_ripple_relative * abs(v_ref_m_s))


class Schedule(Identified):
    """Schedule of a campaign: experiments in order, or one trial of every point per pass.

    ``experiments`` makes them one after the other. ``passes`` and ``random`` make one trial of all
    points, then the next trial of all points, so that the trials of a point are far apart in time
    and drift appears as their scatter. ``passes`` keeps the order of the schedule in each pass;
    ``random`` draws the order of each pass (randomised complete blocks), so that drift within a
    pass does not depend on speed or load either.
    """

    name: str
    bench: str | None = None  # path of the bench file, from the schedule's own folder
    order: Literal["experiments", "passes", "random"] = "experiments"
    # Of order: random; the same seed gives the same order.
    seed: q.WholeNumber = Field(default=1, ge=0)
    experiments: tuple[ExperimentSection, ...] = Field(min_length=1, max_length=100)
    screening: Screening = Screening()

    @model_validator(mode="after")
    def _one_order(self) -> "Schedule":
        if "seed" in self.model_fields_set and self.order != "random":
            raise ValueError(
                f"seed: applies to order: random only; order is {self.order}; remove this key"
            )
        if self.order == "experiments":
            return self
        for number, experiment in enumerate(self.experiments):
            if "order" in experiment.model_fields_set:
                raise ValueError(
                    f"experiments.{number}.order: the schedule's order: {self.order} applies to "
                    "all experiments; remove this key"
                )
            if isinstance(experiment, Steady) and isinstance(experiment.velocities, AdaptiveSpeeds):
                message = NOT_ADAPTIVE.format(order=self.order)
                raise ValueError(f"experiments.{number}.velocities: {message}")
        return self


def parse_schedule(data: dict[str, Any], source: str) -> Schedule:
    """Check the mapping of a schedule file. Raises ``ConfigError``."""
    return validate(Schedule, data, source)
