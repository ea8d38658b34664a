"""Tables of learned laws: knots, and regularised modes of the values.

The values at the knots are y = B z, z ~ N(0, 1): a Gaussian process with the squared exponential
covariance s^2 exp(-d^2 / 2 l^2), B B' the covariance of the knots (Rasmussen and Williams, Gaussian
Processes for Machine Learning, 2006, section 2.2), d and l in distances of neighbouring knots. The
modes z are fitted as the nuisances are, each with a prior of 1.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import prod

import numpy as np

from hbench.config.effects import LearnedLaw, Target

_LENGTH = 1.5  # l, in distances of neighbouring knots
_JITTER = 1e-4


@dataclass(frozen=True)
class Table:
    """Table of one learned law, with the modes that its values consist of."""

    adds_to: Target
    knots: Mapping[str, tuple[float, ...]]  # [SI] by quantity
    size: float  # s, prior standard deviation of a value [SI]
    modes: tuple[float, ...]  # z

    @cached_property
    def basis(self) -> np.ndarray:
        """B (values, modes) [SI]."""
        places = (np.arange(len(each)) for each in self.knots.values())
        at = np.stack([each.ravel() for each in np.meshgrid(*places, indexing="ij")], axis=-1)
        squares = ((at[:, None] - at) ** 2).sum(axis=-1)
        covariance = np.exp(-0.5 * squares / _LENGTH**2) + _JITTER * np.eye(len(at))
        return self.size * np.linalg.cholesky(covariance)

    @property
    def values(self) -> np.ndarray:
        """Values [SI] at the knots: (n,), or (n, m) over two quantities."""
        return (self.basis @ self.modes).reshape([len(each) for each in self.knots.values()])

    @property
    def balance(self) -> str:
        """Balance that the law changes."""
        return self.adds_to.replace("friction", "force")

    @property
    def law(self) -> LearnedLaw:
        """The law as the plant has it."""
        rows = tuple(tuple(row) if np.ndim(row) else row for row in self.values.tolist())
        return LearnedLaw.model_construct(adds_to=self.adds_to, over=dict(self.knots), values=rows)

    def stepped(self, mode: int, step: float) -> "Table":
        """Return the table with one mode changed."""
        modes = list(self.modes)
        modes[mode] += step
        return replace(self, modes=tuple(modes))


@dataclass(frozen=True)
class LawFound:
    """Evidence for a learned law that was kept."""

    table: int  # its index in the final hypothesis
    score: float  # nats
    threshold: float  # that the score exceeds
    p_value: float  # of the reduction at held-out points


def empty_table(adds_to: Target, knots: Mapping[str, tuple[float, ...]], size: float) -> Table:
    """Return a table whose values are 0; ``size`` is their prior standard deviation."""
    return Table(adds_to, knots, size, (0.0,) * prod(map(len, knots.values())))


def is_mode(name: str) -> bool:
    """Return whether a column is that of a mode."""
    return name.startswith("#")


def mode_name(table: int, mode: int) -> str:
    """Return the name of a mode's column."""
    return f"#{table}.{mode}"


def mode_of(name: str) -> tuple[int, int]:
    """Return table and mode of a column."""
    table, _, mode = name[1:].partition(".")
    return int(table), int(mode)
