"""Uncertainty budgets: contributions of each instrument and of the trials (6.11 to 6.19).

    instruments (type B)   sigma_B^2 = sum_k (c_k delta_k)^2,  c_k = df / dx_k
    trials (type A)        sigma_A^2 = S^2 / n
    combined               sigma^2 = sigma_A^2 + sigma_B^2

delta_k is the stated tolerance of instrument k, used as a standard uncertainty as in 6.15. An
instrument's error is the same at all points of a campaign: a gain that is 1 % high is so at every
speed and does not average out. So the contributions c_k delta_k keep their signs, and those of a
mean over points are means of the contributions. Trials are independent from point to point.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from hbench.config.sensors import Instrument, Instruments
from hbench.records import Curve, CurvePoint, Specimen
from hbench.records.numbers import NORMAL_95

LOAD_CELL = "load cell"
PISTON_SIDE, ROD_SIDE = "piston-side pressure", "rod-side pressure"


def tolerances(
    instruments: Instruments, f_applied_n: float, p_tp_pa: float, p_tr_pa: float | None
) -> dict[str, float]:
    """Return the tolerance of each instrument [N, Pa]; a tolerance of reading has its sign."""
    deltas = {
        LOAD_CELL: _tolerance(instruments.force, f_applied_n),
        PISTON_SIDE: _tolerance(instruments.pressure, p_tp_pa),
    }
    if p_tr_pa is not None:
        deltas[ROD_SIDE] = _tolerance(instruments.pressure, p_tr_pa)
    return deltas


def friction_contributions(
    point: CurvePoint, specimen: Specimen, instruments: Instruments
) -> dict[str, float]:
    """Return the instruments' contributions [N] to P_Tp A_p - P_Tr A_r - F_applied (5.1).

    Empty without hydraulics: the tolerance of the drive's force is not known.
    """
    if point.p_tp_pa is None:
        return {}
    derivatives = {
        LOAD_CELL: -1.0,
        PISTON_SIDE: specimen.area_piston_m2,
        ROD_SIDE: -specimen.area_rod_m2,
    }
    deltas = tolerances(instruments, point.f_applied_n, point.p_tp_pa, point.p_tr_pa)
    return {name: derivatives[name] * delta for name, delta in deltas.items()}


def root_sum_square(contributions: Mapping[str, float]) -> float:
    """Return the root sum of squares of independent contributions (6.15)."""
    return float(np.sqrt(np.sum(np.square(list(contributions.values())))))


def mean_contributions(points: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the contributions to a mean over points measured with the same instruments."""
    return {name: float(np.mean([point[name] for point in points])) for name in points[0]}


def expanded(ci95_trials: float, sigma_instruments: float) -> float:
    """Return the half-width of the 95 % interval of trials and instruments combined.

    It is the root sum of squares of Student's interval of the trials and 1.96 sigma of the
    instruments. Its coverage is 95 to 98 % (three trials), against 92 % with the effective degrees
    of freedom of Welch and Satterthwaite.
    """
    return float(np.hypot(ci95_trials, NORMAL_95 * sigma_instruments))


def with_instruments(curve: Curve, instruments: Instruments | None) -> Curve:
    """Return the curve with the instruments' uncertainty of each friction, if they are known."""
    if instruments is None:
        return curve
    points = tuple(_with_instruments(p, curve.specimen, instruments) for p in curve.points)
    return replace(curve, points=points)


def _with_instruments(
    point: CurvePoint, specimen: Specimen, instruments: Instruments
) -> CurvePoint:
    contributions = friction_contributions(point, specimen, instruments)
    if not contributions:
        return point
    sigma = root_sum_square(contributions)
    u95 = None if point.ci95_n is None else expanded(point.ci95_n, sigma)
    return replace(point, sigma_instruments_n=sigma, u95_n=u95)


def _tolerance(instrument: Instrument, reading: float) -> float:
    base = reading if instrument.of == "reading" else instrument.full_scale
    return instrument.tolerance * base
