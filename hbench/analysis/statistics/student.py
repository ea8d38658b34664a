"""Student's factor for two-sided 95 % intervals, and the degrees of freedom of a sum."""

from collections.abc import Sequence

import numpy as np
from scipy.special import stdtridf, stdtrit

from hbench.records.numbers import NORMAL_95

_NEARLY_NORMAL = 1e9


def student_factor(dof: float) -> float:
    """Return t with P(|T| <= t) = 0.95 for ``dof`` degrees of freedom.

    4.303 for the two degrees of freedom of three trials (equation 6.3; the 3.182 printed there
    belongs to three).
    """
    return float(stdtrit(dof, 0.975)) if dof < _NEARLY_NORMAL else NORMAL_95


def degrees_of_freedom(factor: float) -> float:
    """Return the degrees of freedom whose ``student_factor`` is ``factor``."""
    return float(stdtridf(0.975, factor))


def satterthwaite(
    variances: Sequence[float] | np.ndarray, dof: Sequence[float] | np.ndarray
) -> tuple[float, float]:
    """Return standard error and degrees of freedom of a sum of independent estimates (n,).

    se^2 = sum_i u_i^2,  dof = se^4 / sum_i u_i^4 / dof_i  (Satterthwaite). Without any variance the
    degrees of freedom are the smallest of the estimates'.
    """
    u2, dof = np.asarray(variances, dtype=float), np.asarray(dof, dtype=float)
    total = float(u2.sum())
    if total == 0.0:
        return 0.0, float(dof.min())
    spread = float(np.sum(u2**2 / dof))
    return float(np.sqrt(total)), total**2 / spread if spread > 0 else float("inf")
