"""Hydro-mechanical efficiency (6.10) and its uncertainty (6.16 to 6.19), for both power flows.

At steady speed the fluid supplies F_T v and the load receives F_applied v. If both are positive the
hydraulics drive and eta = F_applied / F_T, as in the source. If both are negative the load drives
and eta = F_T / F_applied. With opposite signs both sides supply the friction, and the efficiency is
not defined.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from hbench.analysis.rounding import ROUNDING, exceeds
from hbench.analysis.statistics.student import student_factor
from hbench.analysis.uncertainty.budget import (
    StandardUncertainty,
    combined,
    errors_of,
    finite_or_none,
    mean_contributions,
    of_inputs,
    root_sum_square,
)
from hbench.analysis.uncertainty.input_errors import InputError
from hbench.config.sensors import Instruments
from hbench.records import (
    Curve,
    CurvePoint,
    EfficiencyCurve,
    EfficiencyPoint,
    MeanEfficiency,
    Specimen,
)

# A driving force is a difference of pressure forces. Below this share of them, pressure transducers
# can't distinguish it from zero.
MIN_FORCE_SHARE = 0.01


class SteadyForces(NamedTuple):
    """Forces on the test cylinder at a steady speed."""

    v_m_s: float
    f_applied_n: float
    p_tp_pa: float | None  # None without hydraulics
    p_tr_pa: float | None  # None for a plunger, and without hydraulics
    specimen: Specimen
    f_drive_n: float | None = None  # in place of the pressures

    @property
    def piston_n(self) -> float:
        """P_Tp A_p, or the drive's force."""
        if self.p_tp_pa is None:
            return self.f_drive_n or 0.0
        return self.p_tp_pa * self.specimen.area_piston_m2

    @property
    def rod_n(self) -> float:
        """P_Tr A_r."""
        return 0.0 if self.p_tr_pa is None else self.p_tr_pa * self.specimen.area_rod_m2

    @property
    def f_test_n(self) -> float:
        """F_T = P_Tp A_p - P_Tr A_r."""
        return self.piston_n - self.rod_n


def driving_side(forces: SteadyForces) -> tuple[Literal["hydraulics", "load"] | None, str]:
    """Return the driving side; or None and the reason why the efficiency is not defined."""
    f_test, f_applied = forces.f_test_n, forces.f_applied_n
    if forces.piston_n == 0 and forces.rod_n == 0:
        return None, "no hydraulic power: both chambers have zero pressure"
    if f_applied == 0:
        return None, "no power into or out of the load: F_applied is 0 N"
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
            return None, f"{sides} both take power out, which is impossible: check the sensors"
        return None, f"no power through the cylinder: {sides} both supply the friction"
    if abs(force) <= least:
        return None, (
            f"driving force {force:.0f} N is not distinguishable from zero by the pressure "
            f"transducers; limit {least:.0f} N, 1 % of the pressure forces"
        )
    return side, ""


def forces_of(point: CurvePoint, specimen: Specimen) -> SteadyForces:
    """Return the forces at a point of a curve."""
    pressures = point.p_tp_pa, point.p_tr_pa
    return SteadyForces(point.v_m_s, point.f_applied_n, *pressures, specimen, point.f_test_n)


def efficiency_of(forces: SteadyForces) -> float | None:
    """Return the efficiency 6.10 for the driving side; None if it is not defined."""
    side, _ = driving_side(forces)
    return None if side is None else _RATIO[side](forces.f_applied_n, forces.f_test_n)


def efficiency_curve(curve: Curve, instruments: Instruments | None) -> EfficiencyCurve:
    """Return the efficiency at each point of a curve.

    ``sigma`` is the instruments' contribution (6.16); None without ``instruments`` (imported logs).
    ``sigma_trials`` is the standard error of the mean of the trials' efficiencies.
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
        factors=curve.factors,
    )


def efficiency_parts(forces: SteadyForces, errors: Sequence[InputError]) -> dict[str, float]:
    """Return the parts of 6.16 with the derivatives 6.17 to 6.19, or of the inverse.

    Empty if the efficiency is not defined.

    eta = F_a / F_T:  d/dF_a = 1/F_T,  d/dF_T = -F_a / F_T^2
    eta = F_T / F_a:  d/dF_a = -F_T/F_a^2,  d/dF_T = 1 / F_a
    """
    side, _ = driving_side(forces)
    if side is None:
        return {}
    f_applied, f_test = forces.f_applied_n, forces.f_test_n
    if side == "hydraulics":
        by_applied, by_test = 1 / f_test, -f_applied / f_test**2
    else:
        by_applied, by_test = -f_test / f_applied**2, 1 / f_applied
    return {each.name: by_applied * each.f_applied_n + by_test * each.f_test_n for each in errors}


def _point(
    point: CurvePoint, specimen: Specimen, instruments: Instruments | None
) -> EfficiencyPoint:
    forces = forces_of(point, specimen)
    side, reason = driving_side(forces)
    if side is None:
        return EfficiencyPoint(point.v_m_s, None, None, None, reason)
    value = _RATIO[side](forces.f_applied_n, forces.f_test_n)
    reasons = []
    if exceeds(value, 1.0):
        reasons.append("above 1: measured friction has the motion's direction: check the sensors")
    if instruments is None:
        reasons.append("no sigma: the tolerances of the instruments are not known")
    sigma_trials = _trials_error(point, _RATIO[side])
    of_trials = EfficiencyPoint(
        v_m_s=point.v_m_s,
        efficiency=value,
        sigma=None,
        sigma_trials=sigma_trials,
        reason="; ".join(reasons),
        ci95=None if sigma_trials is None else student_factor(point.n - 1) * sigma_trials,
    )
    if instruments is None:
        return of_trials
    return _with_instruments(of_trials, point, forces, instruments)


def _with_instruments(
    efficiency: EfficiencyPoint, point: CurvePoint, forces: SteadyForces, instruments: Instruments
) -> EfficiencyPoint:
    errors = errors_of(point, forces.specimen, instruments)
    if not errors:
        return efficiency
    parts = efficiency_parts(forces, errors)
    printed = errors_of(
        replace(point, u_steps={}, far_shift_n=0.0), forces.specimen, instruments.as_printed
    )
    inputs = of_inputs(parts, errors)
    known = replace(
        efficiency,
        sigma=inputs.value,
        sigma_as_printed=root_sum_square(efficiency_parts(forces, printed)),
        parts=parts,
    )
    if efficiency.sigma_trials is None:
        return known
    whole = combined([StandardUncertainty(efficiency.sigma_trials, point.n - 1), inputs])
    return replace(
        known,
        sigma_combined=whole.value,
        u95=whole.expanded(instruments),
        u95_dof=finite_or_none(whole.dof),
    )


def _mean(points: Sequence[EfficiencyPoint]) -> MeanEfficiency | None:
    if not points:
        return None
    contributions = mean_contributions([point.parts for point in points])
    sigma = root_sum_square(contributions) if contributions else None
    errors = [point.sigma_trials for point in points if point.sigma_trials is not None]
    known = len(errors) == len(points)
    sigma_trials = float(np.sqrt(np.sum(np.square(errors))) / len(errors)) if known else None
    return MeanEfficiency(
        efficiency=float(np.mean([point.efficiency for point in points])),
        sigma=sigma,
        sigma_trials=sigma_trials,
        sigma_combined=_combined(sigma, sigma_trials),
        parts=contributions,
        points=len(points),
    )


def _combined(sigma: float | None, sigma_trials: float | None) -> float | None:
    return None if sigma is None or sigma_trials is None else float(np.hypot(sigma, sigma_trials))


def _trials_error(point: CurvePoint, ratio: Callable[[float, float], float]) -> float | None:
    """Return the standard error of the trials' efficiencies; None if one of them has none."""
    if point.n < 2:
        return None
    trials = zip(point.trials_n, point.trials_f_test_n, strict=True)
    try:
        values = [ratio(f_test - friction, f_test) for friction, f_test in trials]
    except ZeroDivisionError:  # a trial without load
        return None
    return float(np.std(values, ddof=1) / np.sqrt(point.n))


_RATIO: dict[str, Callable[[float, float], float]] = {
    "hydraulics": lambda f_applied, f_test: f_applied / f_test,
    "load": lambda f_applied, f_test: f_test / f_applied,
}
