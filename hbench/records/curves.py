"""Curves of friction and efficiency over velocity, and bands over pressure.

All quantities are SI, as in ``runs.py``.
"""

from dataclasses import dataclass, field

from hbench.records.fits import Fit, Selection
from hbench.records.numbers import Count, KindName
from hbench.records.runs import SIGNS, Direction, Factors, Series, Specimen


@dataclass(frozen=True)
class CurvePoint:
    """The average of the accepted trials of one reference."""

    v_m_s: float
    friction_n: float
    ci95_n: float | None  # half-width of Student's interval; None with fewer than two trials
    n: Count  # trials
    f_test_n: float
    f_applied_n: float
    p_tp_pa: float | None  # None without hydraulics
    p_tr_pa: float | None
    trials: tuple[int, ...]  # their numbers
    trials_n: tuple[float, ...]  # friction of each trial
    trials_f_test_n: tuple[float, ...]  # F_T of each trial
    runs: tuple[str, ...]
    sigma_instruments_n: float | None = None  # 6.15 for 5.1; None where they are not known
    sigma_instruments_dof: float | None = None  # its degrees of freedom; None: infinite
    u95_n: float | None = None  # expanded uncertainty: trials, instruments, a significant drift
    u95_dof: float | None = None  # its effective degrees of freedom; None: infinite
    u95_monte_carlo_n: float | None = None  # half-width of the interval of drawn errors (JCGM 101)
    # The inputs' parts of sigma by name, with their signs: an error has the same sign at all
    # points of a campaign.
    parts_n: dict[str, float] = field(default_factory=dict)
    trials_work_j: tuple[float | None, ...] = ()  # work of each trial's strokes, where known
    # of a significant drift, below 0 before the middle of the campaign; None without one
    sigma_drift_n: float | None = None
    sigma_temperature_n: float | None = None  # of the reduction to a reference temperature
    temp_k: float | None = None  # of the oil, where the campaign's results take it; None: unknown
    trials_temp_k: tuple[float, ...] = ()  # of each trial; empty where one is not known
    hersey_m: float | None = None  # eta |v| / p, see analysis/temperature/hersey.py
    trials_hersey_m: tuple[float, ...] = ()  # of each trial, at its temperature
    # Standard uncertainty by the steps of the log, in SI by channel, where it matters.
    u_steps: dict[str, float] = field(default_factory=dict)
    far_shift_n: float = 0.0  # change of friction by samples far from all others, where it matters


@dataclass(frozen=True)
class Curve:
    """Friction over velocity for one direction, load and rod-side pressure."""

    kind: KindName
    direction: Direction
    f_load_n: float | None
    p_lr_ref_pa: float | None
    label: str
    specimen: Specimen
    points: tuple[CurvePoint, ...]  # by rising speed
    fits: tuple[Fit, ...] = ()
    a_ref_m_s2: float | None = None  # of a ramp
    selection: Selection | None = None  # None with fewer than two laws or seven speeds
    factors: Factors = ()

    @property
    def series(self) -> Series:
        """Series of the curve."""
        return Series(self.label, self.f_load_n, self.p_lr_ref_pa)

    @property
    def factor_values(self) -> dict[str, str]:
        """Value of each factor, such as a current or a lubricant, with its unit."""
        return dict(self.factors)

    @property
    def temp_range_k(self) -> tuple[float, float] | None:
        """Lowest and highest oil temperature of the trials; None where it is not known."""
        known = [temp for point in self.points for temp in point.trials_temp_k]
        return (min(known), max(known)) if known else None

    @property
    def against_motion(self) -> float:
        """Factor from the points' friction to friction against the motion, which is positive."""
        return SIGNS[self.direction]

    @property
    def over_velocity(self) -> bool:
        """Enough speeds for a curve over velocity; fewer are points over pressure."""
        return len(self.points) >= 3


@dataclass(frozen=True)
class EfficiencyPoint:
    """Efficiency 6.10 at one reference."""

    v_m_s: float
    efficiency: float | None  # None with a reason
    sigma: float | None  # instruments, equations 6.16 to 6.19
    sigma_trials: float | None  # standard error of the trials' mean
    reason: str = ""
    sigma_combined: float | None = None  # both, with a significant drift
    ci95: float | None = None  # half-width of Student's interval of the trials
    u95: float | None = None  # expanded uncertainty: trials, instruments, a significant drift
    u95_dof: float | None = None  # its effective degrees of freedom; None: infinite
    u95_monte_carlo: float | None = None  # half-width of the interval of drawn errors (JCGM 101)
    sigma_as_printed: float | None = None  # 6.16 with tolerances as standard uncertainties
    # The inputs' parts of sigma by name, with their signs: an error has the same sign at all
    # points of a campaign.
    parts: dict[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class MeanEfficiency:
    """The mean over the speeds of a curve, with the correlation of its points kept."""

    efficiency: float
    sigma: float | None
    sigma_trials: float | None
    sigma_combined: float | None
    parts: dict[str, float]
    points: int


@dataclass(frozen=True)
class EfficiencyCurve:
    """Efficiency over velocity for one direction, load and rod-side pressure."""

    kind: KindName
    direction: Direction
    f_load_n: float | None
    p_lr_ref_pa: float | None
    label: str
    points: tuple[EfficiencyPoint, ...]
    mean: MeanEfficiency | None = None  # None where no point has an efficiency
    a_ref_m_s2: float | None = None  # of a ramp
    factors: Factors = ()


@dataclass(frozen=True)
class Band:
    """The friction band between the two directions at one pressure, from trials that have both."""

    kind: KindName
    label: str
    specimen: Specimen
    f_load_n: float | None
    p_lr_ref_pa: float | None
    v_m_s: float  # mean speed of the two directions, without sign
    p_tp_pa: float | None  # mean of the two directions; None without hydraulics
    half_n: float  # (F_extend - F_retract) / 2: free of a constant error in force
    half_ci95_n: float | None  # Student's, of the trials' halves; None with fewer than two
    middle_n: float  # (F_extend + F_retract) / 2: asymmetry, or an error of a sensor
    middle_ci95_n: float | None  # Student's, of the trials' middles
    energy_j: float | None  # dissipated in a cycle of whole strokes; None for single strokes
    energy_ci95_j: float | None  # Student's, of the trials' energies
    n: int  # trials
    trials: tuple[int, ...]  # their numbers
    trials_half_n: tuple[float, ...]
    trials_middle_n: tuple[float, ...]
    trials_energy_j: tuple[float, ...]  # of the trials that have it
    extend: CurvePoint
    retract: CurvePoint
    factors: Factors = ()


@dataclass(frozen=True)
class PressureLine:
    """Straight line of a force over chamber pressure, through the means of the pressures."""

    slope_n_pa: float
    slope_ci95_n_pa: float  # half-width of the 95 % interval, of pressures and trials together
    slope_se_n_pa: float  # standard error of that interval
    slope_dof: float  # degrees of freedom of that interval
    intercept_n: float  # at zero pressure
    intercept_ci95_n: float


@dataclass(frozen=True)
class BandTrend:
    """Dependence of a series' friction bands on pressure, from three pressures or more."""

    kind: KindName
    label: str
    specimen: Specimen
    p_lr_ref_pa: float | None
    pressures_pa: tuple[float, ...]  # rising
    bands: tuple[Band, ...]  # at these pressures
    half: PressureLine
    middle: PressureLine


@dataclass(frozen=True)
class MotionBalance:
    """Coulomb and viscous friction from three speeds or more in both directions.

    Of benches without hydraulics, and of curves with too few speeds for a friction law.

    Intervals are half-widths at 95 %.
    """

    kind: KindName
    label: str
    f_load_n: float | None
    speeds_m_s: tuple[float, ...]
    coulomb_n: float
    coulomb_ci95_n: float
    viscous_n_s_m: float
    viscous_ci95_n_s_m: float
    offset_n: float  # the same force in both directions
    offset_ci95_n: float
    asymmetry_n_s_m: float  # change of the middle of both directions with speed
    asymmetry_ci95_n_s_m: float
