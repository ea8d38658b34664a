"""A fleet of campaigns: a row each, and their distributions, trends and outliers."""

import math
from dataclasses import dataclass, field
from datetime import datetime
from typing import Literal

from hbench.records.conformity.acceptance import Measurement, Requirement
from hbench.records.runs import DIRECTIONS, Direction

Side = Direction | None  # of a number; None: of both directions together
CYLINDER = "cylinder"  # the source of variance that is not of the measurement
LIMIT_FACTOR = 2.8  # from a standard deviation to the limit of a difference (ISO 5725-6, 4.1.3)


@dataclass(frozen=True)
class Quantity:
    """A number that a row holds, for each direction or for both together."""

    name: str  # of its columns, in SI
    words: str
    unit: str  # for display
    scale: float  # from SI to it
    of_directions: bool = True
    listed: bool = False  # in the table of the campaigns of a small fleet

    @property
    def sides(self) -> tuple[Side, ...]:
        """Return the directions that have such a number."""
        return DIRECTIONS if self.of_directions else (None,)

    def column(self, side: Side) -> str:
        """Return the name of its column: extending, ``friction_n`` is ``friction_extend_n``."""
        if side is None:
            return self.name
        unit = next((u for u in ("_n_s_m", "_m_s", "_n") if self.name.endswith(u)), "")
        return f"{self.name.removesuffix(unit)}_{side}{unit}"


QUANTITIES = (
    Quantity("friction_n", "Friction at the working speed", "N", 1.0, listed=True),
    Quantity("breakaway_n", "Breakaway, measured by ramps", "N", 1.0, listed=True),
    Quantity("breakaway_fit_n", "Breakaway, extrapolated by the fit", "N", 1.0),
    Quantity("efficiency", "Efficiency at the working speed", "%", 100.0, listed=True),
    Quantity("f_coulomb_n", "Coulomb friction", "N", 1.0),
    Quantity("v_stribeck_m_s", "Stribeck speed", "mm/s", 1e3),
    Quantity("b_viscous_n_s_m", "Viscous coefficient", "N s/m", 1.0),
    Quantity("half_band_n", "Half band at the median pressure", "N", 1.0, False, True),
    Quantity("half_band_slope_n_pa", "Slope of the half band", "N/bar", 1e5, False, True),
    Quantity("middle_n", "Middle of the band at the median pressure", "N", 1.0, False, True),
    Quantity("cycle_energy_j", "Energy of a cycle at the median pressure", "J", 1.0, False, True),
)


FEWEST_CAMPAIGNS = 10  # for quantiles, outliers and trends


@dataclass(frozen=True)
class FleetNumber:
    """The mean over the loads of one direction, or over the series of bands, in SI.

    The interval's ends are the means of those of the loads: as wide as if all errors were the
    same at each load, which is an upper bound. The trials of the loads are independent.
    """

    value: float
    low: float | None = None  # 95 % interval; with instruments where they are known and count
    high: float | None = None
    se: float | None = None  # standard error of the trials alone
    trials: float | None = None  # repeats that ``se`` is of; of several loads, their harmonic mean
    dof: float | None = None  # degrees of freedom of ``se``


@dataclass(frozen=True)
class FleetRow:
    """Row of a fleet: one campaign. ``failed`` is why it could not be analyzed, or empty."""

    path: str
    failed: str = ""
    name: str = ""
    source: str = ""
    bench: str = ""
    label: str = ""  # of the series; several with commas between
    specimen: str = ""  # serial number
    operator: str = ""
    mounting: str = ""
    day: str = ""  # date of the measurement, as far as it is known
    seed: int | None = None  # of the virtual rig
    started: datetime | None = None
    # What must be the same where cylinders are compared: diameters, loads, working speed if set.
    protocol: str = ""
    area_piston_m2: float | None = None
    area_rod_m2: float | None = None
    stroke_m: float | None = None
    quality: str = ""  # good, with care, poor
    drift_possible: float | None = None  # share of friction that runs mixed with speed may hide
    weak: str = ""  # checks of the data with that grade, with commas between; empty: all are good
    missing: str = ""  # runs and trials of the plan that the campaign does not have
    runs: int = 0
    accepted: int = 0
    v_m_s: float | None = None  # working speed
    distance_m: float | None = None  # travelled in the logged runs
    friction_work_j: float | None = None  # of these
    numbers: dict[tuple[str, Side], FleetNumber] = field(default_factory=dict)


@dataclass(frozen=True)
class Trend:
    """A straight line through a number over time, after Theil and Sen."""

    change: float  # over the whole span
    low: float  # its 95 % interval
    high: float
    start: float  # the line at the first campaign
    p_holm: float  # of no trend (Kendall), corrected for the number of trends

    @property
    def real(self) -> bool:
        """Significant."""
        return self.p_holm < 0.05


@dataclass(frozen=True)
class Block:
    """Campaigns that follow each other: one, with its interval, or many with their quantiles."""

    at: float  # mean of their times, or of their numbers in the order
    n: int
    median: float
    low: float  # of one: its value ∓ 1.96 standard errors; of many: the 5 % quantile
    high: float


@dataclass(frozen=True)
class Spread:
    """One number over the campaigns, in SI."""

    quantity: Quantity
    direction: Side
    n: int  # campaigns that have it
    median: float
    between: float  # standard deviation from cylinder to cylinder, robust, without trial scatter
    between_low: float  # its 95 % interval
    between_high: float
    se_trials: float | None  # standard error of a campaign's own trials, median
    low: float  # 5 % quantile, or the smallest value of fewer than ``FEWEST_CAMPAIGNS``
    high: float  # 95 % quantile, or the largest value of so few
    edges: tuple[float, ...]  # of the histogram
    counts: tuple[int, ...]
    below: int  # campaigns left of the first edge, and right of the last
    above: int
    blocks: tuple[Block, ...]
    trend: Trend | None  # None with too few campaigns


@dataclass(frozen=True)
class Deviation:
    """A number of one campaign, and how far it is from the others."""

    quantity: Quantity
    direction: Side
    value: float
    median: float
    z: float  # in standard deviations between cylinders and of its own scatter
    p_bonferroni: float  # corrected for the number of campaigns and of their numbers
    limit: float  # size of ``z`` beyond which it is an outlier

    @property
    def outlier(self) -> bool:
        """Significant."""
        return self.p_bonferroni < 0.05


@dataclass(frozen=True)
class Suspect:
    """A campaign that deviates, with its worst number first."""

    path: str
    name: str
    started: datetime | None
    quality: str
    report: str  # its page, relative to the fleet's; empty where there is none
    deviations: tuple[Deviation, ...]


@dataclass(frozen=True)
class FleetCampaign:
    """A campaign of a small fleet, with its numbers by their columns."""

    path: str
    compared: bool  # of the evaluated kind
    name: str
    label: str
    quality: str
    missing: str  # of the plan; empty if it is complete
    report: str  # its page, relative to the fleet's; empty where there is none
    decision: str  # of its last acceptance; empty where there is none
    v_m_s: float | None  # working speed
    numbers: dict[str, FleetNumber]
    specimen: str = ""  # serial number
    started: datetime | None = None
    protocol: str = ""  # kind of campaign


@dataclass(frozen=True)
class Estimate:
    """A number that is not negative, with its 95 % interval; no upper end: not bounded."""

    value: float
    low: float
    high: float | None


@dataclass(frozen=True)
class VarianceSource:
    """Part of the variance of a number: by cylinder, operator, mounting, day or trials."""

    name: str
    levels: int  # of its factor; of trials, their degrees of freedom
    variance: Estimate  # by REML
    anova: float  # variance by ANOVA; may be negative


@dataclass(frozen=True)
class Precision:
    """Repeatability and reproducibility of one number, in SI, after ISO 5725."""

    quantity: Quantity
    direction: Side
    campaigns: int
    cylinders: int
    trials: float  # of a campaign, harmonic mean
    mean: float
    sources: tuple[VarianceSource, ...]  # cylinders first, trials last
    repeatability: Estimate  # standard deviation s_r: of trials
    reproducibility: Estimate  # standard deviation s_R: of everything but the cylinders
    share_of_total: Estimate | None  # s_R over the standard deviation of all sources, 0 to 1
    tolerance: float | None  # width between the limits; None: not given

    @property
    def limits(self) -> tuple[float, float]:
        """Limits r and R of the difference of two single trials at 95 % (ISO 5725-6, 4.1.4)."""
        return LIMIT_FACTOR * self.repeatability.value, LIMIT_FACTOR * self.reproducibility.value

    @property
    def critical_difference(self) -> float:
        """Largest difference of two campaigns of one cylinder at 95 % (ISO 5725-6, 4.2.2.1).

        CD = sqrt(R^2 - r^2 (1 - 1/n)) for means of n trials each.
        """
        r, limit = self.limits
        return math.sqrt(max(limit**2 - r**2 * (1 - 1 / self.trials), 0.0))

    @property
    def share_of_tolerance(self) -> float | None:
        """6 s_R over the width of the tolerance (AIAG, Measurement Systems Analysis, %GRR)."""
        return None if self.tolerance is None else 6 * self.reproducibility.value / self.tolerance

    @property
    def distinct_categories(self) -> float | None:
        """1.41 times the cylinders' standard deviation over s_R (AIAG, ndc)."""
        of_cylinders = [s.variance.value for s in self.sources if s.name == CYLINDER]
        if not of_cylinders or not self.reproducibility.value:
            return None
        return 1.41 * math.sqrt(of_cylinders[0]) / self.reproducibility.value


@dataclass(frozen=True)
class ChartSignal:
    """Campaigns at which a rule of a control chart signals."""

    rule: str  # its name and number
    count: int
    names: tuple[str, ...]  # of the first campaigns


@dataclass(frozen=True)
class ChartStep:
    """The most likely step of the mean on a control chart, in SI."""

    name: str  # of the first campaign after it
    at: float  # day of this campaign
    before: float  # means
    after: float
    ci95: float  # half-width of the interval of their difference
    p: float  # of no step, by permutation
    p_holm: float  # corrected for the number of charts

    @property
    def real(self) -> bool:
        """Significant."""
        return self.p_holm < 0.05


@dataclass(frozen=True)
class ControlChart:
    """Individuals and EWMA chart of a number over the dates of the campaigns, in SI."""

    quantity: Quantity
    direction: Side
    n: int  # campaigns
    n_limits: int  # campaigns that mean and sigma are of: those before a significant step, or all
    centre: float
    sigma: float  # mean moving range / 1.128
    of_cylinders: bool  # values are deviations from the mean of their cylinder, plus the centre
    at: tuple[float, ...]  # days since the first campaign; of the last campaigns
    values: tuple[float, ...]
    names: tuple[str, ...]  # of the campaigns
    outside: tuple[str, ...]  # names of the first campaigns beyond the limits
    beyond: int  # campaigns beyond the limits
    moved: int  # campaigns whose moving range is beyond its limit
    ewma: tuple[float, ...] = ()  # averages at ``at``, and their limits
    ewma_low: tuple[float, ...] = ()
    ewma_high: tuple[float, ...] = ()
    signals: tuple[ChartSignal, ...] = ()  # of each rule that signals
    step: ChartStep | None = None

    @property
    def limits(self) -> tuple[float, float]:
        """Lower and upper control limit: three sigma from the centre."""
        return self.centre - 3 * self.sigma, self.centre + 3 * self.sigma


@dataclass(frozen=True)
class Capability:
    """Capability of a limited quantity over the compared campaigns, in SI."""

    requirement: Requirement
    series: Measurement  # its value is the mean of the campaigns
    n: int  # campaigns
    sigma: float  # standard deviation of the campaigns, that of the measurement included
    ppk: Estimate  # by ``sigma``
    sigma_within: float | None  # mean moving range / 1.128; None: the order is not known
    cpk: Estimate | None  # by ``sigma_within``
    outside: int  # campaigns beyond the limits


@dataclass(frozen=True)
class WearTrend:
    """Straight line of a cylinder's friction over its distance or friction work."""

    quantity: Quantity
    direction: Side
    specimen: str
    over: Literal["distance_m", "friction_work_j"]
    x: tuple[float, ...]  # cumulated up to the middle of each campaign
    values: tuple[float, ...]
    slope: float
    low: float  # its 95 % interval
    high: float
    intercept: float
    p: float  # of no slope
    p_holm: float  # corrected for the number of these trends

    @property
    def real(self) -> bool:
        """Significant."""
        return self.p_holm < 0.05


@dataclass(frozen=True)
class Fleet:
    """Summary of a table of campaigns. Its size does not depend on their number."""

    campaigns: int
    failed: int
    reasons: tuple[tuple[str, int], ...]  # why, and how many; the most frequent first
    failures: tuple[tuple[str, str], ...]  # path and reason, of the first ones
    qualities: tuple[tuple[str, int], ...]
    incomplete: int  # campaigns
    sources: tuple[tuple[str, int], ...]
    protocols: tuple[tuple[str, int], ...]  # the most frequent is evaluated
    compared: int  # campaigns of that protocol, at its speed
    other_speeds: int  # campaigns of that protocol whose speed, not set, differs by more than 20 %
    by_date: bool  # blocks and trends are over days since ``first``; else over the order of paths
    first: datetime | None
    last: datetime | None
    spreads: tuple[Spread, ...]
    outliers: int
    worst: tuple[Suspect, ...]  # the most deviating, outliers or not
    # Repeatability and reproducibility, where the campaigns form a plan; and why not, or not all.
    precision: tuple[Precision, ...] = ()
    plan_notes: tuple[str, ...] = ()
    # Checks of the data that give campaigns their grade, unless that is good: how many campaigns.
    weak_checks: tuple[tuple[str, int], ...] = ()
    drift_possible: float | None = None  # largest share of friction that a drift may hide in one
    charts: tuple[ControlChart, ...] = ()
    wear: tuple[WearTrend, ...] = ()
    capabilities: tuple[Capability, ...] = ()
    without_capability: tuple[tuple[str, str], ...] = ()  # name of a limit, and why it has no Ppk
    decisions: tuple[tuple[str, int], ...] = ()  # of the last acceptances, and how many of each
    rows: tuple[FleetCampaign, ...] = ()  # analyzed campaigns; empty for a large fleet
