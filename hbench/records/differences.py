"""Results of ``compare`` for two campaigns, A and B. Differences are B less A, in SI."""

from dataclasses import dataclass

from hbench.records.curves import Band, BandTrend, Curve
from hbench.records.motions import Breakaway
from hbench.records.numbers import SIGNIFICANCE, Count
from hbench.records.runs import Direction, Provenance
from hbench.records.summary import Drift, OilTemperature, Quality


@dataclass(frozen=True)
class Difference:
    """A number of both campaigns, and the test of its difference."""

    a: float
    b: float
    se: float | None  # standard error of b - a, of the trials
    ci95: float | None  # half-width, of the trials alone; None where there is no scatter
    u95: float | None  # half-width with the instruments; None where they are not known
    p_value: float | None  # of no difference, by the trials alone
    p_holm: float | None = None  # corrected for the number of differences of its kind
    untested: str = ""  # why there is no p value
    u95_a: float | None = None  # expanded uncertainty of a by itself; None where it is not known
    u95_b: float | None = None  # the same of b
    dof: float | None = None  # degrees of freedom of se; None without one

    @property
    def value(self) -> float:
        """B less A."""
        return self.b - self.a

    @property
    def real(self) -> bool:
        """Significant by the trials after Holm, and beyond the instruments where they are known."""
        beyond = self.u95 is None or abs(self.value) > self.u95
        return self.p_holm is not None and self.p_holm < SIGNIFICANCE and beyond


@dataclass(frozen=True)
class FrictionDifference:
    """|F| of both campaigns at one speed."""

    v_m_s: float  # signed, that of A's point
    friction_n: Difference
    between: bool  # B has no point at this speed: linearly interpolated


@dataclass(frozen=True)
class FitDifference:
    """A parameter of a law fitted in both."""

    law: str
    name: str
    unit: str
    value: Difference


@dataclass(frozen=True)
class DriftEffect:
    """Part of a difference of mean friction that the campaigns' own drifts account for."""

    value_n: float
    ci95_n: float  # half-width of its 95 % interval

    @property
    def largest_n(self) -> float:
        """The farther end of the interval, as a magnitude."""
        return abs(self.value_n) + self.ci95_n


@dataclass(frozen=True)
class MeanAtSpeed:
    """Mean over the steady curves of the differences of friction at one speed."""

    v_m_s: float  # without sign
    value_n: float
    ci95_n: float  # half-width by the trials, which are independent
    u95_n: float | None = None  # expanded uncertainty; None where it is not known


@dataclass(frozen=True)
class MeanOfCurves:
    """Mean of the differences of mean friction of all steady curves; equal weights."""

    value_n: float
    half_n: float  # expanded uncertainty, or half-width by the trials where it is not known
    a_n: float  # the same mean of A's friction
    curves: Count  # in the mean
    ci95_n: float  # half-width by the trials, which are independent
    p_value: float  # of no difference, by the trials alone
    drift_n: DriftEffect | None = None  # None where a campaign's drift is not known
    speeds: tuple[MeanAtSpeed, ...] = ()  # rising; empty where the curves have different ones
    u95_a: float | None = None  # expanded uncertainty of a_n; None where it is not known
    u95_b: float | None = None  # the same of B's mean

    @property
    def drift_cancels(self) -> bool:
        """Whether the drift is known, and a small part of the half-width."""
        return self.drift_n is not None and self.drift_n.largest_n < 0.01 * self.half_n

    @property
    def real(self) -> bool:
        """Significant beyond its half-width and its drift, where it is known, together."""
        drift_n = 0.0 if self.drift_n is None else self.drift_n.largest_n
        return abs(self.value_n) > self.half_n + drift_n


@dataclass(frozen=True)
class CurveDifference:
    """Two curves of the same kind, direction and load."""

    a: Curve
    b: Curve
    points: tuple[FrictionDifference, ...]  # at speeds of both, rising
    mean_n: Difference | None  # of |F| over these speeds
    efficiency: Difference | None  # of the mean over the speeds where both have one
    parameters: tuple[FitDifference, ...]
    drift_n: DriftEffect | None = None  # of mean_n; None where a campaign's drift is not known

    @property
    def direction(self) -> Direction:
        """Of both."""
        return self.a.direction


@dataclass(frozen=True)
class BandDifference:
    """Two friction bands at the same load or pressure, and at the same speeds."""

    a: Band
    b: Band
    half_n: Difference
    middle_n: Difference
    energy_j: Difference | None  # of a cycle; None where either has none


@dataclass(frozen=True)
class BandTrendDifference:
    """Dependence of two series' friction bands on pressure."""

    a: BandTrend
    b: BandTrend
    half_slope_n_pa: Difference
    middle_slope_n_pa: Difference


@dataclass(frozen=True)
class BreakawayDifference:
    """Breakaway of both in one direction, at the same load, time at rest and rate."""

    a: Breakaway
    b: Breakaway
    breakaway_n: Difference


@dataclass(frozen=True)
class CampaignDifferences:
    """All differences of two campaigns."""

    names: tuple[str, str]  # of the folders
    a: Provenance
    b: Provenance
    qualities: tuple[Quality, Quality]  # of A's data and of B's
    same_instruments: bool  # their errors are the same in both
    curves: tuple[CurveDifference, ...]
    notes: tuple[str, ...]  # what could not be compared, with the reason
    bands: tuple[BandDifference, ...] = ()
    band_trends: tuple[BandTrendDifference, ...] = ()
    oil_temperatures: tuple[OilTemperature | None, OilTemperature | None] = (None, None)  # A, B
    mean_of_curves: MeanOfCurves | None = None  # None with one steady curve
    drifts: tuple[Drift | None, Drift | None] = (None, None)  # within A, and within B
    breakaways: tuple[BreakawayDifference, ...] = ()
