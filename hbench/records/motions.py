"""Results of runs with changing velocity and of runs at rest. All quantities are SI."""

from dataclasses import dataclass
from typing import Literal

from hbench.records.flow import Direction
from hbench.records.numbers import Count, FloatOrNan, KindName


@dataclass(frozen=True)
class Series:
    """Label, load and rod-side pressure that averaged runs have in common."""

    label: str
    f_load_n: float | None
    p_lr_ref_pa: float | None


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


@dataclass(frozen=True)
class LeakCoefficient:
    """One laminar leak [m^3/(s Pa)], conditional on bulk modulus and volumes of the bench file."""

    name: Leak
    value: float | None  # None: the runs don't determine it
    se: float | None
    ci95: tuple[FloatOrNan, FloatOrNan] | None


@dataclass(frozen=True)
class Leakage:
    """Leakage of the test cylinder with all valves closed."""

    label: str
    coefficients: tuple[LeakCoefficient, ...]
    decays: tuple["Decay", ...]
    bulk_modulus_pa: float
    message: str
    kind: KindName = "hold"


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


@dataclass(frozen=True)
class Breakaway:
    """Largest friction while a force rises on a piston at rest: means over trials."""

    series: Series
    direction: Direction
    dwell_s: float | None  # at rest under load before; None: not known
    rate_n_s: float  # of the force
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
    u95_dof: float | None = None  # effective degrees of freedom of u95_n; None: infinite


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
class Motions:
    """Results of all runs that are not steady."""

    comparisons: tuple[Comparison, ...] = ()
    loops: tuple[Loop, ...] = ()
    levels: tuple[Level, ...] = ()
    leakages: tuple[Leakage, ...] = ()
    breakaways: tuple[Breakaway, ...] = ()
    dwell_laws: tuple[DwellLaw, ...] = ()
    zero_checks: tuple[ZeroCheck, ...] = ()
    surfaces: tuple[Surface, ...] = ()
