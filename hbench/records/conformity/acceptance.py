"""Conformity of a cylinder with limits. All quantities are SI."""

import math
from dataclasses import dataclass
from typing import Literal

from hbench.records.motions import Leak
from hbench.records.runs import Direction, Provenance
from hbench.records.summary import Grade

LimitQuantity = Literal["friction", "breakaway", "efficiency", "leakage", "speed_ripple", "drift"]
Rule = Literal["simple", "shared_risk", "guard_band"]
Conformity = Literal["PASS", "MARGINAL", "FAIL", "NOT TESTED"]
# Why a limit was not tested: nothing was measured of its quantity, or at its speed, load, back
# pressure or rest, or not at all of them together, or in other series only; the holds had lower
# pressures; times or driving areas are not known; no oil drives the direction; no run was accepted;
# the value is impossible; its U is not known or too large.
UntestedCause = Literal[
    "quantity",
    "speed",
    "load",
    "back_pressure",
    "rest",
    "combination",
    "series",
    "pressure",
    "times",
    "area",
    "undriven",
    "rejected",
    "impossible",
    "u_unknown",
    "u_large",
]
WORST_FIRST: tuple[Conformity, ...] = ("FAIL", "NOT TESTED", "MARGINAL", "PASS")


@dataclass(frozen=True)
class Requirement:
    """Limit of one quantity, and the series of runs that it applies to; None: to all."""

    quantity: LimitQuantity
    unit: str  # of the file: the value and its limits are given in it
    low: float | None  # SI; None: no lower limit
    high: float | None  # SI; None: no upper limit
    name: str = ""  # of the file, such as a clause of a specification
    label: str | None = None
    direction: Direction | None = None
    f_load_n: float | None = None
    p_lr_ref_pa: float | None = None
    v_m_s: float | None = None  # speed without sign
    dwell_s: float | None = None  # at rest before breakaway; None: the longest
    leak: Leak | None = None
    pressure_pa: float | None = None  # difference that drives a leak

    @property
    def tolerance(self) -> float:
        """Size that U95 is compared with: of the limit, or half of the distance between two."""
        if self.low is not None and self.high is not None:
            return (self.high - self.low) / 2
        return abs(self.low or self.high or 0.0)

    @property
    def permitted(self) -> float:
        """Size of what the limit permits: of an efficiency's lower limit the largest loss."""
        if self.quantity == "efficiency" and self.high is None and self.low is not None:
            return max(0.0, 1.0 - self.low)
        return self.tolerance

    def margin(self, value: float) -> float:
        """Return the distance of a value from the nearest limit, positive inside."""
        low = math.inf if self.low is None else value - self.low
        high = math.inf if self.high is None else self.high - value
        return min(low, high)

    def is_impossible(self, measured: "Measurement") -> bool:
        """Whether the sign contradicts physics, or an efficiency is above 100 %, by more than U.

        Friction cannot drive the motion, and oil cannot leak against its pressure.
        """
        u95 = measured.u95 or 0.0
        if self.quantity == "efficiency":
            return measured.value - u95 > 1.0
        signed = ("friction", "breakaway", "leakage")
        return self.quantity in signed and measured.value + u95 < 0.0

    @property
    def is_pressure(self) -> bool:
        """Whether a force is limited as the pressure on the driving area."""
        return self.unit == "bar"


@dataclass(frozen=True)
class Measurement:
    """Measured value of a required quantity, with the series and the runs that it comes from."""

    value: float
    u95: float | None  # half-width with the instruments where known; None: not known
    dof: float | None = None  # its degrees of freedom; None: infinite
    label: str = ""
    direction: Direction | None = None
    f_load_n: float | None = None
    p_lr_ref_pa: float | None = None
    v_m_s: float | None = None
    dwell_s: float | None = None
    runs: tuple[str, ...] = ()
    without_instruments: bool = False  # u95 does not contain their errors, which are not known
    u: float | None = None  # combined standard uncertainty; None: u95 over Student's factor
    area_m2: float | None = None  # that the oil drives; None: not a force, or not known
    # Of a leak: the smallest step of the logged pressures, and the set loads of its holds.
    step_pa: float | None = None
    lowest_load_n: float | None = None
    highest_load_n: float | None = None


@dataclass(frozen=True)
class ConformityCheck:
    """Decision on one requirement and one series."""

    requirement: Requirement
    measurement: Measurement | None  # None: not tested
    probability: float | None  # of conformity; None where the uncertainty is not known
    decision: Conformity
    reason: str = ""  # why not tested
    causes: tuple[UntestedCause, ...] = ()  # codes of the reason

    @property
    def margin_in_u(self) -> float | None:
        """Distance of the value from the nearest limit in multiples of U, positive inside."""
        measured = self.measurement
        if measured is None or not measured.u95:
            return None
        return self.requirement.margin(measured.value) / measured.u95

    @property
    def at_worst_speed(self) -> bool:
        """Whether the limit states no speed: the worst of the measured ones was decided."""
        measured = self.measurement
        has_speed = measured is not None and measured.v_m_s is not None
        return has_speed and self.requirement.v_m_s is None


@dataclass(frozen=True)
class Acceptance:
    """Conformity of a cylinder with all requirements of a file of limits."""

    provenance: Provenance
    serial: str  # of the cylinder; empty: not stated
    product: str  # that the limits belong to
    limits: str  # file name
    limits_sha256: str
    rule: Rule
    # Share of a limit: rule shared_risk decides only where U95 is at most this.
    largest_uncertainty: float | None
    checks: tuple[ConformityCheck, ...]
    data: Grade  # of the campaign
    notes: tuple[str, ...]

    @property
    def decision(self) -> Conformity:
        """Decision on the cylinder: the worst of all checks."""
        decisions = {check.decision for check in self.checks}
        return next(each for each in WORST_FIRST if each in decisions)
