"""Least squares within bounds: damped Gauss-Newton or trust-region steps, then an active set.

Levenberg-Marquardt steps are fast. From a start where they do not converge, scipy's trust region
searches instead. It stays strictly inside the bounds, so its solution is near an active bound,
never on it. So the parameters near a bound are fixed to it, the others are solved again, and
parameters that the data does not hold there are released: moved beyond the bound, a held parameter
must change the curve by more than rounding.
"""

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np

from hbench.analysis.rounding import ROUNDING

Function = Callable[[np.ndarray], np.ndarray]

_COMPLEX_STEP = 1e-30  # any small step is exact
_TOLERANCE = 1e-15  # relative, of cost and step: full precision
_STATIONARY, _CONVERGED = 1e-14, 1e-6  # cosine of residual and effects at a minimum
_NEAR = 1e-3  # of a parameter's scale: a nearer bound may be active
_EVALUATIONS = 2000
_EXACT = 1e-3  # of rounding: nothing is left to search for
_STEPS = 50  # tried before the trust region
_LEAST_DAMPING = 1e-3  # of the Jacobian's norm


class Problem(NamedTuple):
    """Residuals (n,), bounds and typical sizes of p parameters, derivatives (n, p) if known.

    Without ``jacobian`` the residual is derived by complex steps: it must be analytic.
    """

    residual: Function
    lower: np.ndarray
    upper: np.ndarray
    scale: np.ndarray
    jacobian: Function | None = None
    # A parameter along which S may have several minima, and values (m,) of it, between which the
    # derivatives by the others change linearly; they do not depend on these. None: one minimum.
    uneven: tuple[int, np.ndarray] | None = None

    def derivatives(self, x: np.ndarray) -> np.ndarray:
        """Return the derivatives (n, p) of the residuals."""
        return complex_step(self.residual, x) if self.jacobian is None else self.jacobian(x)


class Solution(NamedTuple):
    """Optimal parameters, and which of them are free."""

    x: np.ndarray
    free: np.ndarray  # bool; the others are at an active bound
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


def sum_of_squares(problem: Problem, x: np.ndarray) -> float:
    """Return the sum of squared residuals; infinite if they are not finite."""
    with np.errstate(all="ignore"):
        residual = problem.residual(x)
        total = float(residual @ residual)
    return total if np.isfinite(total) else np.inf


def rounding(problem: Problem, x: np.ndarray) -> float:
    """Return the norm of residuals that is rounding: 1e-9 of what typical parameters make."""
    return _rounding(problem.derivatives(x), problem.scale)


def _rounding(jacobian: np.ndarray, scale: np.ndarray) -> float:
    return ROUNDING * float(np.linalg.norm(jacobian * scale))


def solve(
    problem: Problem, starts: Sequence[np.ndarray], tolerance: float = _TOLERANCE
) -> Solution:
    """Minimise the sum of squares within the bounds from all ``starts``.

    Of solutions that differ by rounding, the first is returned. ``tolerance`` is as of ``descend``.
    """
    solutions = [descend(problem, start, (), tolerance) for start in starts]
    costs = np.array([sum_of_squares(problem, solution.x) for solution in solutions])
    best = costs.argmin()
    tie = rounding(problem, solutions[best].x) ** 2 + ROUNDING * costs[best]
    return solutions[np.flatnonzero(costs <= costs[best] + tie)[0]]


def descend(
    problem: Problem,
    start: np.ndarray,
    fixed: Sequence[int] = (),
    tolerance: float = _TOLERANCE,
) -> Solution:
    """Search from ``start``; parameters with numbers in ``fixed`` keep their values.

    The search ends when the relative change of cost or step is below ``tolerance``. Without free
    parameters it has converged. A parameter whose effect is rounding keeps its value at the start.
    """
    movable = np.ones(len(start), dtype=bool)
    movable[list(fixed)] = False
    x = np.where(movable, np.clip(start, problem.lower, problem.upper), start)
    with np.errstate(all="ignore"):
        x, converged = _search(problem, x, movable, tolerance)
        to_lower, to_upper = x - problem.lower, problem.upper - x
        bound = np.where(to_lower < to_upper, problem.lower, problem.upper)
        pinned = movable & (np.minimum(to_lower, to_upper) <= _NEAR * problem.scale)
        while pinned.any():
            x = np.where(pinned, bound, x)
            x, converged = _search(problem, x, movable & ~pinned, tolerance)
            jacobian = problem.derivatives(x)
            gradient = problem.residual(x) @ jacobian
            outwards = np.where(bound == problem.lower, gradient, -gradient)
            length = np.linalg.norm(jacobian, axis=0)
            inwards = outwards <= _rounding(jacobian, problem.scale) * length
            if not (pinned & inwards).any():
                break
            pinned &= ~inwards
            if not pinned.any():
                x, converged = _search(problem, x, movable, tolerance)
        jacobian = problem.derivatives(x)
    moved = np.linalg.norm(jacobian, axis=0) * problem.scale > _rounding(jacobian, problem.scale)
    x = np.where(movable & ~pinned & ~moved, np.clip(start, problem.lower, problem.upper), x)
    return Solution(x, movable & ~pinned, converged)


def _search(
    problem: Problem, x: np.ndarray, free: np.ndarray, tolerance: float
) -> tuple[np.ndarray, bool]:
    """Search over the free parameters; the others stay as in ``x``. Return ``x`` and success."""
    residual = problem.residual(x)
    if not free.any() or not np.isfinite(residual @ residual):
        return x, not free.any()
    jacobian = problem.derivatives(x)
    if np.linalg.norm(residual) <= _EXACT * _rounding(jacobian, problem.scale):
        return x, True
    if _offset(problem, residual, jacobian, free) <= _STATIONARY:  # where the search would not end
        return x, True
    near, converged = _levenberg_marquardt(problem, x, free, tolerance)
    if converged:
        return near, True
    from scipy.optimize import least_squares  # slow import

    def with_free(values: np.ndarray) -> np.ndarray:
        y = x.astype(values.dtype)
        y[free] = values
        return y

    result = least_squares(
        lambda values: problem.residual(with_free(values)),
        x[free],
        jac=lambda values: problem.derivatives(with_free(values))[:, free],
        bounds=(problem.lower[free], problem.upper[free]),
        x_scale=problem.scale[free],
        xtol=tolerance,
        ftol=tolerance,
        gtol=None,
        max_nfev=_EVALUATIONS,
    )
    x = with_free(result.x)
    offset = _offset(problem, result.fun, problem.derivatives(x), free)
    exact = np.linalg.norm(result.fun) <= _rounding(result.jac, problem.scale[free])
    return x, bool(result.status > 0 or exact or offset <= _CONVERGED)


def _offset(
    problem: Problem, residual: np.ndarray, jacobian: np.ndarray, free: np.ndarray
) -> float:
    """Return the largest cosine between the residual and a free parameter's effect on it.

    It is zero at a minimum. Parameters whose effect is rounding are left out.
    """
    length = np.linalg.norm(jacobian, axis=0)
    has_effect = free & (length * problem.scale > _rounding(jacobian, problem.scale))
    along = np.abs(residual @ jacobian)[has_effect] / length[has_effect]
    return float(along.max(initial=0.0) / np.linalg.norm(residual))


def _levenberg_marquardt(
    problem: Problem, x: np.ndarray, free: np.ndarray, tolerance: float
) -> tuple[np.ndarray, bool]:
    """Take damped Gauss-Newton steps within the bounds; return ``x`` and convergence.

    A parameter at a bound is held there while the cost falls outwards. It has converged where an
    undamped step of the others is expected to change the cost by no more than the tolerance.
    """
    residual, damping = problem.residual(x), 0.0
    least = residual @ residual
    for _ in range(_STEPS):
        jacobian = problem.derivatives(x) * problem.scale
        if not np.isfinite(jacobian).all():
            break
        gradient = residual @ jacobian
        outwards = np.where(gradient > 0, x <= problem.lower, x >= problem.upper)
        moved = np.flatnonzero(free & ~outwards)
        jacobian = jacobian[:, moved]
        size = np.linalg.norm(jacobian)
        while True:
            rows, right = jacobian, residual
            if damping:
                rows = np.vstack([jacobian, damping * size * np.eye(len(moved))])
                right = np.append(residual, np.zeros(len(moved)))
            ends = (bound[moved] - x[moved] for bound in (problem.lower, problem.upper))
            change = _step(rows, right, *(end / problem.scale[moved] for end in ends))
            y = x.copy()
            y[moved] += change * problem.scale[moved]
            y = np.where(free, np.clip(y, problem.lower, problem.upper), y)
            after = problem.residual(y)
            squares = after @ after
            if not damping and np.sum((jacobian @ change) ** 2) <= tolerance * least:
                return (y if squares < least else x), True
            if squares < least:
                break
            damping = max(10.0 * damping, _LEAST_DAMPING)
            if damping > 1.0:
                return x, False
        x, residual, least = y, after, squares
        damping = damping / 10.0 if damping > _LEAST_DAMPING else 0.0
    return x, False


def _step(
    jacobian: np.ndarray, residual: np.ndarray, low: np.ndarray, high: np.ndarray
) -> np.ndarray:
    """Return the step (p,) that minimises |r + J step|, within ``low`` to ``high``.

    Parameters that would leave their bounds are put on them, and the others are solved again.
    """
    step, free = np.zeros(len(low)), np.ones(len(low), dtype=bool)
    while free.any():
        left = residual + jacobian[:, ~free] @ step[~free]
        step[free] = np.linalg.lstsq(jacobian[:, free], -left, rcond=None)[0]
        beyond = free & ((step < low) | (step > high))
        if not beyond.any():
            break
        step = np.clip(step, low, high)
        free &= ~beyond
    return step
