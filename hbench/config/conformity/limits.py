"""The file of limits: which quantities of a product are limited, and how a decision is made."""

from typing import Annotated, Any, get_args

from pydantic import Field, model_validator

from hbench.config import quantity as q
from hbench.config.files.loading import validate
from hbench.config.identity import Text
from hbench.config.quantity import ConfigSection
from hbench.records.conformity.acceptance import LimitQuantity, Requirement, Rule
from hbench.records.motions import Leak
from hbench.records.runs import Direction
from hbench.units import to_si

# Units in which a limit may be stated: the first that has the dimension is that of the reports.
_UNITS: dict[str, tuple[str, ...]] = {
    "friction": ("N", "bar"),
    "breakaway": ("N", "bar"),
    "efficiency": ("%",),
    "leakage": ("ml/min",),
    "speed_ripple": ("%",),
    "drift": ("%",),
}
_SERIES = ("label", "direction", "load", "p_lr")
_KEYS: dict[str, tuple[str, ...]] = {  # that choose the runs of a quantity
    "friction": (*_SERIES, "speed"),
    "breakaway": (*_SERIES, "dwell"),
    "efficiency": (*_SERIES, "speed"),
    "leakage": ("label", "leak", "pressure"),
    "speed_ripple": (*_SERIES, "speed"),
    "drift": (),
}
_POSITIVE = {  # quantities that are never negative, and why
    "friction": "friction opposes the motion and is positive in both directions",
    "breakaway": "a breakaway force is positive in both directions",
    "efficiency": "an efficiency is between 0 and 100 %",
    "leakage": "a leakage is not negative",
    "speed_ripple": "a standard deviation is positive",
}
assert set(_UNITS) == set(_KEYS) == set(get_args(LimitQuantity))
_CHOOSING = sorted({key for keys in _KEYS.values() for key in keys})


class Limit(ConfigSection):
    """Limits of one quantity. A limit in bar of a force is that on the driving area."""

    quantity: LimitQuantity
    min: q.QuantityText | None = None
    max: q.QuantityText | None = None
    name: Text = ""
    label: Text | None = None
    direction: Direction | None = None
    load: q.SignedForce | None = None
    p_lr: q.Pressure | None = None
    speed: q.Speed | None = None
    dwell: Annotated[float, q.quantity("s", ge=0, le=86400)] | None = None
    leak: Leak | None = None
    pressure: q.Pressure | None = None

    @model_validator(mode="after")
    def _fits_the_quantity(self) -> "Limit":
        allowed = _KEYS[self.quantity]
        for key in _CHOOSING:
            if getattr(self, key) is not None and key not in allowed:
                raise ValueError(f"a limit of {self.quantity} has no key {key!r}")
        if self.min is None and self.max is None:
            raise ValueError("needs 'min' or 'max'")
        if self.quantity == "leakage" and self.pressure is None:
            raise ValueError("needs 'pressure', the difference at which the leak is limited")
        for key, limit in (("min", self.min), ("max", self.max)):
            if limit is not None and self._unit == "%" and not limit.strip().endswith("%"):
                to_si(limit, "%")  # of the right dimension
                raise ValueError(f"{key} = {limit}: has no unit; write for example '75 %'")
        low, high = self.requirement.low, self.requirement.high  # of the right dimension
        for key, text, si in (("min", self.min, low), ("max", self.max, high)):
            if text is not None and si is not None and (fault := self._fault(key, si)):
                raise ValueError(f"{key} = {text}: {fault}")
        if low is not None and high is not None and low > high:
            raise ValueError(f"min ({self.min}) is above max ({self.max})")
        return self

    def _fault(self, key: str, si: float) -> str:
        """Return why a limit [SI] is met by no value or by every one; empty for others."""
        if self.quantity == "drift":
            one_sided = self.min is None and si < 0
            return "must be positive; it limits changes in either direction" if one_sided else ""
        is_zero = si == 0 and key == "max" and self.quantity != "leakage"
        is_low, is_high = si < 0 or is_zero, self.quantity == "efficiency" and si > 1
        if not (is_low or is_high):
            return ""
        never = is_low if key == "max" else is_high
        return f"{'can never be' if never else 'is always'} met: {_POSITIVE[self.quantity]}"

    @property
    def requirement(self) -> Requirement:
        """The same as a record, in SI. Raises ``ValueError`` for a limit of another dimension."""
        unit = self._unit
        low, high = self._si("min", self.min), self._si("max", self.max)
        if self.quantity == "drift" and low is None and high is not None:
            low = -high  # a change in either direction
        leak = self.leak or "across_piston"
        return Requirement(
            quantity=self.quantity,
            unit=unit,
            low=low,
            high=high,
            name=self.name,
            label=self.label,
            direction=self.direction,
            f_load_n=self.load,
            p_lr_ref_pa=self.p_lr,
            v_m_s=self.speed,
            dwell_s=self.dwell,
            leak=leak if self.quantity == "leakage" else None,
            pressure_pa=self.pressure,
        )

    def _si(self, key: str, limit: str | None) -> float | None:
        try:
            return None if limit is None else to_si(limit, self._unit)
        except ValueError as error:
            raise ValueError(f"{key} = {limit!r}: {error}") from None

    @property
    def _unit(self) -> str:
        """Unit of the reports: the first that has the dimension of the limit."""
        units = _UNITS[self.quantity]
        for unit in units[1:]:
            try:
                to_si(self.max if self.min is None else self.min, unit)
            except ValueError:
                continue
            return unit
        return units[0]


class Limits(ConfigSection):
    """File of limits.

    Decision rules after JCGM 106: ``simple`` compares the measured value with the limit;
    ``shared_risk`` does so where U95 is at most ``largest_uncertainty`` of the limit;
    ``guard_band`` passes a value that is inside the limit by at least U95.
    """

    product: Text = ""
    rule: Rule = "guard_band"
    largest_uncertainty: Annotated[float, q.quantity("%", gt=0, le=1)] | None = None
    limits: tuple[Limit, ...] = Field(min_length=1)

    @model_validator(mode="after")
    def _states_the_largest_uncertainty(self) -> "Limits":
        needed = self.rule == "shared_risk"
        if needed and self.largest_uncertainty is None:
            raise ValueError(
                "rule shared_risk needs 'largest_uncertainty', the largest U95 in % of a limit"
            )
        if needed and any(limit.requirement.tolerance == 0 for limit in self.limits):
            raise ValueError("rule shared_risk compares U95 with the limit, which must not be 0")
        if not needed and self.largest_uncertainty is not None:
            raise ValueError("'largest_uncertainty' belongs to rule shared_risk")
        return self


def parse_limits(data: dict[str, Any], source: str) -> Limits:
    """Check the mapping of a file of limits. Raises ``ConfigError``."""
    return validate(Limits, data, source)
