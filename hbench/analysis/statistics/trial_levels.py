"""Common level of the points of each trial, and the uncertainty that it gives to their means.

    y_ij = a_i + g_i u_j + e_ij,   u_j ~ N(0, s_u^2),   e_ij ~ N(0, s^2 sigma_i^2)

Trial j of point i deviates by its level u_j at all points: g_i = 1 where levels differ by a force,
g_i = |F_i| / mean |F| where they differ by a share of friction. The mean of k trials contains the
mean of the levels, with the standard deviation s_u / sqrt(k), at all points together, so that
residuals about a fitted law do not show it. By Henderson's third method (S. R. Searle et al.,
Variance Components, 1992, section 5.5):

    s_u^2 = (SS_u - r MS_e) / tr(D'D)

D (N, k) are the weighted g_i of each trial, without the part that the points' levels a_i explain,
SS_u the sum of squares that D explains of the weighted deviations, r its rank, and MS_e the mean
square of what remains.
"""

from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc

from hbench.analysis.rounding import ROUNDING
from hbench.analysis.statistics.within import within


class TrialLevels(NamedTuple):
    """Effect of the trials' levels on the means of the points."""

    u_n: np.ndarray  # (n,) standard uncertainty of each point's mean; the same error at all points
    dof: float  # of its variance
    p: float  # of the F test of equal levels


def trial_levels(
    friction_n: np.ndarray, point: np.ndarray, trial: np.ndarray, sigma: np.ndarray
) -> TrialLevels | None:
    """Estimate the trials' levels from friction (N,) of trials ``trial`` (N,) of ``point`` (N,).

    ``point`` numbers the points from 0; ``sigma`` (n,) are relative standard deviations of a trial
    at each point. Of the two forms of g, the one that explains more counts. None where the data
    does not separate levels from scatter, or where they differ by no more than the scatter makes
    them differ.
    """
    _, number = np.unique(trial, return_inverse=True)
    counts = np.bincount(point, minlength=len(sigma))
    trials = int(number.max(initial=-1)) + 1
    if trials < 2 or not len(friction_n) > len(sigma) + trials - 1:
        return None
    means = np.bincount(point, friction_n) / counts
    y = within(friction_n, point) / sigma[point]
    if float(y @ y) <= ROUNDING**2 * float(np.sum((friction_n / sigma[point]) ** 2)):
        return None
    found = [_levels(y, point, number, sigma, shape) for shape in _shapes(means)]
    known = [levels for levels in found if levels is not None]
    if not known:
        return None
    best = min(known, key=lambda levels: levels.left)
    if not best.variance > 0.0:
        return None
    return TrialLevels(best.shape * np.sqrt(best.variance / counts.mean()), best.dof, best.p)


class _Levels(NamedTuple):
    shape: np.ndarray  # (n,) g
    variance: float  # s_u^2, not positive where the levels do not differ by more than the scatter
    dof: float
    p: float
    left: float  # SS_e


def _shapes(means: np.ndarray) -> list[np.ndarray]:
    size = np.abs(means)
    return [np.ones(len(means)), size / size.mean()]


def _levels(
    y: np.ndarray, point: np.ndarray, trial: np.ndarray, sigma: np.ndarray, shape: np.ndarray
) -> _Levels | None:
    weight = (shape / sigma)[point]
    columns = [within(weight * (trial == j), point) for j in range(int(trial.max()) + 1)]
    d = np.column_stack(columns)
    effects, _, rank, _ = np.linalg.lstsq(d, y, rcond=ROUNDING)
    explained = d @ effects
    dof = len(y) - len(sigma) - int(rank)
    if dof < 1 or rank < 1:
        return None
    rest = y - explained
    left = float(rest @ rest)
    between, within_trials = float(explained @ explained) / rank, left / dof
    excess = between - within_trials
    spread = between**2 / rank + within_trials**2 / dof  # Satterthwaite, of the difference
    return _Levels(
        shape=shape,
        variance=excess * rank / float(np.sum(d**2)),
        dof=excess**2 / spread if spread else 0.0,
        p=float(fdtrc(rank, dof, between / within_trials)) if within_trials else 0.0,
        left=left,
    )
