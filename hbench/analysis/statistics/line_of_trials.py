"""Straight line through means of trials, with the scatter of points and of trials.

    y_i = a + b x_i + d_i       y_i the mean of the trials at x_i, i = 1 ... m

by least squares with equal weights. The half-width of the 95 % interval of a and of b is the root
sum of squares of two:

    points      from the residuals, s^2 = sum d_i^2 / (m - 2)             m - 2 degrees of freedom
    trials      from the n lines through each trial's own values          n - 1

The residuals contain what differs from one point to the next: curvature, and a set-up that is made
once at each point, which the strokes of a file repeat without change. The lines of the trials
contain what a trial has at all points alike, such as a seal mounted anew: it shifts or turns the
line and leaves no residual. Scatter of single values is in both. In simulated friction bands over
pressure both together contained the slope in 95 to 99.7 %, either alone in as few as 4 % where the
other source dominates.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hbench.analysis.statistics.student import degrees_of_freedom, student_factor


class TrialLine(NamedTuple):
    """Line y = intercept + slope x, in the units of y and x."""

    slope: float
    slope_ci95: float  # half-width of the 95 % interval
    slope_se: float
    slope_dof: float
    intercept: float
    intercept_ci95: float


def slope_weights(x: np.ndarray) -> np.ndarray:
    """Return the weights (m,) of values at x (m,) in the slope of their line."""
    dx = x - x.mean()
    return dx / (dx @ dx)


def line_of_trials(
    x: np.ndarray, means: Sequence[float], trials: Sequence[dict[int, float]]
) -> TrialLine:
    """Return the line through the means (m,) over x (m,), m >= 3.

    ``trials`` (m,) are the values of each point by their trials' numbers. Only trials that all
    points have form lines.
    """
    m, weights = len(x), slope_weights(x)
    rows = np.array([weights, 1 / m - x.mean() * weights])
    slope, intercept = rows @ means
    residuals = np.asarray(means) - intercept - slope * x
    s2 = float(residuals @ residuals) / (m - 2)
    common = set.intersection(*map(set, trials))
    lines = rows @ np.array([[values[trial] for trial in common] for values in trials])
    slope_error, intercept_error = (
        _error(math.sqrt(s2 * (row @ row)), m - 2, of_trials)
        for row, of_trials in zip(rows, lines, strict=True)
    )
    return TrialLine(float(slope), *slope_error, float(intercept), intercept_error.ci95)


class _Error(NamedTuple):
    ci95: float  # half-width of the 95 % interval
    se: float
    dof: float  # Student's factor for it is the ratio of both


def _error(se: float, dof: float, of_trials: np.ndarray) -> _Error:
    """Combine a standard error of the residuals with the scatter of the trials' values (n,)."""
    ci95, n = student_factor(dof) * se, len(of_trials)
    if n < 2:
        return _Error(ci95, se, dof)
    se_trials = float(np.std(of_trials, ddof=1)) / math.sqrt(n)
    total = math.hypot(se, se_trials)
    if total == 0.0:
        return _Error(0.0, 0.0, dof)
    ci95 = math.hypot(ci95, student_factor(n - 1) * se_trials)
    return _Error(ci95, total, degrees_of_freedom(ci95 / total))
