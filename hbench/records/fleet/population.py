"""Distribution of a number over the campaigns of a fleet, its trend, outliers, and wear."""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from hbench.records.fleet.campaigns import Quantity, Side
from hbench.records.numbers import SIGNIFICANCE

FEWEST_CAMPAIGNS = 10  # for quantiles, outliers and trends


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
        return self.p_holm < SIGNIFICANCE


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
        return self.p_bonferroni < SIGNIFICANCE


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
        return self.p_holm < SIGNIFICANCE
