"""Speed sequences of a steady experiment, one class per strategy (section 5.6.1)."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from hbench.config import quantity as q
from hbench.config.quantity import ConfigSection


class PolynomialSpeeds(ConfigSection):
    """Speeds v_i = a i + b i^2 (i = 1..count) from ``first`` to ``last``: dense where slow.

    The source's own spacing (section 5.3), and the default.
    """

    strategy: Literal["polynomial"] = "polynomial"
    first: q.Speed
    last: q.Speed
    count: q.WholeNumber = Field(ge=2, le=100)

    @model_validator(mode="after")
    def _rises(self) -> "PolynomialSpeeds":
        if not self.count * self.first <= self.last:
            raise ValueError(
                "steps would not grow: 'last' must be at least count * first "
                f"= {self.count * self.first:g} m/s, or give the speeds as a list"
            )
        return self


class LinearSpeeds(ConfigSection):
    """Equal steps from ``first`` to ``last``."""

    strategy: Literal["linear"]
    first: q.Speed
    last: q.Speed
    count: q.WholeNumber = Field(ge=2, le=1000)

    @model_validator(mode="after")
    def _rises(self) -> "LinearSpeeds":
        if not self.first < self.last:
            raise ValueError("'first' must be less than 'last'")
        return self


class SlopeAdjustedSpeeds(ConfigSection):
    """Equal small steps to ``transition``, then equal large ones to ``last``.

    Friction is expected to turn from nonlinear to linear at ``transition``. Each side has half of
    the steps; the slow side has one more of an odd number.
    """

    strategy: Literal["slope_adjusted"]
    first: q.Speed
    transition: q.Speed
    last: q.Speed
    count: q.WholeNumber = Field(ge=3, le=1000)

    @model_validator(mode="after")
    def _rises(self) -> "SlopeAdjustedSpeeds":
        if not self.first < self.transition < self.last:
            raise ValueError("'first', 'transition' and 'last' must rise in this order")
        return self


class AdaptiveSpeeds(ConfigSection):
    """Speeds chosen from the friction measured so far (``hbench.experiment.adaptive``)."""

    strategy: Literal["adaptive"]
    first: q.Speed
    last: q.Speed
    min_step: q.Speed
    max_step: q.Speed
    # Largest departure of friction from interpolation between neighbouring speeds.
    tolerance: Annotated[float, q.quantity("N", gt=0, le=1e6)]

    @model_validator(mode="after")
    def _has_room(self) -> "AdaptiveSpeeds":
        if not self.first + self.min_step <= self.last:
            raise ValueError("'last' must be at least 'first' and one 'min_step'")
        if not 2 * self.min_step <= self.max_step:
            raise ValueError("'max_step' must be at least twice 'min_step'")
        return self


_STRATEGIES = ("polynomial", "linear", "slope_adjusted", "adaptive")


def _strategy(value: Any) -> str | None:
    if isinstance(value, list | tuple):
        return "list"
    given = value.get("strategy", "polynomial") if isinstance(value, dict) else None
    return given if isinstance(given, str) else None


Velocities = Annotated[
    Annotated[PolynomialSpeeds, Tag("polynomial")]
    | Annotated[LinearSpeeds, Tag("linear")]
    | Annotated[SlopeAdjustedSpeeds, Tag("slope_adjusted")]
    | Annotated[AdaptiveSpeeds, Tag("adaptive")]
    | Annotated[tuple[q.Speed, ...], Field(min_length=1, max_length=1000), Tag("list")],
    Discriminator(
        _strategy,
        custom_error_type="strategy",
        custom_error_message=f"give a list of speeds, or 'strategy': {', '.join(_STRATEGIES)}",
    ),
]
