"""Interface of a friction law for fits: a function of speed and pressures, one nonlinear parameter.

Friction and speed are magnitudes; inputs are rows speed >= 0 [m/s], P_p [Pa], P_r [Pa].
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

_GRID = 15  # values of the nonlinear parameter tried for a start

Bounds = Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class FittableLaw:
    """A law F(inputs, p) with its parameters' names and units, in the order of p."""

    name: str
    units: Mapping[str, str]
    model: Callable[[np.ndarray, np.ndarray], np.ndarray]  # (3, n), (p,) -> (n,) [N]
    jacobian: Callable[[np.ndarray, np.ndarray], np.ndarray]  # -> (n, p)
    # Derivatives (n, p - 1) by the linear parameters, in order, at a value of the nonlinear one.
    basis: Callable[[np.ndarray, float], np.ndarray]
    nonlinear: str  # its name
    # Bounds and typical sizes of the parameters, from inputs and the largest friction [N].
    bounds: Callable[[np.ndarray, float], Bounds]
    scale: Callable[[np.ndarray, float], np.ndarray]
    pressures: bool = False  # whether the law needs both chambers' pressures
    # Values of the nonlinear parameter between two bounds, rising, among which are all minima of
    # the cost: from inputs, friction, its standard deviations and the bounds. The basis is linear
    # between them. None: a grid.
    candidates: Callable[..., np.ndarray] | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters."""
        return tuple(self.units)

    def limits(
        self, inputs: np.ndarray, force_n: float, other: Bounds
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return lower and upper bounds (p,); those in ``other`` replace the law's own."""
        chosen = {**self.bounds(inputs, force_n), **other}
        free = (-np.inf, np.inf)
        lower, upper = np.array([chosen.get(name, free) for name in self.names], dtype=float).T
        return lower, upper

    def uneven(
        self,
        inputs: np.ndarray,
        friction: np.ndarray,
        sigma: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
    ) -> tuple[int, np.ndarray] | None:
        """Return index and values of a nonlinear parameter with several minima; else None."""
        if self.candidates is None:
            return None
        index = self.names.index(self.nonlinear)
        return index, self.candidates(inputs, friction, sigma, lower[index], upper[index])

    def starts(
        self,
        inputs: np.ndarray,
        friction: np.ndarray,
        sigma: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
    ) -> list[np.ndarray]:
        """Return a start for each minimum over the nonlinear parameter, with optimal others."""
        index = self.names.index(self.nonlinear)
        low, high = lower[index], upper[index]
        if self.candidates is None:
            values = _spread(low, high)
        else:
            values = self.candidates(inputs, friction, sigma, low, high)
        starts, costs = [], []
        for value in values:
            matrix = self.basis(inputs, value) / sigma[:, None]
            size = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
            linear = np.linalg.lstsq(matrix / size, friction / sigma, rcond=None)[0] / size
            p = np.clip(np.insert(linear, index, value), lower, upper)
            starts.append(p)
            costs.append(np.sum(((self.model(inputs, p) - friction) / sigma) ** 2))
        padded = np.array([np.inf, *costs, np.inf])
        minima = (padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:])
        return [starts[i] for i in np.flatnonzero(minima)]


def _spread(low: float, high: float) -> np.ndarray:
    """Return values between two bounds of one sign, denser towards zero."""
    if low >= 0.0:
        return np.geomspace(max(low, 1e-4 * high), high, _GRID)
    return -_spread(-high, -low)[::-1] if high <= 0.0 else np.linspace(low, high, _GRID)
