"""Results of ``design`` for the controllers of a bench. All quantities are SI."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True)
class LoopMerits:
    """Figures of merit and curves of one loop with one chain of dynamics.

    A margin or a bandwidth is infinite where there is no crossing.
    """

    chain: str  # "ideal valve", "valve" or "board" (valve, filters, sampling, other loops closed)
    bandwidth_rad_s: float
    phase_margin_deg: float
    gain_margin: float  # a factor
    phase_margin_rad_s: float  # where it is read
    gain_margin_rad_s: float
    overshoot: float  # of a unit step, as a ratio
    settling_s: float  # to within 2 %
    digital_modulus: float  # largest modulus of the digital closed loop's poles
    omega_rad_s: np.ndarray  # (n,)
    open_loop: np.ndarray  # (n,) complex
    t_s: np.ndarray  # (m,)
    step: np.ndarray  # (m,) response to a unit step of the reference
    digital_poles: np.ndarray  # (k,) complex, closed loop at the control rate
    poles_rad_s: np.ndarray | None = None  # (k,) closed loop; None for the sampled board
    zeros_rad_s: np.ndarray | None = None

    @property
    def stable(self) -> bool:
        """Whether all poles of the closed loop decay, the continuous and the digital ones."""
        grows = self.poles_rad_s is not None and bool((self.poles_rad_s.real > 0).any())
        return self.digital_modulus < 1 and not grows


@dataclass(frozen=True)
class RootLocus:
    """Closed-loop poles as the controller's gain grows."""

    gain_factor: np.ndarray  # (n,) times the design's gain; 1 is among them
    poles_rad_s: np.ndarray  # (n, k) complex
    open_poles_rad_s: np.ndarray
    zeros_rad_s: np.ndarray


@dataclass(frozen=True)
class ControlLoop:
    """One of the three PI loops at an operating point."""

    name: str  # velocity, rod pressure, piston pressure
    symbol: str  # of the source: T, Lr, Lp
    gain: float  # K_c of 4.36
    gain_unit: str
    time_constant_s: float  # tau_c
    merits: tuple[LoopMerits, ...]  # ideal valve, valve, board
    locus: tuple[RootLocus, ...]  # ideal valve, valve


@dataclass(frozen=True)
class Reproduced:
    """Number printed in the source, and the value computed here."""

    quantity: str
    unit: str
    printed: str
    obtained: float
    error: float | None  # relative; None where the source prints a limit or words
    agrees: bool
    note: str


@dataclass(frozen=True)
class Check:
    """One condition on gains, and whether it holds."""

    what: str
    value: float
    limit: float
    unit: str
    holds: bool
    where: str = ""  # the worst case


@dataclass(frozen=True)
class Proposal:
    """Gains for a bench, and the verdict on them."""

    gains: dict[str, tuple[float, float]]  # loop: K_c, tau_c
    bandwidths_rad_s: dict[str, float]  # loop: of its design; from fast to slow
    feedforward: tuple[float, float]  # rod, piston [V s/m]
    ratio: float  # of neighbouring bandwidths
    points: int  # of the grid, at which the margins were computed
    left_out: tuple[str, ...]  # points that the bench cannot reach, with the reason
    margins: tuple[Check, ...]
    closed_loop: tuple[Check, ...]  # the firmware against the nonlinear bench and its variants
    loops: tuple[ControlLoop, ...] = ()  # with these gains, at the design's operating point
    other_ratios: dict[float, bool] = field(default_factory=dict)  # tried: whether all checks hold

    @property
    def holds(self) -> bool:
        """Every condition holds."""
        return all(check.holds for check in (*self.margins, *self.closed_loop))


@dataclass(frozen=True)
class DesignBasis:
    """What a design was computed from: the bench file's cylinder, supply, limits, feedforward."""

    day: str  # ISO 8601
    file: str
    bore_m: float
    rod_m: float
    stroke_m: float
    supply_pa: float
    travel_m: tuple[float, float]
    pressure_max_pa: float
    speed_max_m_s: float
    feedforward: tuple[float, float]  # rod, piston [V s/m]
    feedforward_enabled: bool


class MarginRange(NamedTuple):
    """Smallest and largest margin of a loop over operating points, in deg or dB."""

    low: float
    high: float
    where: str  # the operating point of the smallest


class PointMargins(NamedTuple):
    """Margins of all loops at an operating point of the grid."""

    x_m: float
    v_m_s: float
    f_load_n: float
    margins: dict[str, float]  # in deg or dB, by the check: ``velocity: phase margin``
    holds: bool  # all checks


@dataclass(frozen=True)
class Design:
    """The controllers of a bench at an operating point."""

    bench: str
    point: dict[str, float]  # fields of control.linearisation.OperatingPoint
    f_load_n: float  # at this point, on the piston rod
    coefficients: dict[str, float]  # 4.14 to 4.23 and volumes
    jacobian_difference: float  # of the linearisation by hand from the plant's, relative
    loops: tuple[ControlLoop, ...]
    feedforward: tuple[float, float]  # 4.27, 4.28 [V s/m]
    ramp_error_m_s: float  # of the velocity loop at 100 mm/s^2, 4.37
    coupled_modulus: float  # all three loops on the board
    tick_s: float  # sampling period of the board's loops
    reproduced: tuple[Reproduced, ...] = ()  # of the source's bench alone
    proposal: Proposal | None = None
    checks: tuple[Check, ...] = ()  # of the present gains on the board, at the operating point
    basis: DesignBasis | None = None  # None: not from a bench file
    # Of the present gains over all operating points, by the check.
    margin_ranges: dict[str, MarginRange] = field(default_factory=dict)
    points: int = 0  # of these ranges
    points_failed: int = 0  # of these, where the present gains fail a check
    grid: tuple[PointMargins, ...] = ()  # these points
