"""Uncertainty budgets: parts of each input and of the trials, combined and expanded (JCGM 100).

    inputs (type B)     u_k = c_k u(x_k): its change of the result, see ``input_errors.py``
    trials (type A)     u_A = s / sqrt(n), n - 1 degrees of freedom
    combined            u^2 = u_A^2 + sum_k u_k^2                                    (10; 6.15)
    effective dof       u^4 / (u_A^4 / (n - 1) + sum_k u_k^4 / dof_k)                (G.2b)
    expanded            U = k u, k Student's factor at 95 % for these, or 2          (G.6.4)

An input's error is the same at all points of a campaign and does not average out: the parts of a
mean over points are means of the parts, with their signs. Trials are independent from point to
point.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hbench.analysis.statistics.student import satterthwaite, student_factor
from hbench.analysis.uncertainty.input_errors import (
    InputError,
    MeasuredForces,
    far_error,
    input_errors,
    step_errors,
)
from hbench.config.sensors import Instruments
from hbench.records import Breakaway, Curve, CurvePoint, Specimen


class StandardUncertainty(NamedTuple):
    """Standard uncertainty and its degrees of freedom."""

    value: float
    dof: float = np.inf

    def expanded(self, instruments: Instruments | None = None) -> float:
        """Return the expanded uncertainty, with the factor that the instruments' file asks for."""
        if instruments is not None and instruments.expansion == "k_2":
            return 2 * self.value
        return student_factor(self.dof) * self.value


def combined(parts: Sequence[StandardUncertainty]) -> StandardUncertainty:
    """Return the uncertainty of a sum of independent parts, with effective degrees of freedom."""
    value, dof = satterthwaite([part.value**2 for part in parts], [part.dof for part in parts])
    return StandardUncertainty(value, dof)


def errors_of(
    point: CurvePoint, specimen: Specimen, instruments: Instruments
) -> tuple[InputError, ...]:
    """Return the errors of a point's inputs, those of the log included.

    None without hydraulics: the tolerance of the drive's force is not known.
    """
    if point.p_tp_pa is None:
        return ()
    forces = MeasuredForces(point.f_applied_n, point.p_tp_pa, point.p_tr_pa)
    errors = input_errors(instruments, forces, specimen)
    steps = step_errors(point.u_steps, specimen, errors)
    return (*errors, *steps, *far_error(point.far_shift_n))


def friction_parts(errors: Sequence[InputError]) -> dict[str, float]:
    """Return the parts [N] of each input in F_T - F_applied (5.1), with their signs."""
    return {error.name: error.f_test_n - error.f_applied_n for error in errors}


def friction_contributions(
    point: CurvePoint, specimen: Specimen, instruments: Instruments
) -> dict[str, StandardUncertainty]:
    """Return the inputs' parts [N] in a point's friction; empty without hydraulics."""
    errors = errors_of(point, specimen, instruments)
    return with_dof(friction_parts(errors), errors)


def with_dof(
    parts: Mapping[str, float], errors: Sequence[InputError]
) -> dict[str, StandardUncertainty]:
    """Return ``parts``, with their signs, with the degrees of freedom of ``errors``."""
    dof = {error.name: error.dof for error in errors}
    return {name: StandardUncertainty(part, dof[name]) for name, part in parts.items()}


def of_inputs(parts: Mapping[str, float], errors: Sequence[InputError]) -> StandardUncertainty:
    """Return the uncertainty of independent ``parts`` with the degrees of freedom of ``errors``."""
    return combined(list(with_dof(parts, errors).values()))


def root_sum_square(contributions: Mapping[str, float]) -> float:
    """Return the root sum of squares of independent contributions (6.15)."""
    return float(np.sqrt(np.sum(np.square(list(contributions.values())))))


def mean_contributions(points: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the contributions to a mean over points measured with the same instruments."""
    names = dict.fromkeys(name for point in points for name in point)
    return {name: float(np.mean([point.get(name, 0.0) for point in points])) for name in names}


def with_instruments(curve: Curve, instruments: Instruments | None) -> Curve:
    """Return the curve with the expanded uncertainty of each friction, if it is known."""
    if instruments is None:
        return curve
    points = tuple(_with_instruments(p, curve.specimen, instruments) for p in curve.points)
    return replace(curve, points=points)


def _with_instruments(
    point: CurvePoint, specimen: Specimen, instruments: Instruments
) -> CurvePoint:
    errors = errors_of(point, specimen, instruments)
    if not errors:
        return point
    parts = friction_parts(errors)
    inputs = of_inputs(parts, errors)
    point = replace(
        point,
        sigma_instruments_n=inputs.value,
        sigma_instruments_dof=finite_or_none(inputs.dof),
        parts_n=parts,
    )
    if point.ci95_n is None:
        return point
    whole = combined([of_trials(point.ci95_n, point.n), inputs])
    return replace(point, u95_n=whole.expanded(instruments), u95_dof=finite_or_none(whole.dof))


def of_instruments(point: CurvePoint | Breakaway) -> StandardUncertainty | None:
    """Return the instruments' part in a friction; None where it is not known."""
    if point.sigma_instruments_n is None:
        return None
    dof = point.sigma_instruments_dof
    return StandardUncertainty(point.sigma_instruments_n, np.inf if dof is None else dof)


def of_trials(ci95: float, n: int) -> StandardUncertainty:
    """Return the standard uncertainty of the mean of ``n`` trials with this interval."""
    return StandardUncertainty(ci95 / student_factor(n - 1), n - 1)


def combined_n(point: CurvePoint | Breakaway) -> float | None:
    """Return the combined standard uncertainty [N] of a friction, of all parts that are known.

    None with fewer than two trials.
    """
    if point.ci95_n is None:
        return None
    parts = [of_trials(point.ci95_n, point.n).value, point.sigma_instruments_n]
    if isinstance(point, CurvePoint):
        parts += [point.sigma_drift_n, point.sigma_temperature_n]
    return float(np.hypot.reduce([part or 0.0 for part in parts]))


def finite_or_none(dof: float) -> float | None:
    """Return degrees of freedom, None where they are infinite."""
    return float(dof) if np.isfinite(dof) else None
