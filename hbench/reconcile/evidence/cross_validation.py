"""Evidence for changes of a model: gain in likelihood by cross-validation, and its nulls.

The score of a candidate is its gain in ln L (``likelihood.py``) by five-fold cross-validation over
operating points: each fold is predicted by a fit to the other four. Null scores come from
differences with a random sign for each operating point, which preserves their sizes and their
correlation within a run. For a candidate these are its own residuals: what it does not explain,
however large.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hbench.reconcile.evidence.likelihood import Fit, Priors, most_likely
from hbench.reconcile.evidence.products import Products

FOLDS = 5


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
            predicted(self.data, fit, self.points, signs, groups)
            for fit in (self.before, self.after)
        )
        return groups, after.gains_over(before)


def predicted(
    data: Products, fit: Fit, points: np.ndarray, signs: np.ndarray | None, groups: np.ndarray
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

    def gains_over(self, other: "CrossValidation") -> np.ndarray:
        """Return the gain (b, g) in ln L over another prediction of the same groups.

        A group's variance is at least the noise of both: about another model the trials may differ
        more or less, and that is no evidence.
        """
        noise = np.maximum(self.noise, other.noise)
        own, others = (np.maximum(each.variance, noise) for each in (self, other))
        return 0.5 * self.points * np.log(others / own)


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
    held_out = np.zeros((min(FOLDS, len(points)), len(data.squares)), bool)
    held_out[np.arange(len(points)) % FOLDS, points] = True
    selected, total = priors.select(chosen), np.zeros(1)
    # All folds at once; those of null data sets, which need far more memory, one after the other.
    for folds in held_out[None] if signs is None else held_out[:, None]:
        others = held_out.any(axis=0) & ~folds
        beta = most_likely(data.sums(chosen, others, signs, groups), selected)
        sums = data.sums(chosen, folds, signs, groups)
        total = total + sums.squared_residuals(beta).sum(axis=0)
    whole = data.sums((), data.part(points), groups=groups)
    return CrossValidation(
        total / whole.windows[0], whole.noise[0], whole.points[0], whole.windows[0]
    )


def rotated(data: Products, count: int, seed: int) -> np.ndarray:
    """Return factors (count, points, groups) on d for nulls of few points with a window each.

    The vector d of each group is rotated at random and keeps its length over the points, as in
    Langsrud's rotation tests (Statistics and Computing 15, 2005). Few points have too few sign
    patterns.
    """
    turned = np.random.default_rng(seed).standard_normal((count, *data.squares.shape))
    turned *= np.sqrt(data.squares.sum(axis=0) / np.sum(turned**2, axis=1))[:, None]
    return turned / np.sqrt(np.maximum(data.squares, 1e-30))
