"""Products of residuals and columns by operating point and group, and their sums over points."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from hbench.reconcile.evidence.reweighted import Entries


class Block(NamedTuple):
    """Products of the columns that are not 0 in some groups, such as those of a balance."""

    groups: np.ndarray  # (k,) indices
    columns: np.ndarray  # (u,) indices
    values: np.ndarray  # (p, k, u, u) by operating point, or (f, k, u, u) by part


@dataclass(frozen=True)
class ColumnSums:
    """Products of q columns by part f and group g. Most columns are 0 in most of the groups."""

    blocks: tuple[Block, ...]
    shape: tuple[int, int, int]  # f, g, q

    def select(self, groups: np.ndarray, columns: np.ndarray) -> "ColumnSums":
        """Return the products of some columns in some groups, which get the indices there."""
        f, g, q = self.shape
        blocks = _selected(self.blocks, (g, q), groups, columns)
        return ColumnSums(tuple(blocks), (f, len(groups), len(columns)))

    @cached_property
    def entries(self) -> Entries:
        """The products, end to end."""
        sizes = [(len(block.groups), len(block.columns)) for block in self.blocks]
        widths = np.concatenate([[0], *(np.full(k, u) for k, u in sizes)]).astype(int)
        columns = [np.tile(block.columns, len(block.groups)) for block in self.blocks]
        values = [block.values.reshape(self.shape[0], -1) for block in self.blocks]
        return Entries(
            np.concatenate([np.zeros(0, int), *(block.groups for block in self.blocks)]),
            np.cumsum(widths),
            np.concatenate([np.zeros(0, int), *columns]),
            np.cumsum(widths[:-1] ** 2),
            np.concatenate([np.zeros((self.shape[0], 0)), *values], axis=1),
        )

    def diagonal(self) -> np.ndarray:
        """Return the squares (f, g, q) of the columns."""
        out = np.zeros(self.shape)
        for groups, columns, values in self.blocks:
            out[:, groups[:, None], columns] = np.einsum("fkjj->fkj", values)
        return out

    def weighted(self, weight: np.ndarray) -> np.ndarray:
        """Return the sums (f, b, q, q) over the groups with a weight (f, b, g) of each."""
        q = self.shape[2]
        out = np.zeros((*weight.shape[:2], q, q))
        for groups, columns, values in self.blocks:
            f, k, u, _ = values.shape
            part = weight[..., groups] @ values.reshape(f, k, u * u)
            out[..., columns[:, None], columns] += part.reshape(f, -1, u, u)
        return out

    def times(self, beta: np.ndarray) -> np.ndarray:
        """Return the products (f, b, g, q) with the sum of the columns, each times beta (b, q)."""
        f, g, q = self.shape
        out = np.zeros((f, len(beta), g, q))
        for groups, columns, values in self.blocks:
            part = np.einsum("bj,fkji->fbki", beta[:, columns], values)
            out[..., groups[:, None], columns] = part
        return out

    def squares(self, beta: np.ndarray) -> np.ndarray:
        """Return the squares (f, b, g) of the sum of the columns, each times beta (f, b, q)."""
        out = np.zeros((self.shape[0], beta.shape[1], self.shape[1]))
        for groups, columns, values in self.blocks:
            own = beta[:, None, :, columns]
            out[..., groups] = np.sum((own @ values) * own, axis=3).swapaxes(1, 2)
        return out


@dataclass(frozen=True)
class ColumnProducts:
    """Products of q columns by operating point p and group g. Groups in no block have only 0."""

    blocks: tuple[Block, ...]
    shape: tuple[int, int, int]  # p, g, q

    @cached_property
    def nonzero(self) -> np.ndarray:
        """Which columns (g, q) change a group."""
        out = np.zeros(self.shape[1:], bool)
        for groups, columns, values in self.blocks:
            out[np.ix_(groups, columns)] = np.einsum("pkjj->kj", values) > 0
        return out

    def dense(self, groups: np.ndarray, columns: np.ndarray) -> np.ndarray:
        """Return all products (p, k, u, u) of some columns in some groups."""
        k, u = len(groups), len(columns)
        out = np.zeros((self.shape[0], k, u, u))
        for at, own, values in _selected(self.blocks, self.shape[1:], groups, columns):
            out[:, at[:, None, None], own[:, None], own] = values
        return out

    def scaled(self, factors: np.ndarray) -> "ColumnProducts":
        """Return the products times factors (p, g)."""
        blocks = (
            each._replace(values=each.values * factors[:, each.groups, None, None])
            for each in self.blocks
        )
        return ColumnProducts(tuple(blocks), self.shape)

    def followed_by(self, more: "ColumnProducts") -> "ColumnProducts":
        """Return the products at these operating points, and then those at the points of more."""
        nonzero = self.nonzero | more.nonzero
        blocks = []
        for pattern in np.unique(nonzero[nonzero.any(axis=1)], axis=0):
            groups = np.flatnonzero((nonzero == pattern).all(axis=1))
            columns = np.flatnonzero(pattern)
            values = [each.dense(groups, columns) for each in (self, more)]
            blocks.append(Block(groups, columns, np.concatenate(values)))
        p, g, q = self.shape
        return ColumnProducts(tuple(blocks), (p + more.shape[0], g, q))

    def summed(self, parts: np.ndarray) -> ColumnSums:
        """Return the sums over the operating points of each part (f, p), a mask."""
        blocks = (
            each._replace(values=np.tensordot(parts.astype(float), each.values, axes=1))
            for each in self.blocks
        )
        return ColumnSums(tuple(blocks), (len(parts), *self.shape[1:]))

    def select(self, columns: np.ndarray) -> "ColumnProducts":
        """Return the products of some columns."""
        p, g, q = self.shape
        blocks = _selected(self.blocks, (g, q), np.arange(g), columns)
        return ColumnProducts(tuple(blocks), (p, g, len(columns)))

    def times(self, beta: np.ndarray) -> np.ndarray:
        """Return the products (p, g, q) with the sum of the columns, each times beta (q,)."""
        out = np.zeros(self.shape)
        for groups, columns, values in self.blocks:
            out[:, groups[:, None], columns] = values @ beta[columns]
        return out


def _selected(
    blocks: Iterable[Block], shape: tuple[int, int], groups: np.ndarray, columns: np.ndarray
) -> Iterator[Block]:
    """Yield blocks of some groups and columns; -1 is the place of those that are not among them."""
    places = [np.full(size, -1) for size in shape]
    for place, chosen in zip(places, (groups, columns), strict=True):
        place[chosen] = np.arange(len(chosen))
    for block in blocks:
        at, used = (
            place[own] for place, own in zip(places, (block.groups, block.columns), strict=True)
        )
        k, u = np.flatnonzero(at >= 0), np.flatnonzero(used >= 0)
        if len(k) and len(u):
            values = block.values
            if len(k) < len(at) or len(u) < len(used):
                values = values[..., k[:, None, None], u[:, None], u]
            yield Block(at[k], used[u], values)


@dataclass(frozen=True)
class Products:
    """Sums of products over windows, by operating point p and group g, for q columns."""

    names: tuple[str, ...]  # (q,) names of the columns
    columns: ColumnProducts
    mixed: np.ndarray  # (p, g, q) columns with d
    squares: np.ndarray  # (p, g) of d
    noise: np.ndarray  # (p, g) expected sum of squares of d's noise
    windows: np.ndarray  # (p, g) number of windows
    groups: tuple[tuple[str, str], ...]  # (g,) balance and motion
    _sums: dict[bytes, ColumnSums] = field(default_factory=dict, init=False, repr=False)

    def with_residuals(
        self, mixed: np.ndarray, squares: np.ndarray, noise: np.ndarray
    ) -> "Products":
        """Return the products of other residuals d with the same columns."""
        other = replace(self, mixed=mixed, squares=squares, noise=noise)
        other._sums.update(self._sums)
        return other

    def part(self, points: np.ndarray) -> np.ndarray:
        """Return some operating points, by index, as the only part (1, p) of ``sums``."""
        found = np.zeros((1, len(self.squares)), bool)
        found[0, points] = True
        return found

    def summed_columns(self, parts: np.ndarray) -> ColumnSums:
        """Return the products of the columns over the operating points of each part (f, p)."""
        key = parts.tobytes()
        if key not in self._sums:
            self._sums[key] = self.columns.summed(parts)
        return self._sums[key]

    @cached_property
    def predictions(self) -> dict[tuple, Any]:
        """Cross-validations of these data that are known, by what they depend on."""
        return {}

    def sums(
        self,
        chosen: Sequence[int],
        parts: np.ndarray,
        signs: np.ndarray | None = None,
        groups: np.ndarray | None = None,
    ) -> "Sums":
        """Return the sums for the ``chosen`` columns over the operating points of each part (f, p).

        Parts are masks. ``signs`` (b, p) or (b, p, g) are factors on d of b data sets; ``groups``
        are indices.
        """
        if groups is None:
            groups = np.arange(self.squares.shape[1])
        columns = np.array(chosen, dtype=int)
        points = np.flatnonzero(parts.any(axis=0))
        among, at = parts[:, points].astype(float), np.ix_(points, groups)
        windows, squares = among @ self.windows[at], (among @ self.squares[at])[:, None]
        mixed = self.mixed[np.ix_(points, groups, columns)]
        if signs is None:
            mixed = np.tensordot(among, mixed, axes=1)[:, None]
        elif signs.ndim == 2:
            mixed = np.tensordot(among[:, None] * signs[:, points], mixed, axes=1)
        else:
            turned = signs[np.ix_(np.arange(len(signs)), points, groups)]
            squares = np.einsum("fp,bpg,pg->fbg", among, turned**2, self.squares[at])
            mixed = np.einsum("fbpg,pgj->fbgj", among[:, None, :, None] * turned, mixed)
        return Sums(
            columns=self.summed_columns(parts).select(groups, columns),
            mixed=mixed,
            squares=squares,
            noise=np.maximum(among @ self.noise[at] / np.maximum(windows, 1), 1e-12),
            windows=np.maximum(windows, 1),
            points=among @ (self.windows[at] > 0),
        )


@dataclass(frozen=True)
class Sums:
    """Products of b data sets summed over the operating points of each part f."""

    columns: ColumnSums
    mixed: np.ndarray  # (f, b, g, q)
    squares: np.ndarray  # (f, 1, g) or (f, b, g)
    noise: np.ndarray  # (f, g) per window
    windows: np.ndarray  # (f, g), at least 1
    points: np.ndarray  # (f, g)

    def squared_residuals(self, beta: np.ndarray) -> np.ndarray:
        """Return sums (f, b, g) of (d - beta c)^2 for beta (f, b, q)."""
        crossed = (self.mixed @ beta[..., None])[..., 0]
        return np.maximum(self.squares - 2 * crossed + self.columns.squares(beta), 0.0)

    def variance(self, beta: np.ndarray) -> np.ndarray:
        """Return the variances v (f, b, g), at least the noise."""
        variance = self.squared_residuals(beta) / self.windows[:, None]
        return np.maximum(variance, self.noise[:, None])
