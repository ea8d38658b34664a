"""Values with the rounding errors that another computer would make."""

import numpy as np

SHAKE = 1e-13  # of a value


def shaken(values, seed):
    """Return values with each changed by ``SHAKE`` of itself at most."""
    values = np.asarray(values, dtype=float)
    return values * (1 + SHAKE * np.random.default_rng(seed).uniform(-1, 1, values.shape))
