"""Runs, from the plan to the screened run: the first products of the flow, a frozen dataclass each.

    RunPlan -> RawRun -> Run -> ScreenedRun -> Curve (with Fits) -> EfficiencyCurve -> Results
                                               (``curves.py``)   -> Band            ->

All quantities are SI; a field's name ends in its unit. Positive velocity extends the test
cylinder; positive forces F_L and F_applied oppose extension.
"""

from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from hbench.errors import DataError
from hbench.records.numbers import Count, KindName

Direction = Literal["extend", "retract"]
DIRECTIONS: tuple[Direction, Direction] = ("extend", "retract")
SIGNS: dict[Direction, float] = {"extend": 1.0, "retract": -1.0}  # of the velocity
DIRECTION_WORDS: dict[str, str] = {"extend": "extending", "retract": "retracting"}
# Fields that identify a curve, in records of curves, efficiencies and their numbers.
SERIES_FIELDS = ("kind", "label", "direction", "f_load_n", "p_lr_ref_pa", "a_ref_m_s2")
RUN_FLAGS = ("at_reference", "sensor_saturated", "valve_saturated")  # fields of ``Run``, by sample
Outcome = Literal["done", "aborted", "failed"]
# What else was varied, such as ("current", "0.5 A"); the label contains it too.
Factors = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class Specimen:
    """The cylinder under test."""

    area_piston_m2: float  # A_p; 0 without hydraulics
    area_rod_m2: float  # A_r, the annulus
    stroke_m: float | None = None  # None: not known

    def driving_area_m2(self, direction: Direction) -> float:
        """Return the area that the oil drives; 0 without hydraulics or a rod side."""
        return self.area_piston_m2 if direction == "extend" else self.area_rod_m2


@dataclass(frozen=True)
class Segment:
    """A piece of a run: v_ref goes to ``v_m_s`` at a slope and stays there."""

    v_m_s: float  # signed; positive extends
    a_m_s2: float
    duration_s: float  # at most
    closed: bool = False  # all valves in neutral, nothing is controlled
    vented: bool = False  # all valves opened to either side in turn, with the supply off
    # Instead of the velocity, F_T is controlled: it rises at this rate, positive to extend, until
    # the piston has moved by the displacement.
    force_rate_n_s: float = 0.0
    displacement_m: float = 0.0


@dataclass(frozen=True)
class LevelReference:
    """What the sensors should show in a zero check, with all chambers at one pressure."""

    pressure_pa: float
    limit_pa: float  # of its error
    load_cell_free: bool = False  # the load cell carries no force


@dataclass(frozen=True)
class Motion:
    """How the board moves in one run."""

    x_start_m: float
    x_min_m: float  # a segment ends early below it, on its way down,
    x_max_m: float  # and above this, on its way up
    hold_s: float  # at rest at x_start before the run, load on
    segments: tuple[Segment, ...]  # one cycle
    cycles: int = 1  # at most
    until: str = "cycles"  # or "friction", "speed_error": its settling ends the run
    within: float = 0.0  # settled: relative change from cycle to cycle

    @property
    def duration_s(self) -> float:
        """Longest possible duration."""
        return self.cycles * sum(segment.duration_s for segment in self.segments)


@dataclass(frozen=True)
class Series:
    """Label, load and rod-side pressure that averaged runs have in common."""

    label: str
    f_load_n: float | None
    p_lr_ref_pa: float | None


@dataclass(frozen=True)
class RunPlan:
    """Planned or completed run: its kind, its set-up and its references."""

    run: str  # id, also the raw log's file name
    kind: KindName  # of experiment
    trial: Count  # 1, 2, 3
    v_ref_m_s: float  # signed; positive extends
    specimen: Specimen
    a_ref_m_s2: float | None = None
    f_load_n: float | None = None  # signed reference of F_L; positive opposes extension
    p_lr_ref_pa: float | None = None
    p_lp_ref_pa: float | None = None
    label: str = ""  # distinguishes series of one campaign, such as seals
    motion: Motion | None = None  # None for runs that another bench made
    speed_is_measured: bool = False  # v_ref_m_s is the median of measured speeds: none was set
    # Positions to average over, of a stroke with a counterpart: those that both directions cover.
    x_low_m: float | None = None
    x_high_m: float | None = None
    factors: Factors = ()
    # Of a push on a piston at rest: rate of F_T, positive to extend, and the rest before.
    force_rate_n_s: float | None = None
    dwell_s: float | None = None
    level: LevelReference | None = None  # of a zero check

    @property
    def factor_values(self) -> dict[str, str]:
        """Value of each factor, such as a current or a lubricant, with its unit."""
        return dict(self.factors)

    @property
    def series(self) -> Series:
        """Series of the run."""
        return Series(self.label, self.f_load_n, self.p_lr_ref_pa)

    @property
    def operating_point(self) -> tuple[KindName, Series, Motion | None]:
        """Key of a run that hbench planned, equal for all trials of its operating point."""
        return self.kind, self.series, self.motion

    @property
    def planned_motion(self) -> Motion:
        """Motion of a run that hbench planned; only imported runs have none."""
        assert self.motion is not None, f"run {self.run} was imported"
        return self.motion

    @property
    def positions_m(self) -> tuple[float, float] | None:
        """Positions to average over; None for the whole steady window."""
        if self.x_low_m is None or self.x_high_m is None:
            return None
        return self.x_low_m, self.x_high_m

    @property
    def direction(self) -> Direction:
        """``extend`` for a positive reference, of the velocity or of the force's rate."""
        return "extend" if (self.v_ref_m_s or self.force_rate_n_s or 0.0) >= 0 else "retract"


@dataclass(frozen=True)
class LogChannel:
    """One word of a log record. ``value = scale * word``, in ``unit``."""

    name: str
    signed: bool
    scale: float
    unit: str  # "count" for a sensor: calibration turns ADC counts into SI


@dataclass(frozen=True)
class RawRun:
    """A run's log exactly as pulled: 16-bit words, one row a record."""

    plan: RunPlan
    words: np.ndarray  # (records, channels) uint16
    channels: tuple[LogChannel, ...]
    flags: tuple[str, ...]  # names of the bits of the channel "flags", lowest first
    rate_hz: float
    outcome: Outcome | None  # None: no stop part in the campaign, the host crashed
    why: str = ""  # why it was aborted or failed
    warnings: tuple[str, ...] = ()  # remarks of the file's reader


@dataclass(frozen=True)
class Run:
    """A run in SI units. Channels that the bench does not have are ``None``."""

    plan: RunPlan
    t_s: np.ndarray  # (n,) sample times; uneven for some foreign logs
    x_m: np.ndarray  # (n,)
    v_m_s: np.ndarray | None = None  # the controller's own velocity
    p_tp_pa: np.ndarray | None = None
    p_tr_pa: np.ndarray | None = None
    p_lp_pa: np.ndarray | None = None
    p_lr_pa: np.ndarray | None = None
    p_s_pa: np.ndarray | None = None
    f_applied_n: np.ndarray | None = None
    f_drive_n: np.ndarray | None = None  # of a drive without hydraulics; replaces the pressures
    u_t_v: np.ndarray | None = None
    u_l1_v: np.ndarray | None = None
    u_l2_v: np.ndarray | None = None
    v_ref_m_s: np.ndarray | None = None
    temp_tank_k: np.ndarray | None = None  # of the oil in the tank
    temp_port_k: np.ndarray | None = None  # at a port of the test cylinder
    temp_seal_k: np.ndarray | None = None  # at the test cylinder's seal
    at_reference: np.ndarray | None = None  # (n,) bool: v_ref has reached the plan's value
    sensor_saturated: np.ndarray | None = None  # (n,) bool
    valve_saturated: np.ndarray | None = None  # (n,) bool
    in_gap: np.ndarray | None = None  # (n,) bool: interpolated between samples that are far apart
    missing_records: int = 0  # lost inside the log
    truncated: str = ""  # why the log is known to be incomplete; empty if it is whole
    aborted: str = ""  # why the run was stopped early; empty if it was not

    def channel(self, name: str) -> np.ndarray:
        """Return a channel (n,) by its field's name. Raises ``DataError`` where it is missing."""
        values = getattr(self, name)
        if values is None:
            raise DataError(f"run {self.plan.run}: {name} was not measured")
        return values


TemperatureSensor = Literal["temp_seal_k", "temp_port_k", "temp_tank_k"]
# Those of the oil, the nearest to the friction first.
TEMPERATURES: tuple[TemperatureSensor, ...] = ("temp_seal_k", "temp_port_k", "temp_tank_k")


@dataclass(frozen=True)
class SteadyMeans:
    """Means over a run's steady window; None where a channel is missing.

    Accepted runs have all of them, but for the rod side of a plunger.
    """

    t_start_s: float
    t_stop_s: float
    n: int  # samples
    v_m_s: float  # signed, from the position
    friction_n: float | None  # signed like the velocity, equation 5.1
    f_test_n: float | None  # F_T = P_Tp A_p - P_Tr A_r, or the drive's force
    f_applied_n: float | None
    p_tp_pa: float | None
    p_tr_pa: float | None
    efficiency: float | None = None  # equation 6.10 for the way the power flows
    temp_tank_k: float | None = None  # of the oil, as those of ``Run``
    temp_port_k: float | None = None
    temp_seal_k: float | None = None
    # Standard deviation of the speeds between means over 0.1 s, with noise; None: short window.
    v_ripple_m_s: float | None = None
    # Standard uncertainty of the means by the steps of the log, in SI by channel, where it matters;
    # NaN: the channel has one value in the whole run, which shows no steps.
    u_steps: dict[str, float] = field(default_factory=dict)
    # Samples far from all others, such as dropouts of a sensor, and their change of mean friction.
    far_samples: int = 0
    far_shift_n: float = 0.0


@dataclass(frozen=True)
class ScreenedRun:
    """Run with its verdict: accepted, or the reasons for rejection."""

    run: Run
    reasons: tuple[str, ...]  # "code: words with value and limit"; empty: accepted
    means: SteadyMeans | None  # None where there is no window to average
    notes: tuple[str, ...] = ()  # remarks that are no reasons for rejection
    # Work against friction over a whole stroke that was cut from a cycle; None for other runs, and
    # where samples of the stroke are missing.
    work_j: float | None = None
    travel_m: float | None = None  # distance travelled in the whole log
    friction_work_j: float | None = None  # work against friction over it; None without the channels
    ends_m: tuple[float, float] | None = None  # position at the log's beginning and end

    @property
    def reason(self) -> str:
        """All reasons in one line; empty for an accepted run."""
        return "; ".join(self.reasons)

    @property
    def accepted(self) -> bool:
        """Whether there is no reason for rejection."""
        return not self.reasons


@dataclass(frozen=True)
class Provenance:
    """Origin of the data: campaign, bench, firmware, software, settings."""

    name: str
    source: Literal["simulated", "real", "imported"]
    bench: str
    firmware: str
    started: str  # ISO 8601
    stopped: str
    software: dict[str, str] = field(default_factory=dict)
    details: dict[str, Any] = field(default_factory=dict)  # port, seed, plant's hash, source files
    # Sections of bench file and schedule as they are written: instruments, controllers, limits.
    settings: dict[str, Any] = field(default_factory=dict)
