"""Speeds of a steady experiment that do not depend on friction (sections 5.3 and 5.6.1)."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from hbench.config.velocities import LinearSpeeds, PolynomialSpeeds, SlopeAdjustedSpeeds


def speeds(
    velocities: PolynomialSpeeds | LinearSpeeds | SlopeAdjustedSpeeds | Sequence[float],
) -> np.ndarray:
    """Return the reference speeds [m/s] in order, from a strategy or as listed."""
    if isinstance(velocities, Sequence):
        return np.array(velocities)
    return _STRATEGIES[velocities.strategy](velocities)


def _polynomial(velocities: PolynomialSpeeds) -> np.ndarray:
    """Return v_i = a i + b i^2, i = 1..count (section 5.3)."""
    n = velocities.count
    b = (velocities.last - n * velocities.first) / (n * (n - 1))
    a = velocities.first - b
    i = np.arange(1, n + 1)
    return a * i + b * i**2


def _linear(velocities: LinearSpeeds) -> np.ndarray:
    return np.linspace(velocities.first, velocities.last, velocities.count)


def _slope_adjusted(velocities: SlopeAdjustedSpeeds) -> np.ndarray:
    below = velocities.count // 2  # steps
    above = velocities.count - 1 - below
    slow = np.linspace(velocities.first, velocities.transition, below + 1)
    fast = np.linspace(velocities.transition, velocities.last, above + 1)
    return np.concatenate([slow, fast[1:]])


_STRATEGIES: Mapping[str, Callable[..., np.ndarray]] = {
    "polynomial": _polynomial,
    "linear": _linear,
    "slope_adjusted": _slope_adjusted,
}
