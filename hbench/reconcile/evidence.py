"""Evidence for changes of a model: fits of the residuals and cross-validated likelihood.

About one model the differences d of a window (see ``gaps/gap_map.py``) are linear in the changes:

    d ~ sum beta_j c_j        c_j: column of nuisance or coefficient j, in trial scatters like d

Windows are grouped by balance and motion, and changes between windows have groups of their own
(see ``window_sums.py``). The remaining residuals of a group have an unknown variance v_g and are
constant within a run, so an operating point counts once:

    ln L = - sum_g n_g / 2 ln v_g - |(beta - b) / prior|^2 / 2,    v_g = mean of (d - beta c)^2

n_g is the number of operating points in the group. v_g is at least the noise of d. The maximum is
found by iteratively reweighted least squares with weights n_g / v_g.

The score of a candidate is its gain in ln L by five-fold cross-validation over operating points:
each fold is predicted by a fit to the other four. Null scores come from differences with a random
sign for each operating point, which preserves their sizes and their correlation within a run. For
a candidate these are its own residuals: what it does not explain, however large.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hbench.reconcile.products import Products, Sums

FOLDS = 5
_REWEIGHTINGS = 6  # at most
_CONVERGED = 1e-4  # standard deviations of priors and typical sizes; no further reweighting below
_BOUND_ITERATIONS = 3  # each may fix further parameters at their bounds
_FIXED_WEIGHT = 1e9  # fixes a parameter at its bound


@dataclass(frozen=True)
class Priors:
    """Priors and bounds of the factors beta on the columns."""

    centre: np.ndarray  # (q,)
    sigma: np.ndarray  # (q,) standard deviation
    low: np.ndarray  # (q,)
    high: np.ndarray  # (q,)

    def select(self, chosen: Sequence[int]) -> "Priors":
        """Return the priors of some columns."""
        columns = list(chosen)
        return Priors(
            self.centre[columns], self.sigma[columns], self.low[columns], self.high[columns]
        )

    def damped(self, radius: float) -> "Priors":
        """Return the priors with a further normal prior about 0 of the deviation ``radius``.

        What data determine still moves far, what they hardly determine does not (Levenberg 1944,
        Marquardt 1963).
        """
        own, both = self.sigma**-2.0, self.sigma**-2.0 + radius**-2.0
        return replace(self, centre=self.centre * own / both, sigma=both**-0.5)


def maximum_likelihood(
    data: Products,
    priors: Priors,
    chosen: Sequence[int],
    points: np.ndarray,
    signs: np.ndarray | None = None,
    groups: np.ndarray | None = None,
) -> np.ndarray:
    """Return the most likely beta (b, chosen) over some ``points``; ``signs`` (b, p) make nulls."""
    return _most_likely(data.sums(chosen, points, signs, groups), priors.select(chosen))


def _most_likely(sums: Sums, priors: Priors) -> np.ndarray:
    noise = np.broadcast_to(sums.noise, (len(sums.mixed), len(sums.noise)))
    from_noise = _reweighted_fit(sums, priors, noise)
    centre = np.tile(np.clip(priors.centre, priors.low, priors.high), (len(sums.mixed), 1))
    from_centre = _reweighted_fit(sums, priors, sums.variance(centre))
    better = _cost(sums, priors, from_centre) < _cost(sums, priors, from_noise)
    return np.where(better[:, None], from_centre, from_noise)


def expected_loss(
    data: Products,
    priors: Priors,
    chosen: Sequence[int],
    causes: np.ndarray,
    points: np.ndarray,
) -> np.ndarray:
    """Return the expected loss in ln L (b,) of the best fit of the ``chosen`` columns.

    The differences d are those of ``causes`` (b, q), factors on all columns. The loss is counted
    from a fit that leaves nothing but the noise; the priors' part is included.
    """
    columns = data.summed_columns(points)
    known = data.sums(chosen, points, None)
    sums = replace(
        known,
        mixed=columns.times(causes)[:, :, list(chosen)],
        squares=columns.squares(causes),
    )
    selected = priors.select(chosen)
    fitted = _cost(sums, selected, _most_likely(sums, selected))
    return fitted - 0.5 * float(np.log(sums.noise) @ sums.points)


def information(data: Products, points: np.ndarray) -> np.ndarray:
    """Return the information (q, q) on all columns: sum n_g / (m_g v_g) c c', v_g that of noise."""
    sums = data.sums((), points, None)
    weight = sums.points / (sums.windows * sums.noise)
    return data.summed_columns(points).weighted(weight[None])[0]


def cost(data: Products, priors: Priors, chosen: Sequence[int], points: np.ndarray) -> float:
    """Return - ln L of a model as it is, less a constant: at beta = 0 of the ``chosen`` columns."""
    sums = data.sums(chosen, points, None)
    return float(_cost(sums, priors.select(chosen), np.zeros((1, len(chosen))))[0])


def least_cost(data: Products, fit: "Fit", points: np.ndarray, groups: np.ndarray) -> float:
    """Return - ln L of the best fit to some ``points`` and ``groups``, less a constant."""
    chosen = fit.changing(data, groups)
    sums, priors = data.sums(chosen, points, None, groups), fit.priors.select(chosen)
    return float(_cost(sums, priors, _most_likely(sums, priors))[0])


def _cost(sums: Sums, priors: Priors, beta: np.ndarray) -> np.ndarray:
    """Return - ln L (b,) of beta (b, q), less a constant."""
    off = (beta - priors.centre) / priors.sigma
    return 0.5 * (np.log(sums.variance(beta)) @ sums.points + np.sum(off**2, axis=1))


def _reweighted_fit(sums: Sums, priors: Priors, variance: np.ndarray) -> np.ndarray:
    """Return beta (b, q) of a reweighted fit that starts with the groups' variances (b, g).

    ln L has several maxima: a group that one beta fits well outweighs the others. A start with the
    noise gives the largest residuals the largest weight.
    """
    beta = np.full((len(variance), len(priors.centre)), np.inf)
    rows = np.arange(len(beta))
    for _ in range(_REWEIGHTINGS):
        step = _weighted_fit(sums.select(rows), priors, variance)
        moves = np.any(np.abs(step - beta[rows]) > _CONVERGED, axis=1)
        beta[rows] = step
        rows = rows[moves]
        if not len(rows):
            break
        variance = sums.select(rows).variance(beta[rows])
    return beta


def _weighted_fit(sums: Sums, priors: Priors, variance: np.ndarray) -> np.ndarray:
    """Return beta (b, q) within its bounds where the groups' variances (b, g) are known."""
    weight = sums.points / (sums.windows * variance)
    curved = sums.columns.weighted(weight)
    driven = np.einsum("bg,bgj->bj", weight, sums.mixed)
    beta = np.zeros_like(driven)
    fixed = np.zeros_like(driven, bool)
    rows = np.arange(len(driven))
    for _ in range(_BOUND_ITERATIONS):  # fix parameters beyond a bound, solve for the others
        matrix, held = curved[rows], fixed[rows]
        diagonal = np.einsum("bjj->bj", matrix)
        stiff = np.where(held, _FIXED_WEIGHT * (1 + diagonal), priors.sigma**-2.0)
        aim = np.where(held, beta[rows], priors.centre)
        diagonal += stiff
        solved = np.linalg.solve(matrix, (driven[rows] + stiff * aim)[..., None])[..., 0]
        beta[rows] = np.clip(solved, priors.low, priors.high)
        beyond = ((solved < priors.low) | (solved > priors.high)) & ~held
        fixed[rows] |= beyond
        rows = rows[beyond.any(axis=1)]
        if not len(rows):
            break
    return beta


class Spread(NamedTuple):
    """Uncertainty of parameters beta (q,)."""

    covariance: np.ndarray  # (q, q) for intervals
    sandwich: np.ndarray  # (q, q) from the residuals alone, however small they are
    dof: np.ndarray  # (q,) degrees of freedom


def spread(
    data: Products, priors: Priors, chosen: Sequence[int], beta: np.ndarray, points: np.ndarray
) -> Spread:
    """Return the uncertainty of ``beta`` (q,), a fit of the ``chosen`` columns.

    The sandwich estimate is over whole operating points. It is narrow where they are few: 91 % of
    simulated 95 % intervals contained the truth, with 12 and with 40 points. For intervals the
    variance in any direction is at least that of the curvature of ln L, whose noise contains the
    deviations that are not material: a law of another form may shift a parameter by as much. The
    degrees of freedom are the number of operating points that determine a parameter, less one.
    """
    selected, sums = priors.select(chosen), data.sums(chosen, points, None)
    weight = (sums.points / (sums.windows * sums.variance(beta[None])))[0]
    information = weight[:, None] * sums.columns.diagonal()
    prior_information = np.diag(selected.sigma**-2.0)
    inverse = np.linalg.inv(sums.columns.weighted(weight[None])[0] + prior_information)
    index = np.ix_(points, np.arange(len(weight)), np.array(chosen, dtype=int))
    of_columns = data.columns.select(np.array(chosen, dtype=int)).times(beta)
    residual = data.mixed[index] - of_columns[points]
    slope = np.einsum("g,pgj->pj", weight, residual)
    meat = slope.T @ slope * len(points) / max(len(points) - 1, 1) + prior_information
    sandwich = inverse @ meat @ inverse
    share = information / np.maximum(information.sum(axis=0), 1e-300)
    dof = np.maximum(share.T @ sums.points - 1, 1.0)
    return Spread(_larger(sandwich, inverse), sandwich, dof)


def _larger(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return a covariance (q, q) whose variance in any direction is at least that of both.

    It is the smallest such one that has their common principal axes; what both determine well, as
    a sum of two parameters of which they determine neither, remains so.
    """
    root = np.linalg.cholesky(second)
    turned = np.linalg.solve(root, np.linalg.solve(root, first).T)
    values, vectors = np.linalg.eigh(0.5 * (turned + turned.T))
    half = root @ vectors * np.sqrt(np.maximum(values, 1.0))
    return half @ half.T


class Fit(NamedTuple):
    """Columns of a fit and the priors of all columns."""

    chosen: Sequence[int]
    priors: Priors

    def changing(self, data: Products, groups: np.ndarray) -> list[int]:
        """Return the columns that change some groups."""
        return [j for j in self.chosen if data.columns.nonzero[groups, j].any()]


class Comparison(NamedTuple):
    """Fits without and with the columns ``more``; without may also mean within a tolerance."""

    data: Products
    before: Fit
    after: Fit
    more: Sequence[int]
    points: np.ndarray

    def score(self, signs: np.ndarray | None = None) -> np.ndarray:
        """Return the cross-validated gain in ln L (b,) of the fit after over the one before."""
        return self.gains(signs)[1].sum(axis=-1)

    def gains(
        self, signs: np.ndarray | None = None, within: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the groups (g,) that are compared, and the part (b, g) of each in the score.

        ``within`` (g,) are groups to which the comparison is limited.
        """
        groups = touched(self.data, self.before.chosen, self.more)
        if within is not None:
            groups = np.intersect1d(groups, within)
        before, after = (
            _log_likelihoods(predicted(self.data, fit, self.points, signs, groups))
            for fit in (self.before, self.after)
        )
        return groups, after - before


def predicted(
    data: Products, fit: "Fit", points: np.ndarray, signs: np.ndarray | None, groups: np.ndarray
) -> "CrossValidation":
    """Cross-validate a fit in some groups, with the columns that change them."""
    chosen = fit.changing(data, groups)
    return cross_validate(data, fit.priors, chosen, points, signs, groups)


def touched(data: Products, base: Sequence[int], more: Sequence[int]) -> np.ndarray:
    """Return the groups that ``more`` columns change, or that share a column with these.

    The others cancel in a score.
    """
    nonzero = data.columns.nonzero
    groups = nonzero[:, list(more)].any(axis=1)
    shared = [j for j in base if nonzero[groups, j].any()]
    return np.flatnonzero(groups | nonzero[:, shared].any(axis=1))


@dataclass(frozen=True)
class CrossValidation:
    """Prediction errors at operating points outside the fit, by group."""

    variance: np.ndarray  # (b, g) mean square over the windows, in squares of the trial scatter
    noise: np.ndarray  # (g,) its part from noise
    points: np.ndarray  # (g,) number of operating points
    windows: np.ndarray  # (g,) number of windows


def cross_validate(
    data: Products,
    priors: Priors,
    chosen: Sequence[int],
    points: np.ndarray,
    signs: np.ndarray | None = None,
    groups: np.ndarray | None = None,
) -> CrossValidation:
    """Predict each fold of the operating points by a fit to the others; ``groups`` are indices.

    The data keep the result: candidates share the fits without them.
    """
    key = _key(*vars(priors.select(chosen)).values(), chosen, points, signs, groups)
    if key not in data.predictions:
        data.predictions[key] = _cross_validated(data, priors, chosen, points, signs, groups)
    return data.predictions[key]


def _key(*arrays: np.ndarray | Sequence[int] | None) -> tuple[tuple, ...]:
    """Return what distinguishes arrays from others, in little memory."""
    every = [np.asarray(array) for array in arrays if array is not None]
    return tuple((array.shape, hash(array.tobytes())) for array in every)


def _cross_validated(
    data: Products,
    priors: Priors,
    chosen: Sequence[int],
    points: np.ndarray,
    signs: np.ndarray | None,
    groups: np.ndarray | None,
) -> CrossValidation:
    total = np.zeros(1)
    for number in range(min(FOLDS, len(points))):
        fold = np.arange(len(points)) % FOLDS == number
        beta = maximum_likelihood(data, priors, chosen, points[~fold], signs, groups)
        sums = data.sums(chosen, points[fold], signs, groups)
        total = total + sums.squared_residuals(beta)
    whole = data.sums(chosen, points, signs, groups)
    return CrossValidation(total / whole.windows, whole.noise, whole.points, whole.windows)


def log_likelihood(prediction: CrossValidation) -> np.ndarray:
    """Return ln L (b,) less a constant; a group's variance is at least its noise."""
    return _log_likelihoods(prediction).sum(axis=-1)


def _log_likelihoods(prediction: CrossValidation) -> np.ndarray:
    variance = np.maximum(prediction.variance, prediction.noise)
    return -0.5 * prediction.points * np.log(variance)


def rotated(data: Products, count: int, seed: int) -> np.ndarray:
    """Return factors (count, points, groups) on d for nulls of few points with a window each.

    The vector d of each group is rotated at random and keeps its length over the points, as in
    Langsrud's rotation tests (Statistics and Computing 15, 2005). Few points have too few sign
    patterns.
    """
    turned = np.random.default_rng(seed).standard_normal((count, *data.squares.shape))
    turned *= np.sqrt(data.squares.sum(axis=0) / np.sum(turned**2, axis=1))[:, None]
    return turned / np.sqrt(np.maximum(data.squares, 1e-30))


def random_signs(count: int, points: int, seed: int) -> np.ndarray:
    """Return signs (count, points) for nulls."""
    return np.random.default_rng(seed).choice([-1.0, 1.0], (count, points))
