"""Friction laws fitted to curves, and their choice by held-out speeds.

All quantities are SI, as in ``runs.py``.
"""

import math
from dataclasses import dataclass, field, fields
from itertools import combinations_with_replacement
from typing import Literal

import numpy as np

from hbench.records.numbers import (
    Determination,
    FitParameter,
    FloatOrNan,
    KindName,
    ParameterPair,
)

# Fewest speeds of which each is held out: five, and enough others for five parameters.
LEAST_HELD_OUT_SPEEDS = 7

FitVerdict = Literal[Determination, "not converged"]


@dataclass(frozen=True, eq=False)
class FitSpread:
    """Parts of a fit's covariance over its p parameters (``analysis/fitting/parameter_spread.py``).

    Entries of parameters at an active bound are nan in ``residual``, and zero in the others.
    """

    residual: np.ndarray  # (p, p) by the scatter of the points about the law
    weights: np.ndarray  # (p, p) its change by the standard error of the weights' law
    level: np.ndarray  # (p,) standard uncertainties by the trials' levels, one error with signs
    level_dof: float  # degrees of freedom of the squares of ``level``

    def __eq__(self, other: object) -> bool:
        """Return whether all entries are equal; nan is equal to nan."""
        return isinstance(other, FitSpread) and all(
            np.array_equal(getattr(self, part.name), getattr(other, part.name), equal_nan=True)
            for part in fields(self)
        )

    @property
    def covariance(self) -> np.ndarray:
        """Covariance (p, p) of the parameters."""
        return self.residual + np.outer(self.level, self.level)


@dataclass(frozen=True)
class Fit:
    """A friction law fitted to one curve."""

    law: str
    parameters: dict[str, FitParameter]
    rmse_n: FloatOrNan
    converged: bool
    message: str
    # The law at (v_m_s, friction_n), signed like the curve's points: the speed of each point,
    # and enough between for a smooth line. Nothing outside the measured speeds.
    line: tuple[tuple[float, float], ...] = ()
    # The same outside of them: down to rest, and somewhat above. Extrapolated, not measured.
    beyond: tuple[tuple[tuple[float, float], ...], ...] = ()
    # Of each pair of parameters by their names, linearised; in the product of their units. None at
    # an active bound, and where the data does not determine it.
    covariance: dict[str, dict[str, float | None]] = field(default_factory=dict)
    dof: int | None = None  # points less parameters
    spread: FitSpread | None = None  # parts of the covariance
    # Errors of predictions at each point [N] by fits without its speed; nan at the ends.
    held_out_n: tuple[float, ...] = ()

    @property
    def correlation(self) -> dict[str, dict[str, float | None]]:
        """Coefficients of correlation of each pair of parameters, -1 to 1 (JCGM 102, 3.21)."""
        variance = {name: row[name] or 0.0 for name, row in self.covariance.items()}
        return {
            a: {
                b: None if value is None or not product else value / math.sqrt(product)
                for b, value in row.items()
                for product in [variance[a] * variance[b]]
            }
            for a, row in self.covariance.items()
        }

    @property
    def covariances(self) -> tuple[ParameterPair, ...]:
        """Covariance and correlation of each pair of parameters, each pair once."""
        correlation = self.correlation
        return tuple(
            ParameterPair(a, b, self.covariance[a][b], correlation[a][b])
            for a, b in combinations_with_replacement(self.covariance, 2)
        )

    @property
    def undetermined(self) -> tuple[str, ...]:
        """Names of the parameters that the data does not determine."""
        return self._which("not determined")

    @property
    def hardly_determined(self) -> tuple[str, ...]:
        """Names of the parameters that the data hardly determines."""
        return self._which("hardly determined")

    def _which(self, determination: Determination) -> tuple[str, ...]:
        return tuple(n for n, p in self.parameters.items() if p.determination == determination)

    @property
    def verdict(self) -> FitVerdict:
        """Verdict on the fit: that of its least determined parameter, if it converged."""
        if not self.parameters:
            return "not determined"  # too few points
        if not self.converged:
            return "not converged"
        if self.undetermined:
            return "not determined"
        return "hardly determined" if self.hardly_determined else "determined"


@dataclass(frozen=True)
class HeldOut:
    """Error of a law at held-out speeds."""

    law: str
    rmse_n: FloatOrNan


@dataclass(frozen=True)
class Selection:
    """Laws by their error at held-out speeds, the best first."""

    laws: tuple[HeldOut, ...]
    difference_n2: FloatOrNan  # mean square error of the second law less that of the first
    difference_se_n2: FloatOrNan  # its standard error
    distinguishable: bool  # whether its 95 % interval is above zero
    speeds: int  # held out, one at a time


@dataclass(frozen=True)
class JointFit:
    """Laws with pressure in them, fitted to all curves of a kind and label at once."""

    kind: KindName
    label: str
    curves: int
    points: int
    fits: tuple[Fit, ...]
    selection: Selection | None  # with the laws that have parameters for each curve
