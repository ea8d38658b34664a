"""Covariance of fitted parameters in its parts, and the degrees of freedom of any combination.

    V = C + l l'

C = s^2 (J'J)^-1 is the covariance by the scatter about the law, with n - p degrees of freedom, and
l = J^+ u the shift of the parameters by the common level of each trial, an error that all points
share (``statistics/trial_levels.py``). The weights in J are those of the fitted law of variances,
ln sigma^2 = a + b ln|v|, whose slope b has a standard error s_b. Were it larger by s_b, the
estimator J^+ would have the covariance C + D:

    D = s^2 (J^+ diag(x) J^+' - kappa (J'J)^-1),   x_i = s_b ln|v_i|,
    kappa = sum (1 - h_i) x_i / (n - p)

with the leverages h; the second term is the change of s^2. A combination c'p has the variance
c'Vc, whose degrees of freedom follow from the variances of its parts (Satterthwaite; JCGM 100:2008,
G.4):

    nu_e = 2 / (2 / (n - p) + (c'Dc / c'Cc)^2),   nu = (c'Vc)^2 / ((c'Cc)^2 / nu_e + (c'l)^4 / nu_u)
"""

import numpy as np

from hbench.analysis.statistics.trial_levels import TrialLevels
from hbench.records.fits import FitSpread


def parameter_spread(
    jacobian: np.ndarray,
    covariance: np.ndarray,
    variance: float,
    sigma: np.ndarray,
    slope_errors: np.ndarray,
    levels: TrialLevels | None,
) -> FitSpread:
    """Return the parts of the covariance of the free parameters (p,).

    ``jacobian`` (n, p) is weighted; ``covariance`` (p, p) is C, nan where not determined, and
    ``variance`` s^2. ``sigma`` (n,) are the points' relative standard deviations and
    ``slope_errors`` (n,) is x.
    """
    n, p = jacobian.shape
    known = np.isfinite(np.diag(covariance))
    weights, level, level_dof = np.zeros((p, p)), np.zeros(p), np.inf
    if n > p and variance > 0.0 and slope_errors.any():
        inverse = np.where(np.outer(known, known), covariance, 0.0) / variance
        estimator = inverse @ jacobian.T
        leverage = np.sum(jacobian.T * estimator, axis=0)
        kappa = float((1.0 - leverage) @ slope_errors) / (n - p)
        weights = variance * ((estimator * slope_errors) @ estimator.T - kappa * inverse)
    if levels is not None:
        level = np.linalg.lstsq(jacobian, levels.u_n / sigma, rcond=None)[0]
        level_dof = levels.dof
    return FitSpread(covariance, weights, level, level_dof)


def placed(spread: FitSpread, free: np.ndarray) -> FitSpread:
    """Return the parts over all parameters; nan in C, and else zero, for those not ``free``."""
    p, at = len(free), np.ix_(free, free)
    residual, weights, level = np.full((p, p), np.nan), np.zeros((p, p)), np.zeros(p)
    residual[at], weights[at], level[free] = spread.residual, spread.weights, spread.level
    return FitSpread(residual, weights, level, spread.level_dof)


def standard_uncertainty(
    spread: FitSpread, freedom: int, combinations: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the standard uncertainty (m,) of combinations (m, p), and its degrees of freedom (m,).

    Parameters without a variance count as known. The degrees are ``freedom``, n - p, where nothing
    scatters.
    """
    c = combinations
    own = _quadratic(np.where(np.isfinite(spread.residual), spread.residual, 0.0), c)
    by_level = (c @ spread.level) ** 2
    total = own + by_level
    by_weights = _quadratic(spread.weights, c)
    noise = 2.0 * own**2 / freedom + by_weights**2 + 2.0 * by_level**2 / spread.level_dof
    with np.errstate(invalid="ignore", divide="ignore"):
        dof = np.where(noise > 0.0, 2.0 * total**2 / noise, float(freedom))
    return np.sqrt(np.maximum(total, 0.0)), dof


def _quadratic(matrix: np.ndarray, c: np.ndarray) -> np.ndarray:
    return np.sum(c @ matrix * c, axis=1)
