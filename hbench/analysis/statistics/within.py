"""Within estimator: values about the means of their groups, and the kind of their scatter.

A level of each group (fixed effect) explains its mean, so that only deviations from it count
(W. H. Greene, Econometric Analysis, 7th ed., 11.4.1).
"""

import numpy as np


def group_means(values: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Return the mean (n,) of each value's group; ``group`` (n,) numbers the groups."""
    _, index = np.unique(group, return_inverse=True)
    return (np.bincount(index, values) / np.bincount(index))[index]


def within(values: np.ndarray, group: np.ndarray) -> np.ndarray:
    """Return the deviations (n,) of values from the means of their groups."""
    return values - group_means(values, group)


def is_proportional(squares: float, squares_of_shares: float, mean: np.ndarray) -> bool:
    """Return whether residuals scatter in proportion to the means rather than alike everywhere.

    By the larger of two Gaussian likelihoods, each at its own best variance. With s_i = s |mean_i|
    against s_i = s:

        -n log(sum (r / mean)^2) / 2 - sum log mean  >  -n log(sum r^2) / 2

    ``squares`` and ``squares_of_shares`` are the sums of the squared residuals r and of those in
    shares of the mean; ``mean`` (n,) is positive. False without residuals.
    """
    if not squares > 0.0:
        return False
    gain = 0.5 * len(mean) * (np.log(squares) - np.log(squares_of_shares))
    return bool(gain > np.log(mean).sum())
