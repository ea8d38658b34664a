"""Efficiency of the cylinder (6.10) and its uncertainty (6.16 to 6.19), for both flows of power.

At steady speed the fluid gives F_T v and the load takes F_applied v. Where both are positive the
hydraulics drive and eta = F_applied / F_T, as in the source. Where both are negative the load
drives and eta = F_T / F_applied. With opposite signs both sides feed the friction, and there is
no efficiency to speak of.
"""

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np

from hbench.analysis.rounding import ROUNDING, exceeds
from hbench.analysis.statistics.student import student_factor
from hbench.analysis.uncertainty.budget import (
    LOAD_CELL,
    PISTON_SIDE,
    ROD_SIDE,
    expanded,
    parts_of_mean,
    together,
    tolerances,
)
from hbench.config.sensors import Instruments
from hbench.records import (
    Curve,
    CurvePoint,
    EfficiencyCurve,
    EfficiencyPoint,
    MeanEfficiency,
    Specimen,
)

# A driving force below this share of the pressure forces that it is the difference of is zero
# to any pressure transducer.
MIN_FORCE_SHARE = 0.01


class Forces(NamedTuple):
    """What an efficiency is made of, at one steady speed."""

    v_m_s: float
    f_applied_n: float
    p_tp_pa: float
    p_tr_pa: float | None  # None only where the rod side has no area
    specimen: Specimen

    @property
    def piston_n(self) -> float:
        """P_Tp A_p."""
        return self.p_tp_pa * self.specimen.area_piston_m2

    @property
    def rod_n(self) -> float:
        """P_Tr A_r."""
        return 0.0 if self.p_tr_pa is None else self.p_tr_pa * self.specimen.area_rod_m2

    @property
    def f_test_n(self) -> float:
        """F_T = P_Tp A_p - P_Tr A_r."""
        return self.piston_n - self.rod_n


def driver(forces: Forces) -> tuple[Literal["hydraulics", "load"] | None, str]:
    """Return which side drives; or None and the reason why the efficiency is not defined."""
    f_test, f_applied = forces.f_test_n, forces.f_applied_n
    if forces.piston_n == 0 and forces.rod_n == 0:
        return None, "no pressure in either chamber, so no hydraulic power"
    whole = abs(forces.piston_n) + abs(forces.rod_n)
    least = MIN_FORCE_SHARE * whole
    into_load, from_fluid = (
        force * forces.v_m_s if abs(force) > ROUNDING * whole else 0.0
        for force in (f_applied, f_test)
    )
    side: Literal["hydraulics", "load"]
    if into_load > 0 and from_fluid > 0:
        side, force = "hydraulics", f_test
    elif into_load < 0 and from_fluid < 0:
        side, force = "load", f_applied
    else:
        sides = f"F_T = {f_test:.0f} N and F_applied = {f_applied:.0f} N"
        if into_load > 0:
            return None, f"{sides} both take power out, which no friction allows: check the sensors"
        return None, f"no flow of power through the cylinder: {sides} both feed the friction"
    if abs(force) <= least:
        return None, (
            f"driving force {force:.0f} N is zero to the pressure transducers "
            f"(less than {least:.0f} N, 1 % of the pressure forces)"
        )
    return side, ""


def efficiency_of(forces: Forces) -> float | None:
    """Return the efficiency 6.10 for the way the power flows; None where it is not defined."""
    side, _ = driver(forces)
    return None if side is None else _RATIO[side](forces.f_applied_n, forces.f_test_n)


def efficiency(curve: Curve, instruments: Instruments | None) -> EfficiencyCurve:
    """Return the efficiency at each point of a curve.

    ``sigma`` is the instruments' part (6.16); None without ``instruments`` (another bench's
    log). ``sigma_trials`` is the standard error of the mean of the trials' efficiencies.
    """
    points = tuple(_point(point, curve.specimen, instruments) for point in curve.points)
    return EfficiencyCurve(
        kind=curve.kind,
        direction=curve.direction,
        f_load_n=curve.f_load_n,
        p_lr_ref_pa=curve.p_lr_ref_pa,
        label=curve.label,
        points=points,
        mean=_mean([point for point in points if point.efficiency is not None]),
        a_ref_m_s2=curve.a_ref_m_s2,
    )


def instrument_parts(forces: Forces, instruments: Instruments) -> dict[str, float] | None:
    """Return the parts of 6.16 with the derivatives 6.17 to 6.19, or those of the inverse.

    eta = F_a / F_T:  d/dF_a = 1/F_T,  d/dP_Tp = -F_a A_p / F_T^2,  d/dP_Tr = F_a A_r / F_T^2
    eta = F_T / F_a:  d/dF_a = -F_T/F_a^2,  d/dP_Tp = A_p / F_a,  d/dP_Tr = -A_r / F_a
    """
    side, _ = driver(forces)
    if side is None:
        return None
    f_applied, f_test = forces.f_applied_n, forces.f_test_n
    if side == "hydraulics":
        by_applied, by_test = 1 / f_test, -f_applied / f_test**2
    else:
        by_applied, by_test = -f_test / f_applied**2, 1 / f_applied
    by = {
        LOAD_CELL: by_applied,
        PISTON_SIDE: by_test * forces.specimen.area_piston_m2,
        ROD_SIDE: -by_test * forces.specimen.area_rod_m2,
    }
    deltas = tolerances(instruments, f_applied, forces.p_tp_pa, forces.p_tr_pa)
    return {name: by[name] * delta for name, delta in deltas.items()}


def _point(
    point: CurvePoint, specimen: Specimen, instruments: Instruments | None
) -> EfficiencyPoint:
    forces = Forces(point.v_m_s, point.f_applied_n, point.p_tp_pa, point.p_tr_pa, specimen)
    side, reason = driver(forces)
    if side is None:
        return EfficiencyPoint(point.v_m_s, None, None, None, reason)
    value = _RATIO[side](forces.f_applied_n, forces.f_test_n)
    reasons = []
    if exceeds(value, 1.0):
        reasons.append("above 1: friction measured along with the motion, a fault of the sensors")
    if instruments is None:
        reasons.append("no sigma: the tolerances of the instruments are not known")
    parts = {} if instruments is None else instrument_parts(forces, instruments)
    sigma = together(parts) if parts else None
    sigma_trials = _trials_error(point, _RATIO[side])
    ci95 = None if sigma_trials is None else student_factor(point.n - 1) * sigma_trials
    return EfficiencyPoint(
        v_m_s=point.v_m_s,
        efficiency=value,
        sigma=sigma,
        sigma_trials=sigma_trials,
        reason="; ".join(reasons),
        sigma_combined=_combined(sigma, sigma_trials),
        ci95=ci95,
        u95=None if ci95 is None or sigma is None else expanded(ci95, sigma),
        parts=parts,
    )


def _mean(points: Sequence[EfficiencyPoint]) -> MeanEfficiency | None:
    if not points:
        return None
    parts = parts_of_mean([point.parts for point in points])
    sigma = together(parts) if parts else None
    errors = [point.sigma_trials for point in points]
    known = None not in errors
    sigma_trials = float(np.sqrt(np.sum(np.square(errors))) / len(errors)) if known else None
    return MeanEfficiency(
        efficiency=float(np.mean([point.efficiency for point in points])),
        sigma=sigma,
        sigma_trials=sigma_trials,
        sigma_combined=_combined(sigma, sigma_trials),
        parts=parts,
        points=len(points),
    )


def _combined(sigma: float | None, sigma_trials: float | None) -> float | None:
    return None if sigma is None or sigma_trials is None else float(np.hypot(sigma, sigma_trials))


def _trials_error(point: CurvePoint, ratio: Callable[[float, float], float]) -> float | None:
    if point.n < 2:
        return None
    trials = zip(point.trials_n, point.trials_f_test_n, strict=True)
    values = [ratio(f_test - friction, f_test) for friction, f_test in trials]
    return float(np.std(values, ddof=1) / np.sqrt(point.n))


_RATIO: dict[str, Callable[[float, float], float]] = {
    "hydraulics": lambda f_applied, f_test: f_applied / f_test,
    "load": lambda f_applied, f_test: f_test / f_applied,
}
