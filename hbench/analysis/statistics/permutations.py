"""Permutation tests: random signs, and the p-value of a statistic among those of permutations."""

import numpy as np
from numpy.typing import ArrayLike

from hbench.analysis.rounding import ROUNDING


def random_signs(count: int, size: int, seed: int = 0) -> np.ndarray:
    """Return random signs (count, size), -1 or 1."""
    return np.random.default_rng(seed).choice([-1.0, 1.0], (count, size))


def permutation_p(observed: ArrayLike, permuted: np.ndarray) -> np.ndarray:
    """Return p-values (...,): the share of statistics at least as large as the observed ones.

    ``permuted`` (n, ...) are those of n permutations. The observed one counts as a permutation, so
    p is at least 1 / (n + 1).
    """
    as_large = permuted >= np.asarray(observed) * (1 - ROUNDING)
    return (1 + as_large.sum(axis=0)) / (1 + len(permuted))
