"""Headline numbers of a campaign, its drift, and the grades of its data. All quantities are SI."""

from dataclasses import dataclass
from typing import Literal

from hbench.records.flow import Direction
from hbench.records.numbers import Count, KindName

Basis = Literal["trials", "one_trial", "extrapolated"]
Grade = Literal["good", "with care", "poor"]
SIGNIFICANCE = 0.05  # level of the drift's test


@dataclass(frozen=True)
class HeadlineNumber:
    """Value with its 95 % uncertainty, in the unit that its key names."""

    value: float
    u95: float | None  # half-width with the instruments; without them where they are not known
    ci95: float | None  # half-width of the trials or the fit alone
    se: float | None  # standard error of the trials' mean, or of the fitted parameter
    basis: Basis  # mean of several trials, a single trial, or a law extrapolated to rest


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
    friction_n: HeadlineNumber | None  # |F| at that speed
    breakaway_n: HeadlineNumber | None  # |F| as the piston begins to slide
    efficiency: HeadlineNumber | None  # at that speed; 1 is 100 %


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
    speed_vif: float  # variance inflation of run time by the speeds of a curve; 1: independent
    # Mean difference in run time between the fastest and the slowest speed of a curve, as a share
    # of the span: so much of the drift appears as an effect of speed.
    speed_share: float
    separated: bool  # whether the plan separates drift from the effect of speed

    @property
    def significant(self) -> bool:
        """Whether friction drifts, at the 5 % level."""
        return self.p < SIGNIFICANCE


@dataclass(frozen=True)
class QualityCheck:
    """Grade of one property of the data against its limits."""

    name: Literal[
        "runs_accepted", "trials_per_point", "repeatability", "drift", "instruments", "fits"
    ]
    grade: Grade
    value: float | None  # graded value; None: not known
    unit: Literal["%", "trials"]  # of value and limits
    good: float  # the limit of "good"
    poor: float | None  # beyond it "poor"; None: there is no such limit
    count: int | None = None  # runs or fits that pass, where the value is their share
    of: int | None = None  # among so many
    law: str | None = None  # whose fits were graded
    drift: Drift | None = None  # that was graded


@dataclass(frozen=True)
class Quality:
    """Verdict on the data of a campaign: the worst grade of its checks."""

    grade: Grade
    checks: tuple[QualityCheck, ...]
