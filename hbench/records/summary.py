"""Headline numbers of a campaign, and the grades of its data. All quantities are SI."""

from dataclasses import dataclass
from typing import Literal

from hbench.records.flow import Direction
from hbench.records.numbers import KindName

Basis = Literal["trials", "one_trial", "extrapolated"]
Grade = Literal["good", "with care", "poor"]


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
class QualityCheck:
    """Grade of one property of the data against its limits."""

    name: Literal["runs_accepted", "trials_per_point", "repeatability", "instruments"]
    grade: Grade
    value: float | None  # graded value; None: not known
    unit: Literal["%", "trials"]  # of value and limits
    good: float  # the limit of "good"
    poor: float | None  # beyond it "poor"; None: there is no such limit
    count: int | None = None  # runs that pass, where the value is their share
    of: int | None = None  # among so many


@dataclass(frozen=True)
class Quality:
    """Verdict on the data of a campaign: the worst grade of its checks.

    Fits are not data: each has its own verdict.
    """

    grade: Grade
    checks: tuple[QualityCheck, ...]


@dataclass(frozen=True)
class FitVerdicts:
    """Number of a law's fits with each verdict."""

    law: str
    fits: int
    determined: int
    not_determined: int  # with a parameter that the data does not determine
    not_converged: int
