"""Correction of p values for the number of tests."""

from collections.abc import Sequence

import numpy as np


def holm(p_values: Sequence[float] | np.ndarray) -> np.ndarray:
    """Return p values after Holm (1979): max over k <= i of (m - k + 1) p_(k), at most 1."""
    p = np.asarray(p_values, dtype=float)
    order = np.argsort(p)
    grown = np.maximum.accumulate((len(p) - np.arange(len(p))) * p[order])
    corrected = np.empty(len(p))
    corrected[order] = np.minimum(grown, 1.0)
    return corrected
