"""Headline numbers of a campaign, its drift, and the grades of its data. All quantities are SI."""

from dataclasses import dataclass
from typing import Literal

from hbench.records.curves import Curve
from hbench.records.numbers import SIGNIFICANCE, Count, KindName
from hbench.records.runs import Direction, TemperatureSensor

Basis = Literal["trials", "one_trial", "extrapolated", "ramp", "breakaway"]
Grade = Literal["good", "with care", "poor"]
LARGE_DRIFT = 15.0  # change over a campaign, % of friction, that the data should exclude
SEPARATED_VIF = 5.0  # largest variance inflation by speed of a plan that separates from it


@dataclass(frozen=True)
class HeadlineNumber:
    """Value with its 95 % uncertainty, in the unit that its key names."""

    value: float
    u95: float | None  # half-width with the instruments; without them where they are not known
    ci95: float | None  # half-width of the trials or the fit alone
    se: float | None  # standard error of the trials' mean, or of the fitted parameter
    # Mean of several trials, a single trial, a law extrapolated to rest, a ramp's first speeds, or
    # runs of the kind breakaway.
    basis: Basis


@dataclass(frozen=True)
class HeadlineSeries:
    """Headline numbers of one direction, load and rod-side pressure."""

    kind: KindName
    label: str
    direction: Direction
    f_load_n: float | None
    p_lr_ref_pa: float | None
    a_ref_m_s2: float | None  # of a ramp
    v_m_s: float | None  # speed measured next to the working speed; None where none is near
    # Friction at that speed and as the piston begins to slide; positive against the motion, so that
    # a negative value has the wrong sign.
    friction_n: HeadlineNumber | None
    breakaway_n: HeadlineNumber | None
    breakaway_dwell_s: float | None  # at rest before breakaway; None where it was not measured
    efficiency: HeadlineNumber | None  # at that speed; 1 is 100 %
    # Both forces as the pressure on the driving area, as cylinder tests state them; None without
    # hydraulics. The other chamber's pressure is subtracted, with the ratio of the areas.
    friction_pa: HeadlineNumber | None = None
    breakaway_pa: HeadlineNumber | None = None


@dataclass(frozen=True)
class Headline:
    """Headline numbers of a campaign: friction at the working speed, breakaway, efficiency."""

    v_m_s: float | None  # working speed; None where no steady run was accepted
    v_tolerance: float  # relative distance up to which a measured speed counts as the working speed
    series: tuple[HeadlineSeries, ...]


@dataclass(frozen=True)
class Drift:
    """Linear drift of steady friction with run time, pooled over all points of a campaign."""

    basis: Literal[
        "time", "order"
    ]  # start times of the runs; or their order, if no times are known
    scale: Literal["relative", "absolute"]  # drift of all points alike: as a share, or in N
    change: float  # from the first run to the last; share of a point's friction, or N
    change_ci95: float  # half-width of its 95 % interval
    change_percent: float  # of friction; of the median friction where the scale is absolute
    change_percent_ci95: float
    per_hour: float | None  # share of a point's friction, or N; None without times
    per_hour_ci95: float | None
    span_s: float | None  # from the first run to the last
    p: float  # of no drift, two-sided
    points: Count  # with two trials or more
    trials: Count  # of these points
    dof: Count  # degrees of freedom of the interval: trials of one file count once
    speed_vif: float  # variance inflation of run time by the speeds of a curve; 1: independent
    # Mean difference in run time between the fastest and the slowest speed of a curve, as a share
    # of the span: so much of the drift appears as an effect of speed.
    speed_share: float
    separated: bool  # whether the plan separates drift from the effect of speed
    several_speeds: bool = True  # whether a curve has more than one, so that they can be mixed
    # Of the oil over the same runs, by a straight line from the first run to the last. The
    # correlation is that of a trial's deviations from its point: friction with temperature. None
    # where the temperature was not measured, or did not change within the points; the change also
    # where only the order of the runs is known and it mixes drift with speed.
    temp_change_k: float | None = None
    temp_correlation: float | None = None
    temp_p: float | None = None  # of no correlation, two-sided

    @property
    def significant(self) -> bool:
        """Whether friction drifts, at the level ``SIGNIFICANCE``."""
        return self.p < SIGNIFICANCE

    @property
    def of_unknown_size(self) -> bool:
        """Whether the change is extrapolated from neighbours in an order that may be of names."""
        return self.basis == "order" and not self.separated

    @property
    def has_size(self) -> bool:
        """Whether the change is a result: not where a significant drift is of unknown size."""
        return not (self.significant and self.of_unknown_size)

    @property
    def has_temp_change(self) -> bool:
        """Whether the oil's change is that over the campaign, and not over an order of names."""
        return not self.of_unknown_size

    @property
    def possible_percent(self) -> float:
        """The farther end of the interval of the change, as a magnitude."""
        return abs(self.change_percent) + self.change_percent_ci95

    @property
    def hidden(self) -> bool:
        """Whether the plan mixes drift with speed, and the data does not exclude a large one."""
        mixed = not self.separated and not self.significant
        return mixed and self.possible_percent > LARGE_DRIFT


@dataclass(frozen=True)
class ViscosityEffect:
    """Dependence of friction on the oil's viscosity, from trials at different temperatures.

    Friction changes by (c_0 + c_1 |v|) (r - 1), r being the viscosity over that at the reference
    temperature; see analysis/temperature/reduction.py.
    """

    kind: KindName
    label: str
    direction: Direction
    dry_n: float  # c_0
    dry_ci95_n: float  # half-width of its 95 % interval
    viscous_n_s_m: float  # c_1
    viscous_ci95_n_s_m: float
    p: float  # of no effect (F test)
    points: Count  # with two trials or more
    trials: Count  # of these points
    # Of the point that changes most by the reduction: change and its half-width; share of friction.
    correction_n: float
    correction_ci95_n: float
    speed_vif: float  # variance inflation of viscosity by the speeds of a curve; 1: independent
    reason: str  # why its curves are not reduced; empty if they are

    @property
    def determined(self) -> bool:
        """Whether the data determines the reduction."""
        return not self.reason


@dataclass(frozen=True)
class Reduction:
    """Steady friction reduced to a reference temperature of the oil."""

    t_ref_k: float
    extrapolated: bool  # whether the reference temperature is outside the measured ones
    effects: tuple[ViscosityEffect, ...]  # of each label and direction
    # Only those whose effect is determined; U95 includes that of the correction.
    curves: tuple[Curve, ...]
    drift: Drift | None  # of the reduced curves


@dataclass(frozen=True)
class OilTemperature:
    """Oil temperature of a campaign's accepted steady runs, by one sensor for all of them."""

    sensor: TemperatureSensor
    mean_k: float
    low_k: float
    high_k: float
    runs: Count  # with a temperature
    reduction: Reduction | None  # None with a reason
    reason: str = ""


@dataclass(frozen=True)
class QualityCheck:
    """Grade of one property of the data against its limits."""

    name: Literal[
        "complete",
        "runs_accepted",
        "trials_per_point",
        "repeatability",
        "unlike_trials",
        "load_spread",
        "nominal_load",
        "drift",
        "zeros",
        "zero_drift",
        "force_drift",
        "plausible_signs",
        "load_direction",
        "load_balance",
        "load_share",
        "equal_directions",
        "constant_force",
        "instruments",
    ]
    grade: Grade
    value: float | None  # graded value; None: not known
    unit: Literal["%", "trials", "points"]  # of value and limits
    good: float  # the limit of "good"
    poor: float | None  # beyond it "poor"; None: there is no such limit
    # Runs or points that the check counts, and among how many: runs completed or accepted, runs
    # whose load is not near the nominal one, points without an accepted trial, points whose sign
    # contradicts the motion beyond its interval. The instruments' median is of that many points.
    count: int | None = None
    of: int | None = None
    drift: Drift | None = None  # that was graded


@dataclass(frozen=True)
class PointTrials:
    """Operating point of the plan, with its accepted trials."""

    kind: KindName
    label: str
    direction: Direction
    f_load_n: float | None
    p_lr_ref_pa: float | None
    a_ref_m_s2: float | None
    v_ref_m_s: float
    accepted: int  # trials
    planned: int  # trials
    dwell_s: float | None = None  # at rest before breakaway


@dataclass(frozen=True)
class Completeness:
    """Comparison of a campaign's runs with its plan."""

    planned: int | None  # runs; None: the plan is not known, as for imported logs
    at_most: bool  # adaptive speeds, still to be measured, may need fewer runs than planned
    not_completed: tuple[str, ...]  # planned runs without a log that ended as planned
    points: int  # operating points of the plan, or of the runs where the plan is not known
    # Points with fewer accepted trials than planned; three are enough. Every run of a point may
    # have been rejected, or not made: it has 0.
    short_points: tuple[PointTrials, ...]


@dataclass(frozen=True)
class ImplausiblePoint:
    """Point of a curve with friction in the direction of motion, or an efficiency above 1."""

    kind: KindName
    label: str
    direction: Direction
    f_load_n: float | None
    p_lr_ref_pa: float | None
    a_ref_m_s2: float | None
    v_m_s: float
    quantity: Literal["friction_n", "efficiency"]
    value: float  # friction [N], positive against the motion; or efficiency
    u95: float | None  # half-width of its 95 % interval, with the instruments where they are known
    beyond: bool  # whether the whole interval is implausible; without an interval, the value

    @property
    def where(self) -> tuple:
        """Series and speed, which friction and efficiency of a point share."""
        load = self.f_load_n, self.p_lr_ref_pa
        return self.kind, self.label, self.direction, *load, self.a_ref_m_s2, self.v_m_s


@dataclass(frozen=True)
class Quality:
    """Verdict on the data of a campaign: the worst grade of its checks.

    Fits are not data: each has its own verdict.
    """

    grade: Grade
    checks: tuple[QualityCheck, ...]
    completeness: Completeness
    implausible: tuple[ImplausiblePoint, ...]


@dataclass(frozen=True)
class FitVerdicts:
    """Number of a law's fits with each verdict."""

    law: str
    fits: int
    determined: int
    hardly_determined: int  # with a parameter that the data hardly determines
    not_determined: int  # with a parameter that the data does not determine
    not_converged: int
