"""Least squares within bounds: several starts, and bounds that are either active or not.

The trust-region method stays strictly inside the bounds, so its answer is near an active bound,
never on it. Here the parameters near a bound are put on it and the others are solved again; those
for which the cost falls towards the inside are released.
"""

from collections.abc import Callable, Sequence
from typing import Literal, NamedTuple

import numpy as np
from scipy.optimize import least_squares

Function = Callable[[np.ndarray], np.ndarray]
_NEAR = 1e-3  # of a parameter's scale
_TOLERANCE = 1e-12


class Problem(NamedTuple):
    """Residuals (n,) and their derivatives (n, p), bounds and typical sizes of p parameters."""

    residual: Function
    jacobian: Function
    lower: np.ndarray
    upper: np.ndarray
    scale: np.ndarray


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


def solve(problem: Problem, starts: Sequence[np.ndarray]) -> Solution:
    """Minimise the sum of squares within the bounds, from the best of ``starts``."""
    every = np.ones(len(problem.scale), dtype=bool)
    x, converged = min(
        (_search(problem, x, every) for x in starts), key=lambda s: _cost(problem, s)
    )
    to_lower, to_upper = x - problem.lower, problem.upper - x
    bound = np.where(to_lower < to_upper, problem.lower, problem.upper)
    pinned = np.minimum(to_lower, to_upper) <= _NEAR * problem.scale
    while pinned.any():
        x, converged = _search(problem, np.where(pinned, bound, x), ~pinned)
        gradient = problem.jacobian(x).T @ problem.residual(x)
        inwards = np.where(bound == problem.lower, gradient <= 0, gradient >= 0)
        if not (pinned & inwards).any():
            break
        pinned = pinned & ~inwards
        if not pinned.any():
            x, converged = _search(problem, x, every)
    return Solution(x, ~pinned, converged)


def _cost(problem: Problem, searched: tuple[np.ndarray, bool]) -> float:
    residual = problem.residual(searched[0])
    return float(residual @ residual)


def _search(problem: Problem, x: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, bool]:
    """Search over the free parameters; the others stay as in ``x``. Return them and success."""
    if not free.any():
        return x, True

    def whole(part: np.ndarray) -> np.ndarray:
        y = x.copy()
        y[free] = part
        return y

    lower, upper = problem.lower[free], problem.upper[free]
    found = least_squares(
        lambda part: problem.residual(whole(part)),
        np.clip(x[free], lower, upper),
        jac=lambda part: problem.jacobian(whole(part))[:, free],
        bounds=(lower, upper),
        x_scale=problem.scale[free],
        xtol=_TOLERANCE,
        ftol=_TOLERANCE,
        gtol=_TOLERANCE,
    )
    return whole(found.x), found.status > 0
