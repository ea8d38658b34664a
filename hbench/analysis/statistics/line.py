"""Straight line by least squares, with Student's interval of its slope."""

from typing import NamedTuple

import numpy as np
from scipy.special import stdtr

from hbench.analysis.statistics.student import student_factor


class Line(NamedTuple):
    """Line y = intercept + slope x."""

    slope: float
    half: float  # half-width of the 95 % interval of the slope, n - 2 degrees of freedom
    intercept: float
    p: float  # of no slope, two-sided


def straight_line(x: np.ndarray, y: np.ndarray) -> Line:
    """Return the line through y (n,) over x (n,) with at least three different x."""
    dx = x - x.mean()
    slope = float(dx @ y / (dx @ dx))
    intercept = float(y.mean() - slope * x.mean())
    residual = y - intercept - slope * x
    dof = len(y) - 2
    se = float(np.sqrt(residual @ residual / dof / (dx @ dx)))
    p = float(2 * stdtr(dof, -abs(slope) / se)) if se > 0 else 0.0
    return Line(slope, student_factor(dof) * se, intercept, p)
