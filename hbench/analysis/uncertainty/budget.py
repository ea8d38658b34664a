"""Uncertainty budgets: the part of each instrument and that of the trials (6.11 to 6.19).

    instruments (type B)   sigma_B^2 = sum_k (c_k delta_k)^2,  c_k = df / dx_k
    trials (type A)        sigma_A^2 = S^2 / n
    together               sigma^2 = sigma_A^2 + sigma_B^2

delta_k is the stated tolerance of instrument k, taken as a standard uncertainty as in 6.15. An
instrument's error is the same at all points of a campaign: a gain that is 1 % high is so at every
speed and does not average out. So the parts c_k delta_k keep their signs, and those of a mean over
points are means of the parts. Trials are independent from point to point.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hbench.config.sensors import Instrument, Instruments
from hbench.records import Curve, CurvePoint, Specimen

NORMAL_95 = 1.959964
LOAD_CELL = "load cell"
PISTON_SIDE, ROD_SIDE = "piston-side pressure", "rod-side pressure"


def tolerances(
    instruments: Instruments, f_applied_n: float, p_tp_pa: float, p_tr_pa: float | None
) -> dict[str, float]:
    """Return the tolerance of each instrument [N, Pa]; one of the reading has its sign."""
    found = {
        LOAD_CELL: _tolerance(instruments.force, f_applied_n),
        PISTON_SIDE: _tolerance(instruments.pressure, p_tp_pa),
    }
    if p_tr_pa is not None:
        found[ROD_SIDE] = _tolerance(instruments.pressure, p_tr_pa)
    return found


def friction_parts(point: CurvePoint, specimen: Specimen, known: Instruments) -> dict[str, float]:
    """Return the instruments' parts [N] in friction P_Tp A_p - P_Tr A_r - F_applied (5.1)."""
    by = {LOAD_CELL: -1.0, PISTON_SIDE: specimen.area_piston_m2, ROD_SIDE: -specimen.area_rod_m2}
    deltas = tolerances(known, point.f_applied_n, point.p_tp_pa, point.p_tr_pa)
    return {name: by[name] * delta for name, delta in deltas.items()}


def together(parts: Mapping[str, float]) -> float:
    """Return the root sum of squares of independent parts (6.15)."""
    return float(np.sqrt(np.sum(np.square(list(parts.values())))))


def parts_of_mean(points: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the parts in a mean over points that all have the same instruments."""
    return {name: float(np.mean([parts[name] for parts in points])) for name in points[0]}


def expanded(ci95_trials: float, sigma_instruments: float) -> float:
    """Return the half-width of a 95 % interval of trials and instruments together.

    Student's interval of the trials and 1.96 sigma of the instruments, added as squares. It holds
    the truth in 95 to 98 % (three trials), where the effective degrees of freedom of Welch and
    Satterthwaite fall to 92 %.
    """
    return float(np.hypot(ci95_trials, NORMAL_95 * sigma_instruments))


def with_instruments(curve: Curve, instruments: Instruments | None) -> Curve:
    """Return the curve with the instruments' part in each friction, where they are known."""
    if instruments is None:
        return curve
    points = tuple(_with_instruments(p, curve.specimen, instruments) for p in curve.points)
    return replace(curve, points=points)


def _with_instruments(point: CurvePoint, specimen: Specimen, known: Instruments) -> CurvePoint:
    sigma = together(friction_parts(point, specimen, known))
    u95 = None if point.ci95_n is None else expanded(point.ci95_n, sigma)
    return replace(point, sigma_instruments_n=sigma, u95_n=u95)


def _tolerance(instrument: Instrument, reading: float) -> float:
    base = reading if instrument.of == "reading" else instrument.full_scale
    return instrument.tolerance * base
