"""95 % intervals of a fit's parameters: linearised, of the profile likelihood, by bootstrap."""

from collections.abc import Sequence

import numpy as np

from hbench.analysis.fitting.fit_data import FitPoints
from hbench.analysis.fitting.fittable_law import FittableLaw
from hbench.analysis.fitting.parameter_spread import (
    parameter_spread,
    placed,
    standard_uncertainty,
)
from hbench.analysis.statistics.bootstrap import (
    drawn_means,
    drawn_residuals,
    leveraged,
    parameter_dof,
    percentile_intervals,
)
from hbench.analysis.statistics.bounded import (
    Problem,
    Solution,
    descend,
    rounding,
    sum_of_squares,
)
from hbench.analysis.statistics.intervals import covariance, has_effect
from hbench.analysis.statistics.profile import profile_interval
from hbench.analysis.statistics.student import student_factor
from hbench.analysis.statistics.trial_levels import TrialLevels

NEAR_TOLERANCE = 1e-10  # of the cost, from a near start: exact to 1e-5 of the standard error
_DISAGREE = 0.25  # of the half-width: intervals whose ends differ by more disagree
_BIAS_STEP = 0.1  # of a standard error: the law is defined on both sides, and not yet rounded
_SEED = 1  # of the bootstrap: the same campaign gives the same intervals

Ends = tuple[float, float] | None


class SolutionIntervals:
    """Linearised and profile intervals of a solution.

    ``parts`` are those of the covariance ``spread``; ``factors`` (p,) are Student's for the degrees
    of freedom of each parameter, ``factor`` is that for the points less the parameters.
    """

    def __init__(
        self,
        problem: Problem,
        solution: Solution,
        freedom: int,
        data: FitPoints,
        levels: TrialLevels | None,
    ):
        self.problem, self.solution = problem, solution
        free = solution.free
        self.jacobian = problem.derivatives(solution.x)
        self.factor = student_factor(freedom) if freedom > 0 else np.nan
        self.rounding = rounding(problem, solution.x)
        rest = sum_of_squares(problem, solution.x)
        self.exact = not rest > self.rounding**2  # only rounding remains
        self.variance = rest / freedom if freedom > 0 else np.nan
        # Where nothing is left, rounding is the noise beside which a parameter has an effect.
        self.noise = max(self.variance, self.rounding**2 / len(self.jacobian))
        residual = problem.residual(solution.x)
        effect = has_effect(self.jacobian, problem.scale)[free]
        own = covariance(self.jacobian[:, free], residual, effect)
        parts = parameter_spread(
            self.jacobian[:, free], own, self.variance, data.sigma, data.slope_errors, levels
        )
        self.parts = placed(parts, free)
        self.spread = self.parts.covariance
        self.se = np.sqrt(np.diag(self.spread))
        self.factors = np.full(len(free), self.factor)
        if freedom > 0:
            _, dof = standard_uncertainty(self.parts, freedom, np.eye(len(free)))
            self.factors = np.array([student_factor(each) for each in dof.tolist()])

    def linearised(self) -> list[Ends]:
        """Return the intervals of the law's line at the solution; none without a scatter."""
        half = self.factors * self.se
        return [
            (float(x - h), float(x + h)) if np.isfinite(h) else None
            for x, h in zip(self.solution.x, half, strict=True)
        ]

    def bias(self) -> np.ndarray:
        """Return the mean errors (p,) of the estimates, to second order (Box 1971); else NaN.

            b = -1/2 J^+ d,  d_t = sum_jk C_jk d^2 f_t / dp_j dp_k

        C is the covariance, so that d is a sum of second differences along its columns' root. The
        points' weights and Gaussian scatter are taken as right. NaN too where a tenth of a standard
        error reaches beyond a bound: the law need not be defined there.
        """
        free = self.solution.free
        bias = np.full(len(free), np.nan)
        spread = self.parts.residual[np.ix_(free, free)]
        if not np.isfinite(spread).all() or not free.any():
            return bias
        variances, vectors = np.linalg.eigh(spread)
        steps = _BIAS_STEP * (vectors * np.sqrt(np.maximum(variances, 0.0))).T
        at, residual = self.solution.x, self.problem.residual
        reach = np.abs(steps).sum(axis=0)
        lower, upper = self.problem.lower[free], self.problem.upper[free]
        if np.any(at[free] - reach < lower) or np.any(at[free] + reach > upper):
            return bias
        curvature = np.zeros(len(self.jacobian))
        for step in steps:
            along = np.zeros(len(free))
            along[free] = step
            curvature += residual(at + along) + residual(at - along) - 2 * residual(at)
        curvature /= _BIAS_STEP**2
        bias[free] = -0.5 * np.linalg.lstsq(self.jacobian[:, free], curvature, rcond=None)[0]
        return bias

    def profile(self) -> list[Ends]:
        """Return the profile's intervals; none where neither end is set by the data."""
        if self.exact:
            return self.linearised()
        return [self._profile(i) for i in range(len(self.se))]

    def ends_at_bound(self, intervals: Sequence[Ends]) -> np.ndarray:
        """Return which intervals (p,) a bound cuts off; not those of parameters at a bound."""
        lower, upper = self.problem.lower, self.problem.upper
        inside = [
            ends is None or lower[i] < ends[0] and ends[1] < upper[i]
            for i, ends in enumerate(intervals)
        ]
        return self.solution.free & ~np.array(inside)

    def _profile(self, i: int) -> Ends:
        """Return the interval of a profile, widened by the trials' levels up to the bounds."""
        if self.solution.free[i] and not np.isfinite(self.se[i]):
            return None
        own, factor, x = self.parts.residual, float(self.factors[i]), float(self.solution.x[i])
        along = np.where(self.solution.free, own[:, i], 0.0) / np.sqrt(own[i, i])
        level = factor**2 * self.variance
        low, high = profile_interval(self.problem, self.solution, i, level, factor * along)
        if shift := factor * float(self.parts.level[i]):
            low = max(x - float(np.hypot(x - low, shift)), float(self.problem.lower[i]))
            high = min(x + float(np.hypot(high - x, shift)), float(self.problem.upper[i]))
        by_data = (self.problem.lower[i] < low, high < self.problem.upper[i])
        return (low, high) if any(by_data) and np.isfinite([low, high]).all() else None


def bootstrap_intervals(
    law: FittableLaw,
    data: FitPoints,
    problem: Problem,
    solution: Solution,
    weights: np.ndarray,
    count: int,
) -> list[Ends]:
    """Return the intervals of fits to drawn campaigns, with the weights (n,) of the fit.

    Each search begins at the solution.
    """
    rng = np.random.default_rng(_SEED)
    sigma = data.sigma / np.sqrt(weights)
    fitted = law.model(data.inputs, solution.x)
    jacobian = law.jacobian(data.inputs, solution.x) / sigma[:, None]
    freedom = np.full(len(solution.x), len(fitted) - float(solution.free.sum()))
    drawn = drawn_means(data.trials_n, count, rng)
    if drawn is None:
        scaled = leveraged((data.friction_n - fitted) / sigma, jacobian[:, solution.free])
        drawn = drawn_residuals(fitted, scaled, sigma, count, rng)
    else:
        counts = np.array([len(trials) for trials in data.trials_n])
        freedom[solution.free] = parameter_dof(jacobian[:, solution.free], counts)

    def refit(friction: np.ndarray) -> np.ndarray:
        again = problem._replace(
            residual=lambda p: (law.model(data.inputs, p) - friction) / sigma,
            jacobian=lambda p: law.jacobian(data.inputs, p) / sigma[:, None],
        )
        return descend(again, solution.x, (), NEAR_TOLERANCE).x

    ends = percentile_intervals(refit, drawn, freedom)
    return [(float(low), float(high)) for low, high in ends.T]


def disagree(intervals: Sequence[tuple[float, float]], nothing: float) -> bool:
    """Return whether ends differ by more than an eighth of the width, and by ``nothing``."""
    if len(intervals) < 2:
        return False
    low, high = np.array(intervals).T
    width = float(np.median(high - low))
    return bool(max(np.ptp(low), np.ptp(high)) > _DISAGREE * width / 2 + nothing)
