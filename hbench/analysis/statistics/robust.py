"""Robust loss functions, which give large residuals less weight than least squares.

    minimise  sum rho(r_i / s),  psi = rho' :  huber     psi(z) = clip(z, -c, c)
                                               soft_l1   psi(z) = z / sqrt(1 + (z / c)^2)

with c = 1.345 and s from the median of |r|, by iteratively reweighted least squares with weights
psi(z) / z. The covariance is that of least squares with pseudo-values (Huber, Robust Statistics,
1981, equation 7.6.9):

    r_i -> K s psi(r_i / s) / m,   m = mean psi',   K = 1 + p/n var(psi') / m^2

Their solution is the same, and their covariance is that of the robust estimate.
"""

from typing import NamedTuple

import numpy as np

from hbench.analysis.statistics.bounded import Problem, Solution, descend, rounding
from hbench.motion.noise import robust_sigma

_TUNING = 1.345  # 95 % as efficient as least squares for normal errors
_ITERATIONS = 200
_WEIGHT_CHANGE = 1e-6  # tolerance; a descent is exact to some 1e-7 of the standard errors


class RobustSolution(NamedTuple):
    """Solution of a robust loss, its pseudo-values and the weights (n,) of the points."""

    solution: Solution
    problem: Problem  # of the pseudo-values
    weights: np.ndarray


def minimise_robust(problem: Problem, solution: Solution, loss: str) -> RobustSolution:
    """Minimise ``loss``, "huber" or "soft_l1", from the least-squares ``solution``."""
    weights = np.ones(len(problem.residual(solution.x)))
    size, stable = 0.0, False
    least = rounding(problem, solution.x) / np.sqrt(len(weights))
    for _ in range(_ITERATIONS):
        residual = problem.residual(solution.x)
        size = _size(residual, int(solution.free.sum()))
        if size <= least:
            stable = True
            break
        updated = _weights(residual / size, loss)
        stable = bool(np.abs(updated - weights).max() < _WEIGHT_CHANGE)
        weights = updated
        if stable:
            break
        solution = descend(_times(problem, np.sqrt(weights)), solution.x)
    residual = problem.residual(solution.x)
    pseudo = residual
    if size > least:
        slopes = _slopes(residual / size, loss)
        mean = max(float(slopes.mean()), 1e-3)
        correction = 1 + len(solution.x) / len(residual) * float(slopes.var()) / mean**2
        pseudo = correction * weights * residual / mean
    change = pseudo - residual
    return RobustSolution(
        solution._replace(converged=solution.converged and stable),
        problem._replace(residual=lambda x: problem.residual(x) + change),
        weights,
    )


def _size(residual: np.ndarray, p: int) -> float:
    n = len(residual)
    return robust_sigma(residual) * float(np.sqrt(n / max(n - p, 1)))


def _weights(z: np.ndarray, loss: str) -> np.ndarray:
    if loss == "huber":
        return _TUNING / np.maximum(np.abs(z), _TUNING)
    return 1 / np.sqrt(1 + (z / _TUNING) ** 2)


def _slopes(z: np.ndarray, loss: str) -> np.ndarray:
    if loss == "huber":
        return (np.abs(z) <= _TUNING).astype(float)
    return (1 + (z / _TUNING) ** 2) ** -1.5


def _times(problem: Problem, factor: np.ndarray) -> Problem:
    return problem._replace(
        residual=lambda x: factor * problem.residual(x),
        jacobian=lambda x: factor[:, None] * problem.derivatives(x),
    )
