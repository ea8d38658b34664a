"""Products of residuals and columns by operating point and group, and their sums over points."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Products:
    """Sums of products over windows, by operating point p and group g, for q columns."""

    names: tuple[str, ...]  # (q,) names of the columns
    columns: np.ndarray  # (p, g, q, q)
    mixed: np.ndarray  # (p, g, q) columns with d
    squares: np.ndarray  # (p, g) of d
    noise: np.ndarray  # (p, g) expected sum of squares of d's noise
    windows: np.ndarray  # (p, g) number of windows
    groups: tuple[tuple[str, str], ...]  # (g,) balance and motion
    _sums: dict[bytes, np.ndarray] = field(default_factory=dict, init=False, repr=False)

    def with_residuals(
        self, mixed: np.ndarray, squares: np.ndarray, noise: np.ndarray
    ) -> "Products":
        """Return the products of other residuals d with the same columns."""
        other = replace(self, mixed=mixed, squares=squares, noise=noise)
        other._sums.update(self._sums)
        return other

    def summed_columns(self, points: np.ndarray) -> np.ndarray:
        """Return the products of the columns (g, q, q) over some operating points."""
        key = points.tobytes()
        if key not in self._sums:
            self._sums[key] = self.columns[points].sum(axis=0)
        return self._sums[key]

    @cached_property
    def predictions(self) -> dict[tuple, Any]:
        """Cross-validations of these data that are known, by what they depend on."""
        return {}

    @cached_property
    def nonzero(self) -> np.ndarray:
        """Which columns (g, q) change a group."""
        return np.einsum("pgjj->gj", self.columns) > 0

    def sums(
        self,
        chosen: Sequence[int],
        points: np.ndarray,
        signs: np.ndarray | None,
        groups: np.ndarray | None = None,
    ) -> "Sums":
        """Return the sums over some operating points for the ``chosen`` columns.

        ``signs`` (b, p) or (b, p, g) are factors on d of b data sets; ``groups`` are indices.
        """
        if groups is None:
            groups = np.arange(self.squares.shape[1])
        columns = np.array(chosen, dtype=int)
        at = np.ix_(points, groups)
        windows, squares = self.windows[at].sum(axis=0), self.squares[at].sum(axis=0)
        mixed = self.mixed[np.ix_(points, groups, columns)]
        if signs is None:
            mixed = mixed.sum(axis=0)[None]
        elif signs.ndim == 2:
            mixed = np.tensordot(signs[:, points], mixed, axes=1)
        else:
            turned = signs[np.ix_(np.arange(len(signs)), points, groups)]
            mixed = np.einsum("bpg,pgj->bgj", turned, mixed)
            squares = np.einsum("bpg,pg->bg", turned**2, self.squares[at])
        return Sums(
            columns=self.summed_columns(points)[np.ix_(groups, columns, columns)],
            mixed=mixed,
            squares=squares,
            noise=np.maximum(self.noise[at].sum(axis=0) / np.maximum(windows, 1), 1e-12),
            windows=np.maximum(windows, 1),
            points=(self.windows[at] > 0).sum(axis=0),
        )


@dataclass(frozen=True)
class Sums:
    """Products summed over some operating points."""

    columns: np.ndarray  # (g, q, q)
    mixed: np.ndarray  # (b, g, q)
    squares: np.ndarray  # (g,) or (b, g)
    noise: np.ndarray  # (g,) per window
    windows: np.ndarray  # (g,), at least 1
    points: np.ndarray  # (g,)

    def select(self, rows: np.ndarray) -> "Sums":
        """Return the sums of some data sets."""
        if len(rows) == len(self.mixed):
            return self
        squares = self.squares if self.squares.ndim == 1 else self.squares[rows]
        return replace(self, mixed=self.mixed[rows], squares=squares)

    def squared_residuals(self, beta: np.ndarray) -> np.ndarray:
        """Return sums (b, g) of (d - beta c)^2."""
        crossed = (self.mixed @ beta[:, :, None])[:, :, 0]
        curved = np.sum((beta @ self.columns) * beta, axis=2).T
        return np.maximum(self.squares - 2 * crossed + curved, 0.0)

    def variance(self, beta: np.ndarray) -> np.ndarray:
        """Return the variances v (b, g), at least the noise."""
        return np.maximum(self.squared_residuals(beta) / self.windows, self.noise)
