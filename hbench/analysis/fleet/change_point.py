"""Change point: a step of the mean of values in their order.

For each split into the first k and the last n - k values, the likelihood ratio of a step against a
constant mean (normal values of one unknown variance) rises with

    t_k^2 = k (n - k) / n (mean_2 - mean_1)^2 / s_k^2

with s_k the pooled standard deviation of both parts, for n - 2 degrees of freedom. The change point
is the k of the largest t_k^2 (Worsley, Journal of the American Statistical Association 74, 1979;
Hawkins, Qiu and Kang, Journal of Quality Technology 35, 2003). Since k is chosen by the data, the p
value is that of the largest t_k^2 among random orders of the same values (permutation test), from a
generator with a fixed seed: the same values have the same p. A steady drift also appears as a step.

The interval of the step is Student's for two means with s_k at the chosen k. Where the position of
a small step is in doubt, it does not contain that the largest difference was chosen.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.analysis.statistics.student import student_factor
from hbench.records import FEWEST_CAMPAIGNS

_PART = 3  # values of the shorter part
_ORDERS = 1999  # random orders; the smallest p is 1 / 2000
_SEED = 7870
_MOST = 400  # values; more are averaged in groups
_ROWS = 100  # random orders at a time


class StepChange(NamedTuple):
    """The most likely step of the mean."""

    first: int  # position of the first value after it
    before: float  # means
    after: float
    ci95: float  # half-width of the interval of their difference
    p: float  # of no step


def change_point(x: np.ndarray) -> StepChange | None:
    """Return the most likely step of x (n,); None for too few or constant values.

    The order of x is that in time. Many values are averaged in groups that follow each other.
    """
    x = np.asarray(x, dtype=float)
    if len(x) < FEWEST_CAMPAIGNS or is_constant(x):
        return None
    groups = np.array_split(np.arange(len(x)), min(len(x), _MOST))
    y = np.array([x[group].mean() for group in groups])
    statistic = _statistic(y[None, :])[0]
    at = int(np.argmax(statistic))
    first = int(groups[at + _PART][0])
    rng = np.random.default_rng(_SEED)
    as_large = 0
    for start in range(0, _ORDERS, _ROWS):
        orders = rng.permuted(np.tile(y, (min(_ROWS, _ORDERS - start), 1)), axis=1)
        largest = _statistic(orders).max(axis=1)
        as_large += int((largest >= statistic[at] * (1 - 1e-12)).sum())
    p = (1 + as_large) / (1 + _ORDERS)
    return StepChange(first, *_means_and_interval(x[:first], x[first:]), p)


def _means_and_interval(before: np.ndarray, after: np.ndarray) -> tuple[float, float, float]:
    """Return both means, and the half-width of the 95 % interval of their difference."""
    dof = len(before) + len(after) - 2
    variance = sum(float(((part - part.mean()) ** 2).sum()) for part in (before, after)) / dof
    half = student_factor(dof) * sqrt(variance * (1 / len(before) + 1 / len(after)))
    return float(before.mean()), float(after.mean()), half


def _statistic(y: np.ndarray) -> np.ndarray:
    """Return t_k^2 of each row of y (rows, n) for k from ``_PART`` to n - ``_PART``."""
    n = y.shape[1]
    y = y - y.mean(axis=1, keepdims=True)
    k = np.arange(_PART, n - _PART + 1)
    sums = np.cumsum(y, axis=1)[:, k - 1]
    between = sums**2 * n / (k * (n - k))  # of the means of both parts; the total sum is zero
    total = (y**2).sum(axis=1, keepdims=True)
    within = np.maximum(total - between, np.finfo(float).tiny)
    return between / (within / (n - 2))
