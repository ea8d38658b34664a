"""Tables of learned laws: knots, and regularised modes of the values.

The values at the knots are y = B z, z ~ N(0, 1): a Gaussian process with the squared exponential
covariance s^2 exp(-d^2 / 2 l^2), B B' the covariance of the knots (Rasmussen and Williams, Gaussian
Processes for Machine Learning, 2006, section 2.2), d and l in distances of neighbouring knots. The
modes z are fitted as the nuisances are, each with a prior of 1.

The mean of a position sensor's error over the stroke is 0: flows show it as they show the gain of
all valves, and a sensor's span is calibrated.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from math import prod

import numpy as np

from hbench.config.effects import TARGETS, LearnedLaw, Target
from hbench.model.effects.rows import FLOWS

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
        basis = self.size * np.linalg.cholesky(covariance)
        if self.adds_to == "position_sensor":
            basis = basis - 0.5 * (basis[1:] + basis[:-1]).mean(axis=0)
        return basis

    @property
    def values(self) -> np.ndarray:
        """Values [SI] at the knots: (n,), or (n, m) over two quantities."""
        return (self.basis @ self.modes).reshape([len(each) for each in self.knots.values()])

    @property
    def balances(self) -> tuple[str, ...]:
        """Balances that the law changes."""
        return balances_of(self.adds_to)

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


def balances_of(target: Target) -> tuple[str, ...]:
    """Return the balances that a law of a target changes.

    Where the position sensor's slope is wrong, so is the piston's speed, which the flows into all
    chambers show. Kinematics does not: the board's velocity is the slope of the same reading. It
    has no target, since the rig's board computes that velocity as its firmware does.
    """
    return FLOWS if target == "position_sensor" else (target.replace("friction", "force"),)


FAMILIES = tuple(dict.fromkeys(map(balances_of, TARGETS)))  # balances that are searched together


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
