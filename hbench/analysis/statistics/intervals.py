"""Covariance of a least-squares solution, and 95 % intervals of its parameters.

    independent residuals   C = s^2 (J'J)^-1,  s^2 = RSS / (n - p)
    residuals of runs       C = (G-1)/G sum_g d_g d_g',  d_g = (J'J - J_g'J_g)^-1 J_g' r_g

The second is the jackknife that leaves out one of G runs at a time, to first order. Consecutive
samples of a log at 100 Hz have the same level of friction of their stroke, so samples are not
independent; runs are. A variance that few of the runs determine has few degrees of freedom:

    dof = (G-1)/G (sum_g v_g)^2 / sum_g v_g^2

with v_g the expected d_g^2 where all residuals scatter alike (Satterthwaite; Bell and McCaffrey
2002). It is G - 1 where all runs say the same.
"""

from collections.abc import Mapping, Sequence
from typing import Literal, NamedTuple

import numpy as np

from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.student import student_factor
from hbench.records import FitParameter
from hbench.sentences import listed

Bound = Literal["lower", "upper"] | None
_SINGULAR = 1e-13  # of the largest eigenvalue of J'J, with columns of length 1
_PART = 1e-3  # of a parameter's axis in directions that the data does not see
_OF_SIZE = 0.1  # of the typical size


def covariance(
    jacobian: np.ndarray, residual: np.ndarray, effect: np.ndarray | None = None
) -> np.ndarray:
    """Return the covariance (p, p) from derivatives (n, p) and independent residuals (n,).

    Entries that the data does not determine are nan: those of parameters that others can replace,
    and of parameters without ``effect`` (p,) bool. By default only columns of zeros have none.
    """
    n, p = jacobian.shape
    if n <= p:
        return np.full((p, p), np.nan)
    inverse, unknown = _inverse(jacobian.T @ jacobian, effect)
    return _without(unknown, inverse * float(residual @ residual) / (n - p))


class OverRuns(NamedTuple):
    """Covariance (p, p) over runs, and the degrees of freedom (p,) of its variances."""

    covariance: np.ndarray
    dof: np.ndarray


def covariance_over_runs(
    jacobian: np.ndarray,
    residual: np.ndarray,
    run: np.ndarray,
    effect: np.ndarray | None = None,
) -> OverRuns:
    """Return the covariance if only samples of different ``run`` (n,) are independent.

    Entries not determined without one of the runs are nan. ``effect`` as in ``covariance``.
    """
    p, numbers = jacobian.shape[1], np.unique(run)
    total, spread = jacobian.T @ jacobian, np.zeros((p, p))
    unknown, shares = np.zeros(p, dtype=bool), np.zeros((len(numbers), p))
    if len(numbers) < 2:
        return OverRuns(np.full((p, p), np.nan), np.full(p, np.nan))
    for share, number in zip(shares, numbers, strict=True):
        of_run = run == number
        j = jacobian[of_run]
        inverse, lost = _inverse(total - j.T @ j, effect)
        step = inverse @ (j.T @ residual[of_run])
        spread += np.outer(step, step)
        share[:] = np.sum((j @ inverse) ** 2, axis=0)
        unknown |= lost
    kept = (len(numbers) - 1) / len(numbers)
    with np.errstate(invalid="ignore"):
        dof = kept * shares.sum(axis=0) ** 2 / np.sum(shares**2, axis=0)
    return OverRuns(_without(unknown, kept * spread), dof)


def has_effect(jacobian: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return which parameters (p,) change the curve by more than rounding.

    ``jacobian`` (n, p) are the derivatives, ``size`` (p,) the parameters' typical sizes. Changed by
    its typical size, a parameter moves the curve by |J_j| size_j. One that moves it by less than
    1e-9 of what another does has no effect.
    """
    moved = np.linalg.norm(jacobian, axis=0) * size
    return moved > ROUNDING * moved.max(initial=0.0)


def too_wide(
    half_width: np.ndarray,
    values: np.ndarray,
    size: np.ndarray,
    ends_at_bound: np.ndarray | bool = False,
) -> np.ndarray:
    """Return which intervals (p,) are too wide for their parameters to be determined.

    Their half-width exceeds the value, or a bound of the fit cuts them off (``ends_at_bound``
    (p,) bool), and it exceeds a tenth of the parameter's typical ``size`` (p,).
    """
    too_far = (half_width > np.abs(values)) | ends_at_bound
    return too_far & (half_width > _OF_SIZE * size)


def fit_parameters(
    units: Mapping[str, str],
    values: np.ndarray,
    covariance: np.ndarray,
    dof: np.ndarray,
    at_bound: Sequence[Bound],
    size: np.ndarray,
) -> dict[str, FitParameter]:
    """Return the parameters named by ``units`` (name -> unit) with Student's 95 % intervals.

    ``covariance`` is that of the parameters off their bounds, in their order, and ``dof`` are the
    degrees of freedom of their variances; the others have no interval. ``size`` (p,) are typical
    sizes, by which an interval is ``too_wide`` or not.
    """
    errors, t = np.full((2, len(values)), np.nan)
    free = [bound is None for bound in at_bound]
    errors[free] = np.sqrt(np.diag(covariance))
    t[free] = [student_factor(each) if each > 0 else np.nan for each in dof.tolist()]
    wide = too_wide(t * errors, values, size).tolist()
    parameters = {}
    for i, ((name, unit), value, bound) in enumerate(
        zip(units.items(), values.tolist(), at_bound, strict=True)
    ):
        error, half = float(errors[i]), float(t[i] * errors[i])
        known = bool(np.isfinite(half))
        parameters[name] = FitParameter(
            value=value,
            se=error if known else None,
            ci95=(value - half, value + half) if known else None,
            at_bound=bound,
            unit=unit,
            wide=wide[i],
        )
    return parameters


def parameter_messages(parameters: Mapping[str, FitParameter]) -> list[str]:
    """Return a sentence on each parameter at a bound, and one on undetermined parameters."""
    messages = [
        f"{name} is at its {p.at_bound} bound {p.value:g} {p.unit}: the other parameters depend on "
        "this bound"
        for name, p in parameters.items()
        if p.at_bound
    ]
    unknown = [
        name
        for name, p in parameters.items()
        if p.determination == "not determined" and not p.at_bound
    ]
    if unknown:
        messages.append(f"the data does not determine {listed(unknown)}")
    return messages


def _inverse(normal: np.ndarray, effect: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Return the pseudo-inverse of J'J, and which parameters J does not determine."""
    if effect is not None:
        normal = np.where(np.outer(effect, effect), normal, 0.0)
    diagonal = np.diag(normal)
    scale = np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    s2, vectors = np.linalg.eigh(normal / np.outer(scale, scale))
    used = s2 > _SINGULAR * s2[-1]
    inverse = (vectors[:, used] / s2[used]) @ vectors[:, used].T / np.outer(scale, scale)
    return inverse, parts_in(vectors[:, ~used]) > _PART


def parts_in(directions: np.ndarray) -> np.ndarray:
    """Return the length of each axis's projection (p,) onto orthonormal ``directions`` (p, k).

    It does not depend on the basis that an eigenvalue routine has chosen.
    """
    return np.linalg.norm(directions, axis=1)


def _without(unknown: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    return np.where(unknown[:, None] | unknown, np.nan, matrix)
