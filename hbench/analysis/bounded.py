"""Least squares within bounds: Levenberg-Marquardt on the parameters that no bound holds.

    minimise  r(x)'r(x)   for  lower <= x <= upper
    step      (J'J + lambda D^2) d = -J'r,   D the largest lengths that J's columns had

A parameter at a bound is held there while the cost falls beyond it, and left free otherwise; steps
end at the bounds. So an answer lies on an active bound exactly, and says so. The search ends where
the residuals have no part left along any free column of J, or where no step lowers the cost.
"""

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np

Function = Callable[[np.ndarray], np.ndarray]

_COMPLEX_STEP = 1e-30  # exact for any small one
_COSINE = 1e-10  # between the residuals and the columns of J: nothing left
# Where no step lowers the cost, by rounding or at a kink of the law, the search has converged if
_STALLED = 0.03  # the slope promises less than a thousandth of the cost (this cosine's square),
_NEGLIGIBLE = 1e-7  # or the full step is this part of the parameters' sizes.
_FIRST_DAMPING = 1e-2
_SHORTEST = 1e-14  # step, of a parameter's size
_STEPS = 1000
_LARGEST_DAMPING = 1e14


class Problem(NamedTuple):
    """Residuals (n,), bounds and typical sizes of p parameters, derivatives (n, p) if known.

    Without ``jacobian`` the residual is derived by complex steps: it must be analytic.
    """

    residual: Function
    lower: np.ndarray
    upper: np.ndarray
    scale: np.ndarray
    jacobian: Function | None = None

    def derivatives(self, x: np.ndarray) -> np.ndarray:
        """Return the derivatives (n, p) of the residuals."""
        return complex_step(self.residual, x) if self.jacobian is None else self.jacobian(x)


class Solution(NamedTuple):
    """The best parameters and which of them are free."""

    x: np.ndarray
    free: np.ndarray  # bool; the others are at a bound, beyond which the cost would fall
    converged: bool

    def at_bound(self, problem: Problem, i: int) -> Literal["lower", "upper"] | None:
        """Return the bound that parameter ``i`` is at."""
        if self.free[i]:
            return None
        return "lower" if self.x[i] == problem.lower[i] else "upper"


def complex_step(function: Function, x: np.ndarray) -> np.ndarray:
    """Return the derivatives (n, p) of an analytic function of p parameters: Im f(x + ih e) / h."""
    steps = _COMPLEX_STEP * np.maximum(np.abs(x), 1e-10)
    shifted = x + 1j * np.diag(steps)
    return np.column_stack([np.imag(function(row)) for row in shifted]) / steps


def cost(problem: Problem, x: np.ndarray) -> float:
    """Return the sum of squares; infinite where the residuals are not finite."""
    with np.errstate(all="ignore"):
        residual = problem.residual(x)
        total = float(residual @ residual)
    return total if np.isfinite(total) else np.inf


def solve(problem: Problem, starts: Sequence[np.ndarray]) -> Solution:
    """Minimise the sum of squares within the bounds; the best that the ``starts`` lead to."""
    found = [descend(problem, start) for start in starts]
    return min(found, key=lambda solution: cost(problem, solution.x))


def descend(
    problem: Problem, start: np.ndarray, fixed: Sequence[int] = (), cosine: float = _COSINE
) -> Solution:
    """Search from ``start``; parameters whose numbers are ``fixed`` stay as they are.

    ``cosine`` between the residuals and the columns of J is as good as none. Where no parameter
    can move there is nothing to find, and the search has converged.
    """
    movable = np.ones(len(start), dtype=bool)
    movable[list(fixed)] = False
    x = np.where(movable, np.clip(start, problem.lower, problem.upper), start)
    with np.errstate(all="ignore"):
        return _descend(problem, x, movable, cosine)


def _descend(problem: Problem, x: np.ndarray, movable: np.ndarray, enough: float) -> Solution:
    residual = problem.residual(x)
    least, damping = float(residual @ residual), _FIRST_DAMPING
    free, longest, cosine = movable, np.zeros(len(x)), np.inf
    for _ in range(_STEPS):
        jacobian = problem.derivatives(x)
        lengths = np.linalg.norm(jacobian, axis=0)
        longest = np.maximum(longest, lengths)
        gradient = residual @ jacobian
        free = movable & ~_held(problem, x, gradient)
        cosine = _cosine(gradient[free], lengths[free], least)
        if cosine <= enough:
            return Solution(x, free, True)
        weight = np.where(longest > 0, longest, 1.0)[free]
        moved = False
        while not moved and damping < _LARGEST_DAMPING:
            step = _step(jacobian[:, free], residual, weight, damping)
            tried = x.copy()
            tried[free] = np.clip(x[free] + step, problem.lower[free], problem.upper[free])
            size = np.abs(x) + 1e-10 * problem.scale
            if np.all(np.abs(tried - x) <= _SHORTEST * size):
                break
            residual_there = problem.residual(tried)
            total = float(residual_there @ residual_there)
            moved = total < least
            damping = max(damping / 5, 1e-20) if moved else damping * 4
        if not moved:
            full = _step(jacobian[:, free], residual, weight, 0.0)
            negligible = np.abs(full) <= _NEGLIGIBLE * np.maximum(size, problem.scale)[free]
            return Solution(x, free, bool(cosine <= _STALLED or negligible.all()))
        x, residual, least = tried, residual_there, total
    return Solution(x, free, False)


def _held(problem: Problem, x: np.ndarray, gradient: np.ndarray) -> np.ndarray:
    return ((x <= problem.lower) & (gradient > 0)) | ((x >= problem.upper) & (gradient < 0))


def _cosine(gradient: np.ndarray, lengths: np.ndarray, least: float) -> float:
    """Return the largest cosine between the residuals and a column of J."""
    seen = lengths > 0
    if least == 0.0 or not seen.any():
        return 0.0
    return float(np.max(np.abs(gradient[seen]) / lengths[seen]) / np.sqrt(least))


def _step(
    jacobian: np.ndarray, residual: np.ndarray, weight: np.ndarray, damping: float
) -> np.ndarray:
    """Return the damped step: least squares of the stacked system, in the columns' own sizes."""
    p = len(weight)
    matrix = np.vstack([jacobian / weight, np.sqrt(damping) * np.eye(p)])
    right = np.concatenate([-residual, np.zeros(p)])
    return np.linalg.lstsq(matrix, right, rcond=None)[0] / weight
