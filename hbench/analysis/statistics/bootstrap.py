"""Bootstrap: intervals from repeated fits to trials drawn from the measured ones.

Each reference's n trials are drawn with replacement. The variance of a mean of n drawn trials is
too small by (n - 1) / n (two thirds for three trials), so its distance from the measured mean is
multiplied by sqrt(n / (n - 1)). With so few trials percentiles are too narrow as well; they are
taken at Phi(-t) and Phi(t), with Student's t (Hesterberg, The American Statistician 69, 2015,
section 3.3) and the degrees of freedom of the parameter's points (Satterthwaite):

    nu = (sum u_i)^2 / sum(u_i^2 / (n_i - 1)),   u_i = (d theta / d F_i)^2 sigma_i^2

If references have a single trial, the fit's residuals are drawn instead, each divided by
sqrt(1 - h) to correct for its leverage h.
"""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.special import ndtr

from hbench.analysis.statistics.student import student_factor

_SINGULAR = 3e-7  # of the largest singular value of J, with columns of length 1


def drawn_means(
    trials: Sequence[np.ndarray], count: int, rng: np.random.Generator
) -> np.ndarray | None:
    """Return ``count`` rows of means of drawn trials (count, n); None if a point has one trial."""
    if min(map(len, trials)) < 2:
        return None
    columns = []
    for values in trials:
        n = len(values)
        drawn = values[rng.integers(0, n, (count, n))].mean(axis=1)
        columns.append(values.mean() + np.sqrt(n / (n - 1)) * (drawn - values.mean()))
    return np.column_stack(columns)


def drawn_residuals(
    fitted: np.ndarray, scaled: np.ndarray, sigma: np.ndarray, count: int, rng: np.random.Generator
) -> np.ndarray:
    """Return ``count`` rows (count, n) of ``fitted`` plus ``sigma`` times drawn residuals."""
    n = len(fitted)
    return fitted + sigma * scaled[rng.integers(0, n, (count, n))]


def leveraged(residual: np.ndarray, jacobian: np.ndarray) -> np.ndarray:
    """Return residuals (n,) divided by sqrt(1 - h), h being the leverages; their mean is zero."""
    u, s, _ = np.linalg.svd(_of_length_1(jacobian), full_matrices=False)
    leverage = np.sum(u[:, s > _SINGULAR * s.max(initial=0.0)] ** 2, axis=1)
    scaled = residual / np.sqrt(np.maximum(1 - leverage, 1e-3))
    return scaled - scaled.mean()


def parameter_dof(jacobian: np.ndarray, counts: np.ndarray) -> np.ndarray:
    """Return nu (p,) from weighted derivatives (n, p) and numbers of trials at each point (n,)."""
    shares = np.linalg.pinv(_of_length_1(jacobian), rcond=_SINGULAR) ** 2
    return shares.sum(axis=1) ** 2 / (shares**2 / (counts - 1)).sum(axis=1)


def _of_length_1(jacobian: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(jacobian, axis=0)
    return jacobian / np.where(length > 0.0, length, 1.0)


def percentile_intervals(
    refit: Callable[[np.ndarray], np.ndarray], drawn: np.ndarray, dof: np.ndarray
) -> np.ndarray:
    """Return the 95 % intervals (2, p) of ``refit`` over the rows of ``drawn`` (count, n).

    ``dof`` (p,) are the degrees of freedom of each parameter.
    """
    fitted = np.array([refit(row) for row in drawn])
    levels = [ndtr([-t, t]) for t in map(student_factor, dof)]
    columns = zip(fitted.T, levels, strict=True)
    return np.column_stack([np.quantile(column, level) for column, level in columns])
