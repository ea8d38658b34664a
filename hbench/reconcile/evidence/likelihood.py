"""Likelihood of changes of a model, and its maximum: fits of the residuals.

About one model the differences d of a window (see ``gaps/gap_map.py``) are linear in the changes:

    d ~ sum beta_j c_j        c_j: column of nuisance or coefficient j, in trial scatters like d

Windows are grouped by balance and motion, and changes between windows have groups of their own
(see ``window_sums.py``). The remaining residuals of a group have an unknown variance v_g and are
constant within a run, so an operating point counts once:

    ln L = - sum_g n_g / 2 ln v_g - |(beta - b) / prior|^2 / 2,    v_g = mean of (d - beta c)^2

n_g is the number of operating points in the group. v_g is at least the noise of d. The maximum is
found by iteratively reweighted least squares with weights n_g / v_g.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from hbench.reconcile.evidence.products import Products, Sums
from hbench.reconcile.evidence.reweighted import Given, reweighted_fits


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

    def shifted(self, steps: np.ndarray) -> "Priors":
        """Return the priors of what remains of beta after ``steps`` (q,)."""
        return Priors(self.centre - steps, self.sigma, self.low - steps, self.high - steps)

    def damped(self, radius: float) -> "Priors":
        """Return the priors with a further normal prior about 0 of the deviation ``radius``.

        What data determine still moves far, what they hardly determine does not (Levenberg 1944,
        Marquardt 1963).
        """
        own, both = self.sigma**-2.0, self.sigma**-2.0 + radius**-2.0
        return replace(self, centre=self.centre * own / both, sigma=both**-0.5)


class Fit(NamedTuple):
    """Columns of a fit and the priors of all columns."""

    chosen: Sequence[int]
    priors: Priors

    def changing(self, data: Products, groups: np.ndarray) -> list[int]:
        """Return the columns that change some groups."""
        return [j for j in self.chosen if data.columns.nonzero[groups, j].any()]


def maximum_likelihood(
    data: Products, priors: Priors, chosen: Sequence[int], points: np.ndarray
) -> np.ndarray:
    """Return the most likely beta (q,) of the ``chosen`` columns over some ``points``."""
    return most_likely(data.sums(chosen, data.part(points)), priors.select(chosen))[0, 0]


def likeliest(
    data: Products, alternatives: Sequence[Priors], chosen: Sequence[int], points: np.ndarray
) -> np.ndarray:
    """Return the most likely beta (q,) of the ``chosen`` columns with any of several priors."""
    sums = data.sums(chosen, data.part(points))
    fits = [_best_fit(sums, priors.select(chosen)) for priors in alternatives]
    beta, _ = min(fits, key=lambda fit: float(fit[1][0, 0]))
    return beta[0, 0]


def most_likely(sums: Sums, priors: Priors) -> np.ndarray:
    """Return the most likely beta (f, b, q) for each part and data set of the sums."""
    return _best_fit(sums, priors)[0]


def _best_fit(sums: Sums, priors: Priors) -> tuple[np.ndarray, np.ndarray]:
    """Return the most likely beta (f, b, q), and - ln L (f, b) there, less a constant.

    ln L has several maxima: a group that one beta fits well outweighs the others. Of two fits the
    better counts. One starts at the centre of the priors, the other with the noise as variance,
    which gives the largest residuals the largest weight.
    """
    f, b, g, q = sums.mixed.shape
    centre = np.broadcast_to(np.clip(priors.centre, priors.low, priors.high), (f, b, q))
    noise = np.broadcast_to(sums.noise[:, None], (f, b, g))
    given = Given(
        sums.columns.entries,
        np.ascontiguousarray(sums.mixed),
        np.array(np.broadcast_to(sums.squares, (f, b, g)), order="C"),
        sums.noise,
        sums.windows,
        sums.points,
        priors.centre,
        priors.sigma**-2.0,
        priors.low,
        priors.high,
    )
    variance = np.stack([sums.variance(centre), noise])
    beta = reweighted_fits(given, variance)
    cost = np.array([_cost(sums, priors, *each) for each in zip(beta, variance, strict=True)])
    better = cost[1] < cost[0]
    return np.where(better[..., None], beta[1], beta[0]), np.minimum(cost[0], cost[1])


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
    part = data.part(points)
    columns = data.summed_columns(part)
    sums = replace(
        data.sums(chosen, part),
        mixed=columns.times(causes)[..., list(chosen)],
        squares=columns.squares(causes[None]),
    )
    fitted = _best_fit(sums, priors.select(chosen))[1][0]
    return fitted - 0.5 * float(np.log(sums.noise[0]) @ sums.points[0])


def information(data: Products, points: np.ndarray) -> np.ndarray:
    """Return the information (q, q) on all columns: sum n_g / (m_g v_g) c c', v_g that of noise."""
    part = data.part(points)
    sums = data.sums((), part)
    weight = sums.points / (sums.windows * sums.noise)
    return data.summed_columns(part).weighted(weight[:, None])[0, 0]


def cost(data: Products, priors: Priors, chosen: Sequence[int], points: np.ndarray) -> float:
    """Return - ln L of a model as it is, less a constant: at beta = 0 of the ``chosen`` columns."""
    sums = data.sums(chosen, data.part(points))
    unchanged = np.zeros((1, 1, len(chosen)))
    return float(_cost(sums, priors.select(chosen), unchanged, sums.variance(unchanged))[0, 0])


def least_cost(data: Products, fit: Fit, points: np.ndarray, groups: np.ndarray) -> float:
    """Return - ln L of the best fit to some ``points`` and ``groups``, less a constant."""
    chosen = fit.changing(data, groups)
    sums = data.sums(chosen, data.part(points), groups=groups)
    return float(_best_fit(sums, fit.priors.select(chosen))[1][0, 0])


def _cost(sums: Sums, priors: Priors, beta: np.ndarray, variance: np.ndarray) -> np.ndarray:
    """Return - ln L (f, b) of beta (f, b, q) with its variances (f, b, g), less a constant."""
    off = (beta - priors.centre) / priors.sigma
    of_data = (np.log(variance) @ sums.points[..., None])[..., 0]
    return 0.5 * (of_data + np.sum(off**2, axis=2))


class Spread(NamedTuple):
    """Uncertainty of parameters beta (q,)."""

    covariance: np.ndarray  # (q, q) for intervals
    sandwich: np.ndarray  # (q, q) from the residuals alone, however small they are
    dof: np.ndarray  # (q,) degrees of freedom


def spread(
    data: Products,
    priors: Priors,
    chosen: Sequence[int],
    beta: np.ndarray,
    points: np.ndarray,
    alike: np.ndarray | None = None,
) -> Spread:
    """Return the uncertainty of ``beta`` (q,), a fit of the ``chosen`` columns.

    The sandwich estimate is over whole operating points. It is narrow where they are few: 91 % of
    simulated 95 % intervals contained the truth, with 12 and with 40 points. For intervals the
    variance in any direction is at least that of two others. One is the sandwich over groups of
    operating points, ``alike`` (p,) by index: where a law has another form than the real one, its
    error is the same at all points of a speed (Liang and Zeger, Biometrika 73, 1986). The other is
    that of the curvature of ln L, whose noise contains the deviations that are not material: a law
    of another form may shift a parameter by as much. The degrees of freedom are the number of
    operating points that determine a parameter, less one.
    """
    selected, sums = priors.select(chosen), data.sums(chosen, data.part(points))
    variance = sums.variance(beta[None, None])
    weight = (sums.points / sums.windows)[0] / variance[0, 0]
    information = weight[:, None] * sums.columns.diagonal()[0]
    prior_information = np.diag(selected.sigma**-2.0)
    curved = sums.columns.weighted(weight[None, None])[0, 0]
    inverse = _inverse(curved + prior_information)
    index = np.ix_(points, np.arange(len(weight)), np.array(chosen, dtype=int))
    of_columns = data.columns.select(np.array(chosen, dtype=int)).times(beta)
    residual = data.mixed[index] - of_columns[points]
    slope = np.einsum("g,pgj->pj", weight, residual)
    sandwich = inverse @ (_scatter(slope) + prior_information) @ inverse
    others = [sandwich]
    if alike is not None:
        _, group = np.unique(alike[points], return_inverse=True)
        by_group = np.zeros((group.max() + 1, slope.shape[1]))
        np.add.at(by_group, group, slope)
        if len(by_group) > 1:
            others.append(inverse @ (_scatter(by_group) + prior_information) @ inverse)
    share = information / np.maximum(information.sum(axis=0), 1e-300)
    dof = np.maximum(share.T @ sums.points[0] - 1, 1.0)
    return Spread(_larger(inverse, *others), sandwich, dof)


def _scatter(slope: np.ndarray) -> np.ndarray:
    """Return the covariance (q, q) of the sum of n independent slopes of ln L (n, q)."""
    return slope.T @ slope * len(slope) / max(len(slope) - 1, 1)


def _inverse(matrix: np.ndarray) -> np.ndarray:
    """Return the inverse of a positive definite matrix (q, q), whose diagonal may differ widely."""
    size = np.sqrt(np.diag(matrix))
    inverse = np.linalg.inv(matrix / np.outer(size, size)) / np.outer(size, size)
    return 0.5 * (inverse + inverse.T)


def _larger(least: np.ndarray, *others: np.ndarray) -> np.ndarray:
    """Return a covariance (q, q) whose variance in any direction is at least that of all.

    Of two it is the smallest such one that has their common principal axes; what both determine
    well, as a sum of two parameters of which they determine neither, remains so. ``least`` must be
    well conditioned.
    """
    root = np.linalg.cholesky(least)
    for other in others:
        turned = np.linalg.solve(root, np.linalg.solve(root, other).T)
        values, vectors = np.linalg.eigh(0.5 * (turned + turned.T))
        root = root @ vectors * np.sqrt(np.maximum(values, 1.0))
    return root @ root.T
