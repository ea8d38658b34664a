"""Gaps of a model: how far measurement and model deviate, by balance, signal, region and run.

Gaps are in units of the trials' scatter: 1 is the repeatability of the bench. Quantities are SI.
"""

from dataclasses import dataclass, field
from math import sqrt

import numpy as np

from hbench.records.numbers import FloatOrNan
from hbench.records.runs import RunPlan


@dataclass(frozen=True)
class Gap:
    """Gap of one balance or signal, and the part of it beyond scatter."""

    name: str
    gap: FloatOrNan  # 1: the repeatability of the bench
    p_value: FloatOrNan  # after Holm
    scatter: FloatOrNan  # root mean square of s, in the balance's unit
    windows: int
    # Root mean squares in the balance's unit; nan where strokes are compared.
    deviation: FloatOrNan = float("nan")  # structured part, without the noise of single windows
    material: FloatOrNan = float("nan")  # a smaller deviation does not matter
    allowed: FloatOrNan = float("nan")  # that the instruments' tolerances may cause

    @property
    def structured(self) -> FloatOrNan:
        """sqrt(gap^2 - 1), 0 below."""
        return sqrt(max(self.gap**2 - 1, 0.0))


@dataclass(frozen=True)
class Region:
    """A stretch of one axis with the gap of each balance in it, nan where nothing is compared."""

    axis: str  # direction, speed_m_s, load_n, position_m, time_s
    label: str  # of a direction; empty for the others
    low: FloatOrNan  # smallest and largest value in it
    high: FloatOrNan
    windows: int
    gaps: dict[str, FloatOrNan]  # by balance


@dataclass(frozen=True)
class ResidualMap:
    """Residuals of c balances at w windows."""

    names: tuple[str, ...]
    value: np.ndarray  # (w, c) signed, in ``unit``; nan where not compared
    v_m_s: np.ndarray  # (w,) signed
    load_n: np.ndarray  # (w,)
    x_m: np.ndarray  # (w,)
    t_s: np.ndarray  # (w,) since the run's start
    held_out: np.ndarray  # (w,) bool
    unit: str = ""  # empty: the trials' scatter

    @classmethod
    def empty(cls) -> "ResidualMap":
        """Return the map without balances and windows."""
        none = np.zeros(0)
        return cls((), np.zeros((0, 0)), none, none, none, none, none.astype(bool))


@dataclass(frozen=True)
class BeforeAfter:
    """Gap of the model as given, refitted, and revised."""

    before: FloatOrNan  # model as given
    refitted: FloatOrNan  # its poorly known parameters refitted
    after: FloatOrNan  # with the effects
    floor: FloatOrNan  # average of correct models with values as uncertain, from these trials


@dataclass(frozen=True)
class GapTable:
    """Gaps over some runs; the total is the root mean square of the balances'."""

    total: BeforeAfter = BeforeAfter(*[float("nan")] * 4)
    balances: dict[str, BeforeAfter] = field(default_factory=dict)
    signals: dict[str, BeforeAfter] = field(default_factory=dict)  # closed loop
    # Drift of the model under measured commands.
    open_loop: dict[str, BeforeAfter] = field(default_factory=dict)


@dataclass(frozen=True)
class RunGap:
    """Gaps of a single run, with the floors of its operating point."""

    plan: RunPlan
    held_out: bool
    gap: GapTable
