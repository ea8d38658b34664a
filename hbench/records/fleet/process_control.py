"""Statistical process control over the campaigns of a fleet: control charts and capability."""

from dataclasses import dataclass

from hbench.records.conformity.acceptance import Measurement, Requirement
from hbench.records.fleet.campaigns import Quantity, Side
from hbench.records.fleet.precision import Estimate
from hbench.records.numbers import SIGNIFICANCE


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
        return self.p_holm < SIGNIFICANCE


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
