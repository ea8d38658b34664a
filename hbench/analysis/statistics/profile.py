"""Profile-likelihood intervals: the values of a parameter that are compatible with the data.

    tau(theta)^2 = (S(theta) - S_min) / s^2 ,   S(theta) = min over the others of r'r

The interval is |tau| <= t, Student's factor (Bates and Watts, 1988, section 6.1). It need not be
symmetric, and bounds of the other parameters are active in S(theta) only where needed. The interval
ends at the parameter's own bound and is one-sided there.

A limit is the largest value of the parameter where S <= S_min + t^2 s^2. It is sought over all
parameters at once (Venzon and Moolgavkar, 1988), each step on the ellipsoid of the linearised
residuals; where S has several minima (``Problem.uneven``), over all places of these. Where that
fails, S(theta) is evaluated along the parameter.
"""

import numpy as np

from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.bounded import Problem, Solution, descend, sum_of_squares

_NEAR = 1e-3  # of t: tolerance of the search for a limit
_STEPS = 15  # on ellipsoids
_ROUNDS = 4  # along the uneven parameter, each four times finer
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
    """Search for tau = t on one side. Along the parameter: secant steps in tau in a bracket."""
    best, least = solution.x, sum_of_squares(problem, solution.x)
    limit = None
    if problem.uneven is None:
        limit = _by_ellipsoids(problem, best + direction, number, sign, least, level)
    elif number != problem.uneven[0]:
        limit = _by_parabolas(problem, best, number, sign, least + level)
    if limit is not None:
        return limit
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


def _by_parabolas(
    problem: Problem, best: np.ndarray, number: int, sign: float, height: float
) -> float | None:
    """Search for a limit along the uneven parameter; None where it is not found inside the bounds.

    At each value of the uneven parameter, S over parameter ``number`` is a parabola, the others
    being optimal. The limit is where the outermost of them rises to ``height``.
    """
    assert problem.uneven is not None
    uneven, values = problem.uneven
    others = [i for i in range(len(best)) if i not in (number, uneven)]
    at = np.tile(best, (len(values), 1))
    at[:, uneven] = values
    residuals = np.array([problem.residual(x) for x in at])  # (m, n)
    jacobians = np.array([problem.derivatives(x) for x in at]) * problem.scale  # (m, n, p)
    last = len(values) - 1
    places, width = np.linspace(0.0, last, 4 * last + 1), 0.25
    for _ in range(_ROUNDS):
        residual, jacobian = _between(residuals, places), _between(jacobians, places)
        own = np.stack([residual, jacobian[:, :, number]], axis=-1)
        change = -np.linalg.pinv(jacobian[:, :, others]) @ own  # of the others: at rest, per step
        left = own + jacobian[:, :, others] @ change
        squares = left.transpose(0, 2, 1) @ left  # S = (1, step) squares (1, step)
        if squares[:, 1, 1].min() <= ROUNDING**2 * np.sum(own[:, :, 1] ** 2):
            return None  # the others take its place
        middle = -squares[:, 0, 1] / squares[:, 1, 1]
        room = (height - squares[:, 0, 0]) / squares[:, 1, 1] + middle**2
        steps = np.where(room >= 0.0, sign * middle + np.sqrt(np.maximum(room, 0.0)), -np.inf)
        outermost = int(steps.argmax())
        step, place = sign * steps[outermost], places[outermost]
        places = np.linspace(max(place - width, 0.0), min(place + width, last), 9)
        width /= 4.0
    x = best.copy()
    x[others] += change[outermost] @ [1.0, step] * problem.scale[others]
    x[number] += step * problem.scale[number]
    inside = (problem.lower <= x) & (x <= problem.upper)
    return float(x[number]) if inside.all() else None


def _between(arrays: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Interpolate along the first axis, at places counted in its elements."""
    low = np.minimum(places.astype(int), len(arrays) - 2)
    share = (places - low).reshape(-1, *[1] * (arrays.ndim - 1))
    return (1.0 - share) * arrays[low] + share * arrays[low + 1]


def _by_ellipsoids(
    problem: Problem, x: np.ndarray, number: int, sign: float, least: float, level: float
) -> float | None:
    """Search for a limit from ``x`` near it; None where it is not found inside the bounds.

    Each step leads to the extreme of the ellipsoid |r + J d|^2 = S_min + level. Other parameters at
    a bound stay there while S falls outwards.
    """
    own = np.arange(len(x)) == number
    for _ in range(_STEPS):
        if not problem.lower[number] < x[number] < problem.upper[number]:
            return None  # NaN too
        x = np.clip(x, problem.lower, problem.upper)
        with np.errstate(all="ignore"):
            residual, jacobian = problem.residual(x), problem.derivatives(x) * problem.scale
        if not (np.isfinite(jacobian).all() and np.isfinite(residual).all()):
            return None
        gradient = residual @ jacobian
        held = np.where(gradient > 0, x <= problem.lower, x >= problem.upper) & ~own
        moved = np.append(np.flatnonzero(~held & ~own), number)  # its own column is the last
        q, r = np.linalg.qr(jacobian[:, moved])
        if np.abs(np.diag(r)).min() <= ROUNDING * np.abs(r).max():
            return None
        along = residual @ q
        room = least + level - residual @ residual + along @ along
        if room < 0.0:
            along[-1] = 0.0  # no such point: reduce S at this value of the parameter
        to_edge = -along
        if room >= 0.0:
            to_edge[-1] += sign * np.copysign(np.sqrt(room), r[-1, -1])
        elif to_edge @ to_edge <= _NEAR**2 * level:
            return None
        x[moved] += np.linalg.solve(r, to_edge) * problem.scale[moved]
        inside = problem.lower[number] < x[number] < problem.upper[number]
        if inside and room >= 0.0 and to_edge @ to_edge <= _NEAR**2 * level:
            return float(x[number])
    return None
