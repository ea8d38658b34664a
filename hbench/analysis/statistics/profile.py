"""Profile likelihood: the values of one parameter that the data does not speak against.

    tau(theta)^2 = (S(theta) - S_min) / s^2 ,   S(theta) = min over the others of r'r

The interval is where |tau| <= t, Student's factor (Bates and Watts, 1988, section 6.1). It need not
be symmetric, and a bound that is active for the best fit is active in S(theta) only where it is.
At a bound of its own the interval ends: there it is one-sided.
"""

import numpy as np

from hbench.analysis.statistics.bounded import Problem, Solution, cost, descend

_NEAR = 1e-3  # of t: where the search for an end may stop
_ENOUGH = 1e-10  # of the cost: the others then are off by a hundred thousandth of their error
_EVALUATIONS = 40
_GROWTH = 4.0  # longest step outwards, as a multiple of the way so far


def profile_interval(
    problem: Problem, solution: Solution, number: int, level: float, direction: np.ndarray
) -> tuple[float, float]:
    """Return the interval of parameter ``number`` where S - S_min <= ``level`` = t^2 s^2.

    ``direction`` (p,) is the linearised way to the upper end: t se of this parameter, and how the
    others go along. An end is infinite where neither data nor bound sets one.
    """
    return (
        _end(problem, solution, number, level, -1.0, -direction),
        _end(problem, solution, number, level, 1.0, direction),
    )


def _end(
    problem: Problem,
    solution: Solution,
    number: int,
    level: float,
    sign: float,
    way: np.ndarray,
) -> float:
    """Search for tau = t along one side: secant steps in tau, kept inside the bracket."""
    best, least = solution.x, cost(problem, solution.x)
    own = problem.upper[number] if sign > 0 else problem.lower[number]
    limit = abs(own - best[number])  # how far the bound lets it go
    if limit == 0.0:
        return float(own)
    step = abs(way[number])
    if not np.isfinite(step) or step == 0.0 or not np.isfinite(way).all():
        step, way = 0.1 * problem.scale[number], np.zeros(len(best))
    way = way / step

    def tau(distance: float, start: np.ndarray) -> tuple[float, np.ndarray]:
        start = start.copy()
        start[number] = own if distance == limit else best[number] + sign * distance
        found = descend(problem, start, (number,), _ENOUGH)
        rise = max(cost(problem, found.x) - least, 0.0)
        return float(np.sqrt(rise / level)), found.x

    inner, tau_inner, near = 0.0, 0.0, best
    outer = tau_outer = np.inf
    distance = min(step, limit)
    for _ in range(_EVALUATIONS):
        value, x = tau(distance, near + (distance - inner) * way)
        if abs(value - 1.0) < _NEAR:
            break
        if value < 1.0:
            if distance == limit:
                return float(own)
            inner, tau_inner, near = distance, value, x
        else:
            outer, tau_outer = distance, value
        if np.isfinite(outer):
            share = (1.0 - tau_inner) / (tau_outer - tau_inner)
            distance = inner + float(np.clip(share, 0.05, 0.95)) * (outer - inner)
        else:
            growth = _GROWTH if value * _GROWTH < 1.0 else 1.02 / value
            distance = min(max(growth, 1.05) * distance, limit)
        if distance > 1e9 * problem.scale[number]:
            return sign * np.inf
    return float(best[number] + sign * distance)
