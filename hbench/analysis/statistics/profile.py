"""Profile-likelihood intervals: the values of a parameter that are compatible with the data.

    tau(theta)^2 = (S(theta) - S_min) / s^2 ,   S(theta) = min over the others of r'r

The interval is |tau| <= t, Student's factor (Bates and Watts, 1988, section 6.1). It need not be
symmetric, and bounds of the other parameters are active in S(theta) only where needed. The interval
ends at the parameter's own bound and is one-sided there.
"""

import numpy as np

from hbench.analysis.statistics.bounded import Problem, Solution, descend, sum_of_squares

_NEAR = 1e-3  # of t: tolerance of the search for a limit
_TOLERANCE = 1e-10  # of the cost: the others are then exact to 1e-5 of their standard errors
_EVALUATIONS = 40
_GROWTH = 4.0  # longest step outwards, as a multiple of the distance so far


def profile_interval(
    problem: Problem, solution: Solution, number: int, level: float, direction: np.ndarray
) -> tuple[float, float]:
    """Return the interval of parameter ``number`` where S - S_min <= ``level`` = t^2 s^2.

    ``direction`` (p,) is the linearised path to the upper limit: t se of this parameter, with the
    changes of the others. A limit is infinite if neither data nor bound determines it.
    """
    return (
        _limit(problem, solution, number, level, -1.0, -direction),
        _limit(problem, solution, number, level, 1.0, direction),
    )


def _limit(
    problem: Problem,
    solution: Solution,
    number: int,
    level: float,
    sign: float,
    direction: np.ndarray,
) -> float:
    """Search for tau = t on one side: secant steps in tau, kept inside the bracket."""
    best, least = solution.x, sum_of_squares(problem, solution.x)
    bound = problem.upper[number] if sign > 0 else problem.lower[number]
    to_bound = abs(bound - best[number])
    if to_bound == 0.0:
        return float(bound)
    step = abs(direction[number])
    if not np.isfinite(step) or step == 0.0 or not np.isfinite(direction).all():
        step, direction = 0.1 * problem.scale[number], np.zeros(len(best))
    direction = direction / step

    def tau(distance: float, start: np.ndarray) -> tuple[float, np.ndarray]:
        start = start.copy()
        start[number] = bound if distance == to_bound else best[number] + sign * distance
        others = descend(problem, start, (number,), _TOLERANCE)
        rise = max(sum_of_squares(problem, others.x) - least, 0.0)
        return float(np.sqrt(rise / level)), others.x

    inner, tau_inner, near = 0.0, 0.0, best
    outer = tau_outer = np.inf
    distance = min(step, to_bound)
    for _ in range(_EVALUATIONS):
        value, x = tau(distance, near + (distance - inner) * direction)
        if abs(value - 1.0) < _NEAR:
            break
        if value < 1.0:
            if distance == to_bound:
                return float(bound)
            inner, tau_inner, near = distance, value, x
        else:
            outer, tau_outer = distance, value
        if np.isfinite(outer):
            share = (1.0 - tau_inner) / (tau_outer - tau_inner)
            distance = inner + float(np.clip(share, 0.05, 0.95)) * (outer - inner)
        else:
            growth = _GROWTH if value * _GROWTH < 1.0 else 1.02 / value
            distance = min(max(growth, 1.05) * distance, to_bound)
        if distance > 1e9 * problem.scale[number]:
            return sign * np.inf
    return float(best[number] + sign * distance)
