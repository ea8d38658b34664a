"""Results of runs with changing velocity and of runs at rest. All quantities are SI."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from hbench.records.numbers import Count, FloatOrNan, KindName
from hbench.records.runs import Direction, Series


@dataclass(frozen=True)
class Comparison:
    """Friction's difference between groups of runs over a range of speeds, tested.

    The unit is the trial: its mean friction over the range.
    """

    what: Literal["acceleration", "steady"]  # ramps among themselves; a ramp against steady runs
    series: Series
    direction: Direction
    a_m_s2: tuple[float, ...]  # accelerations of the ramps, rising
    v_low_m_s: float  # lower end of the range of speeds
    v_high_m_s: float  # its upper end
    effect_n: float  # |F| at the largest acceleration less the smallest; or ramp less steady
    ci95_n: float | None  # half-width of the 95 % interval; None without scatter
    p_value: float | None  # of no difference at all
    p_holm: float | None  # after Holm, over all tests of the same ``what``
    n: int  # trials
    message: str = ""
    kind: KindName = "ramp"


@dataclass(frozen=True)
class LoopWidth:
    """Width of a loop over velocity at one velocity."""

    v_m_s: float  # signed
    width_n: float  # |F| while |v| rises less |F| while it falls
    ci95_n: float | None
    board_n: float | None  # the same over the controller's own, filtered velocity


@dataclass(frozen=True)
class Loop:
    """Hysteresis of one triangle: means over cycles and trials."""

    series: Series
    v_top_m_s: float
    a_m_s2: float | None
    cycles: int  # that were averaged
    trials: int
    unit: Literal["trial", "cycle"]  # sampling unit of the intervals
    area_j: float  # energy per cycle: integral of F dx around the loop
    area_ci95_j: float | None
    widths: tuple[LoopWidth, ...]
    trace: tuple[tuple[float, float, float], ...]  # x_m, v_m_s, friction_n, mean over cycles
    runs: tuple[str, ...]
    kind: KindName = "triangle"


@dataclass(frozen=True)
class Level:
    """One step of the reference: friction before, after, and on its way."""

    series: Series
    number: Count  # of the level in its run, from 1
    v_from_m_s: float
    v_to_m_s: float
    before_n: float | None  # settled friction of the level before; None after rest
    after_n: float
    after_ci95_n: float | None
    overshoot_n: float | None  # beyond after_n, the way friction changes; None: not above noise
    settling_s: float | None  # until friction stays near after_n; None: no swing above noise
    n: int  # trials
    runs: tuple[str, ...]
    overshoot_ci95_n: float | None = None  # over trials
    settling_ci95_s: float | None = None
    settling_step_s: float | None = None  # one record: the resolution of settling_s
    remark: str = ""  # why the overshoot is not known, or not resolved
    resolved: bool = True  # whether the log resolves the overshoot
    kind: KindName = "steps"


Leak = Literal["across_piston", "piston_side_out", "rod_side_out"]

# Assumed errors (95 %) in the interval of a leak.
TEMPERATURE_RATE_K_S = 0.2 / 60  # change of the oil temperature during a hold
OIL_EXPANSION_1_K = 7e-4  # thermal expansion of mineral oil
BULK_MODULUS_ERROR = 0.1  # of the stated effective bulk modulus


@dataclass(frozen=True)
class LeakCoefficient:
    """One leak [m^3/(s Pa)], conditional on the stated volumes."""

    name: Leak
    value: float | None  # None: the runs don't determine it
    se: float | None
    ci95: tuple[FloatOrNan, FloatOrNan] | None  # of the fit and of the assumed errors


@dataclass(frozen=True)
class Leakage:
    """Leakage of the test cylinder with all valves closed.

    A leak at the pressure p is C p |p / reference_pa|^(exponent - 1).
    """

    label: str
    coefficients: tuple[LeakCoefficient, ...]
    decays: tuple["Decay", ...]
    bulk_modulus_pa: float
    message: str
    kind: KindName = "hold"
    exponent: float = 1.0  # of the pressure, the same for all leaks; 1: laminar
    exponent_ci95: float | None = None  # half-width of its interval; None: not fitted
    reference_pa: float | None = None  # pressure at which a coefficient is that of a laminar leak
    step_pa: float | None = None  # smallest of the logged pressures, of the coarser side

    def flow_m3_s(self, leak: LeakCoefficient, pressure_pa: float) -> tuple[float, float] | None:
        """Return the flow of a leak at a pressure, and the half-width of its 95 % interval.

        None where the runs do not determine it. The errors of coefficient and exponent are taken
        as independent, since the reference pressure lies in the middle of those measured.
        """
        if leak.value is None or leak.ci95 is None:
            return None
        ratio = pressure_pa / (self.reference_pa or pressure_pa)
        scale = pressure_pa * ratio ** (self.exponent - 1.0)
        half = max(leak.value - leak.ci95[0], leak.ci95[1] - leak.value)
        by_exponent = leak.value * math.log(ratio) * (self.exponent_ci95 or 0.0)
        return leak.value * scale, math.hypot(half, by_exponent) * scale

    def highest_pa(self, leak: Leak) -> float:
        """Return the highest mean pressure of a hold that drives a leak."""
        return max(
            {
                "across_piston": abs(decay.p_p_pa - decay.p_r_pa),
                "piston_side_out": decay.p_p_pa,
                "rod_side_out": decay.p_r_pa,
            }[leak]
            for decay in self.decays
        )

    def at_highest_pressure(
        self,
    ) -> Iterator[tuple[LeakCoefficient, float, tuple[float, float] | None]]:
        """Yield each leak with the highest pressure [Pa] of its holds and ``flow_m3_s`` there."""
        for leak in self.coefficients:
            pressure_pa = self.highest_pa(leak.name)
            yield leak, pressure_pa, self.flow_m3_s(leak, pressure_pa)


@dataclass(frozen=True)
class Decay:
    """Decay of the pressures in one hold."""

    run: str
    series: Series
    p_p_pa: float  # means
    p_r_pa: float
    rate_p_pa_s: float  # slopes
    rate_r_pa_s: float
    # Oil that left the piston side: V/beta times the pressure loss, less the displaced volume.
    out_p_m3_s: float
    out_r_m3_s: float  # the same of the rod side
    # Course over time: t_s, and the oil that has left each side since the first row, in m^3.
    trace: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True)
class Breakaway:
    """Largest friction while a force rises on a piston at rest: means over trials."""

    series: Series
    direction: Direction
    dwell_s: float | None  # at rest under load before; None: not known
    rate_n_s: float | None  # of the force; None: not known, as for imported runs
    breakaway_n: float  # against the motion
    ci95_n: float | None  # half-width of Student's interval over the trials
    u95_n: float | None  # the same with the instruments
    n: Count  # trials
    trials_n: tuple[float, ...]
    displacement_m: float  # of the piston at the largest friction
    p_tp_pa: float | None  # pressures at that moment
    p_tr_pa: float | None
    f_applied_n: float
    runs: tuple[str, ...]
    kind: KindName = "breakaway"
    breakaway_pa: float | None = None  # the same on the driving area; None without hydraulics
    u95_pa: float | None = None
    u95_dof: float | None = None  # effective degrees of freedom of u95_n; None: infinite
    v_m_s: float | None = None  # of the creep at the largest friction, in its direction
    sigma_instruments_n: float | None = None  # 6.15 for 5.1; None where they are not known
    sigma_instruments_dof: float | None = None  # its degrees of freedom; None: infinite


@dataclass(frozen=True)
class DwellLaw:
    """Breakaway over the time at rest, fitted to the trials of one direction and load."""

    series: Series
    direction: Direction
    law: Literal["logarithmic", "power"]
    f_1s_n: float  # breakaway after 1 s at rest
    f_1s_ci95_n: float
    # Growth for each decade of the time: N (logarithmic), or the exponent (power).
    growth: float
    growth_ci95: float
    rmse_n: float
    dwells: Count
    n: Count  # trials
    kind: KindName = "breakaway"


@dataclass(frozen=True)
class Zero:
    """Zero of a sensor, as a zero check found it."""

    channel: str  # p_tp_pa, p_tr_pa, p_lp_pa, p_lr_pa or f_applied_n
    error: float  # of its reading, Pa or N; subtracted from the campaign's logs
    limit: float  # of the bench file, at full scale
    clipped: bool = False  # the sensor shows its lowest value: the zero is not known


@dataclass(frozen=True)
class ZeroCheck:
    """Zeros of the sensors with the supply off and all chambers at one pressure."""

    run: str
    time_s: float | None  # after the first run's start; None: not known
    pressure_pa: float  # that all transducers should show
    pressure_limit_pa: float  # of its error
    zeros: tuple[Zero, ...]
    kind: KindName = "check"


@dataclass(frozen=True)
class Surface:
    """Friction over velocity and load, on the speeds and the loads that were measured."""

    label: str
    direction: Direction
    p_lr_ref_pa: float | None
    v_m_s: tuple[float, ...]  # magnitudes, rising
    f_load_n: tuple[float, ...]  # signed, rising
    friction_n: tuple[tuple[float, ...], ...]  # magnitudes, a row a load
    ci95_n: tuple[tuple[float | None, ...], ...]
    kind: KindName = "steady"


@dataclass(frozen=True)
class DistanceTrend:
    """Quantity of repeated runs or cycles over the distance travelled in the campaign."""

    # Friction against the motion, of steady runs or of a triangle's cycles; breakaway; or the oil
    # that leaves the chamber of the higher pressure in a hold.
    quantity: Literal["friction_n", "breakaway_n", "leakage_m3_s"]
    series: Series
    direction: Direction | None  # None: both, or at rest
    v_m_s: float | None  # of steady runs, or the largest of a cycle
    dwell_s: float | None  # at rest before breakaway
    distance_m: tuple[float, ...]
    values: tuple[float, ...]
    slope: float  # for each metre, over all values
    slope_ci95: float  # half-width of its 95 % interval
    intercept: float
    p: float  # of no slope
    p_holm: float  # after Holm, over all trends of the campaign
    # The last half of the values, four at least: where it begins, its mean, and its change along a
    # straight line of its own.
    last_from_m: float
    last_mean: float
    last_change: float
    last_change_ci95: float
    # Settled: the interval of the last change lies within 5 % of the last mean. Changing: it is
    # wider and does not contain 0.
    verdict: Literal["settled", "changing", "not determined"]
    kind: KindName = "steady"


@dataclass(frozen=True)
class Motions:
    """Results of all runs that are not steady, and of repeated runs over the distance."""

    comparisons: tuple[Comparison, ...] = ()
    loops: tuple[Loop, ...] = ()
    levels: tuple[Level, ...] = ()
    leakages: tuple[Leakage, ...] = ()
    breakaways: tuple[Breakaway, ...] = ()
    dwell_laws: tuple[DwellLaw, ...] = ()
    zero_checks: tuple[ZeroCheck, ...] = ()
    surfaces: tuple[Surface, ...] = ()
    over_distance: tuple[DistanceTrend, ...] = ()

    @property
    def load_cell_zero_unchecked(self) -> bool:
        """Whether zeros were checked, but that of the load cell was not."""
        channels = {zero.channel for check in self.zero_checks for zero in check.zeros}
        return bool(channels) and "f_applied_n" not in channels
