"""Fits of friction laws to single curves or to all curves jointly, with undetermined parameters.

Least squares of the trials' means within bounds, each weighted by the scatter of the trials, with
an optional robust loss. The 95 % interval is that of the profile likelihood: in simulations it
contains the truth when bounds are active, unlike the linearised one.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from hbench.analysis.fitting.fit_data import FitPoints, fit_points
from hbench.analysis.fitting.fittable_law import FittableLaw
from hbench.analysis.fitting.information import (
    Information,
    identification_messages,
    undetermined,
)
from hbench.analysis.fitting.marton_lantos import TWO_LINES
from hbench.analysis.fitting.messages import (
    BEYOND,
    beyond_messages,
    bound_messages,
    disagreements,
    level_messages,
)
from hbench.analysis.fitting.parameter_intervals import (
    NEAR_TOLERANCE,
    Ends,
    SolutionIntervals,
    bootstrap_intervals,
    disagree,
)
from hbench.analysis.fitting.pressure_based import PRESSURE_BASED
from hbench.analysis.fitting.tustin import TUSTIN_LAW
from hbench.analysis.rounding import ROUNDING, distinct, merged
from hbench.analysis.statistics.bounded import Problem, Solution, descend, solve
from hbench.analysis.statistics.robust import minimise_robust
from hbench.config.fitting import Fitting
from hbench.config.setup import ANYWHERE, Reach
from hbench.records import Curve, Fit, FitParameter
from hbench.records.friction_laws import FRICTION_LAWS

# Laws of one curve, and of the points of all loads and directions jointly.
_FITTABLE = (TUSTIN_LAW, TWO_LINES, PRESSURE_BASED)
CURVE_LAWS: Mapping[str, FittableLaw] = {
    law.name: law for law in _FITTABLE if FRICTION_LAWS[law.name].data == "curve"
}
JOINT_LAWS: Mapping[str, FittableLaw] = {
    law.name: law for law in _FITTABLE if law.name not in CURVE_LAWS
}

_LINE_POINTS = 121
_LEAST_FORCE_N = 1.0  # scale of a curve of zeros; the search keeps 1e-10 off its bounds
_LEAST_SPEEDS = 4


def fits(curve: Curve, how: Fitting | None = None, reach: Reach = ANYWHERE) -> tuple[Fit, ...]:
    """Fit the laws in ``how`` to a curve; none to a curve with fewer than four speeds."""
    how = how or Fitting()
    if _speeds(curve) < _LEAST_SPEEDS:
        return ()
    return tuple(
        fit_law(CURVE_LAWS[name], [curve], how, reach=reach)
        for name in how.laws
        if name in CURVE_LAWS
    )


def unfitted_curves(curves: Sequence[Curve]) -> tuple[str, ...]:
    """Return a note on the curves with too few speeds for ``fits``, if there are any."""
    few = [_speeds(curve) for curve in curves if _speeds(curve) < _LEAST_SPEEDS]
    if not few:
        return ()
    return (
        f"no fit for {len(few)} of {len(curves)} curves: at most {max(few)} of the {_LEAST_SPEEDS} "
        "speeds that a fit needs",
    )


def _speeds(curve: Curve) -> int:
    return len(distinct(np.array([point.v_m_s for point in curve.points])))


def fit_pressure_based(curves: Sequence[Curve]) -> Fit:
    """Fit equation 3.7 to the points of all ``curves`` jointly."""
    return fit_law(PRESSURE_BASED, curves, Fitting())


def fit_law(
    law: FittableLaw,
    curves: Sequence[Curve],
    how: Fitting,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    reach: Reach = ANYWHERE,
) -> Fit:
    """Fit a law to the points of one curve or more; ``bounds`` replace those of ``how``.

    The message recommends further points within the ``reach`` of the bench.

    Points without a pressure that the law needs are left out. Standard errors come from the
    Jacobian of the parameters off their bounds, with s^2 = RSS / (n - p), p being the number of
    these; for one curve they contain the common level of each trial. Intervals are from Student's t
    with the degrees of freedom of ``parameter_spread.py``. There is no standard error where the
    interval lies inside one to either side. ``rmse_n`` is sqrt(RSS / n), not weighted.
    What the data does not determine has neither, and the message says so: a parameter of which the
    others can take the place, and one whose typical size changes friction by rounding alone.
    """
    data = fit_points(curves, how.weights)
    if law.pressures:
        data = data.subset(np.isfinite(data.inputs).all(axis=0))
    n, p = len(data.friction_n), len(law.names)
    if _different(data.inputs) < p:
        with_what = "points with both pressures" if law.pressures else "points"
        message = f"{n} {with_what} do not determine {p} parameters"
        return Fit(law.name, {}, float("nan"), False, message)
    problem, solution, weights = estimate_parameters(law, data, how, bounds or {})
    freedom = n - int(solution.free.sum())
    levels = data.trial_levels() if len(curves) == 1 else None
    linearisation = SolutionIntervals(problem, solution, freedom, data, levels)
    intervals = {"linearised": linearisation.linearised(), "profile": linearisation.profile()}
    if how.bootstrap and freedom > 0:
        intervals["bootstrap"] = bootstrap_intervals(
            law, data, problem, solution, weights, how.bootstrap
        )
    parameters = _parameters(law, problem, solution, linearisation, intervals)
    residual = law.model(data.inputs, solution.x) - data.friction_n
    messages = [] if solution.converged else ["the search for the best fit did not converge"]
    messages += bound_messages(parameters) + disagreements(parameters) + level_messages(levels)
    if freedom <= 0:
        messages.append("as many parameters as points: no standard errors")
    else:
        info = Information(
            law,
            solution.x,
            linearisation.jacobian,
            linearisation.noise,
            problem.scale,
            data.inputs,
            reach,
        )
        widths = [np.nan if ends is None else ends[1] - ends[0] for ends in intervals["profile"]]
        cut_off = linearisation.ends_at_bound(intervals["profile"])
        unknown = undetermined(info, linearisation.factor, np.array(widths) / 2, cut_off)
        for name, is_unknown in zip(law.names, unknown.tolist(), strict=True):
            parameters[name] = replace(parameters[name], wide=is_unknown)
        messages += identification_messages(info, unknown)
        messages += beyond_messages(info, linearisation.factor) if len(curves) == 1 else []
    line, beyond = _lines(law, curves, data, solution.x)
    return Fit(
        law=law.name,
        parameters=parameters,
        rmse_n=float(np.sqrt(np.mean(residual**2))),
        converged=solution.converged,
        message="; ".join(messages),
        line=line,
        beyond=beyond,
        covariance=_by_names(law, linearisation.spread),
        dof=freedom if freedom > 0 else None,
        spread=linearisation.parts,
    )


def _by_names(law: FittableLaw, matrix: np.ndarray) -> dict[str, dict[str, float | None]]:
    """Return a covariance (p, p) by the parameters' names; what is not determined is None."""
    return {
        name: {
            other: value if np.isfinite(value) else None
            for other, value in zip(law.names, row, strict=True)
        }
        for name, row in zip(law.names, matrix.tolist(), strict=True)
    }


def _different(inputs: np.ndarray) -> int:
    """Return the number of points (3, n) whose speed or pressures differ by more than rounding."""
    rows = [merged(np.nan_to_num(row)) for row in inputs]
    return np.unique(rows, axis=1).shape[1]


class ParameterEstimate(NamedTuple):
    """Problem of a fit, its solution, and the weights (n,) that a robust loss gives the points."""

    problem: Problem
    solution: Solution
    weights: np.ndarray


def typical_sizes(law: FittableLaw, data: FitPoints) -> tuple[float, np.ndarray]:
    """Return the largest friction [N] and the typical sizes (p,) of a law's parameters."""
    force = max(float(np.abs(data.friction_n).max()), _LEAST_FORCE_N)
    return force, law.scale(data.inputs, force)


def estimate_parameters(
    law: FittableLaw,
    data: FitPoints,
    how: Fitting,
    bounds: Mapping[str, tuple[float, float]],
    start: np.ndarray | None = None,
) -> ParameterEstimate:
    """Estimate a law's parameters from points; ``bounds`` replace those of ``how``.

    The search begins at the law's starts, or, for lower accuracy and without intervals, at
    ``start``. With a robust loss the problem is that of the pseudo-values, which has the same
    solution.
    """
    inputs, friction, sigma = data.inputs, data.friction_n, data.sigma
    chosen = {name: value for name, value in how.bounds if name in law.names and value is not None}
    force, scale = typical_sizes(law, data)
    lower, upper = law.limits(inputs, force, {**chosen, **bounds})
    problem = Problem(
        residual=lambda p: (law.model(inputs, p) - friction) / sigma,
        lower=lower,
        upper=upper,
        scale=scale,
        jacobian=lambda p: law.jacobian(inputs, p) / sigma[:, None],
    )
    if start is None:
        problem = problem._replace(uneven=law.uneven(inputs, friction, sigma, lower, upper))
        solution = solve(problem, law.starts(inputs, friction, sigma, lower, upper))
    else:
        solution = descend(problem, start, (), NEAR_TOLERANCE)
    if how.loss == "linear":
        return ParameterEstimate(problem, solution, np.ones(len(friction)))
    robust = minimise_robust(problem, solution, how.loss)
    return ParameterEstimate(robust.problem, robust.solution, robust.weights)


def _parameters(
    law: FittableLaw,
    problem: Problem,
    solution: Solution,
    linearisation: SolutionIntervals,
    by_method: Mapping[str, Sequence[Ends]],
) -> dict[str, FitParameter]:
    parameters, bias = {}, linearisation.bias()
    for i, (name, unit) in enumerate(law.units.items()):
        intervals = {method: ends[i] for method, ends in by_method.items()}
        ends, x, se = intervals["profile"], float(solution.x[i]), float(linearisation.se[i])
        nothing = ROUNDING * float(problem.scale[i])
        known = False
        if ends is not None and np.isfinite(linearisation.factors[i] * se):
            known = se <= max(x - ends[0], ends[1] - x) + nothing
        parameters[name] = FitParameter(
            value=x,
            se=se if known else None,
            ci95=ends,
            at_bound=solution.at_bound(problem, i),
            unit=unit,
            intervals=intervals,
            disagree=disagree([ends for ends in intervals.values() if ends is not None], nothing),
            bias=float(bias[i]) if known and np.isfinite(bias[i]) else None,
        )
    return parameters


def _lines(
    law: FittableLaw, curves: Sequence[Curve], data: FitPoints, x: np.ndarray
) -> tuple[tuple, tuple]:
    """Return the law's line within the measured speeds, and the lines below and above them."""
    if len(curves) > 1 or law.name in JOINT_LAWS:
        return (), ()
    v = data.inputs[0]
    low, high = v.min(), v.max()

    def line(speeds: np.ndarray) -> tuple[tuple[float, float], ...]:
        inputs = np.repeat(data.inputs[:, :1], len(speeds), axis=1)
        inputs[0] = speeds
        signed, friction = curves[0].against_motion, law.model(inputs, x)
        return tuple(zip((signed * speeds).tolist(), (signed * friction).tolist(), strict=True))

    inside = line(np.union1d(v, np.linspace(low, high, _LINE_POINTS)))
    below, above = np.linspace(0.0, low, 9), np.linspace(high, BEYOND * high, 9)
    return inside, tuple(line(speeds) for speeds in (below, above))
