"""Friction bands between the two directions, and their dependence on pressure and speed.

All quantities are SI, as in ``runs.py``.
"""

from dataclasses import dataclass

from hbench.records.curves import CurvePoint
from hbench.records.numbers import KindName
from hbench.records.runs import Factors, Specimen


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
