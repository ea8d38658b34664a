"""A fleet of campaigns: a row each, and their distributions, trends and outliers."""

from dataclasses import dataclass, field
from datetime import datetime

from hbench.records.flow import DIRECTIONS, Direction

Side = Direction | None  # of a number; None: of both directions together


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
    seed: int | None = None  # of the virtual rig
    started: datetime | None = None
    # What must be the same where cylinders are compared: diameters, loads, working speed if set.
    protocol: str = ""
    area_piston_m2: float | None = None
    area_rod_m2: float | None = None
    stroke_m: float | None = None
    quality: str = ""  # good, with care, poor
    missing: str = ""  # runs and trials of the plan that the campaign does not have
    runs: int = 0
    accepted: int = 0
    v_m_s: float | None = None  # working speed
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
    se_trials: float | None  # standard error of a campaign's own trials, median
    low: float  # 5 % quantile
    high: float  # 95 % quantile
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
    v_m_s: float | None  # working speed
    numbers: dict[str, FleetNumber]


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
    rows: tuple[FleetCampaign, ...] = ()  # analyzed campaigns; empty for a large fleet
