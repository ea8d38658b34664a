"""Types of the records' numbers and texts, and fitted numbers with their 95 % intervals.

The types are more precise than float, int or str. Python and mypy see the plain type; the JSON
Schemas of the documents follow the marks.
"""

from dataclasses import dataclass, field
from typing import Annotated, Literal

from hbench.records.kinds import KINDS

NORMAL_95 = 1.959964  # half of a normal 95 % interval, in standard deviations
SIGNIFICANCE = 0.05  # level of tests: p below it, corrected for their number, is significant


@dataclass(frozen=True)
class Nonfinite:
    """Mark of a float that may be NaN or infinite, which JSON writes as null."""


@dataclass(frozen=True)
class Minimum:
    """Mark of a number that is not smaller than ``value``."""

    value: int


@dataclass(frozen=True)
class OneOf:
    """Mark of a text that is one of ``values``."""

    values: tuple[str, ...]


FloatOrNan = Annotated[float, Nonfinite()]
Count = Annotated[int, Minimum(1)]  # from 1
KindName = Annotated[str, OneOf(tuple(KINDS))]  # of experiment

Determination = Literal["determined", "hardly determined", "not determined"]


@dataclass(frozen=True)
class FitParameter:
    """One fitted number. ``se`` and ``ci95`` are None where the data does not determine it.

    At an active bound there is no standard error, and ``ci95`` begins or ends at the bound.
    """

    value: float
    se: float | None
    ci95: tuple[FloatOrNan, FloatOrNan] | None
    at_bound: Literal["lower", "upper"] | None
    unit: str
    # 95 % intervals by method: linearised, profile (which ``ci95`` is), bootstrap if asked for.
    intervals: dict[str, tuple[FloatOrNan, FloatOrNan] | None] = field(default_factory=dict)
    disagree: bool = False  # whether these differ by much
    # Half of ci95 exceeds a tenth of the typical size, and the value, or a bound cuts ci95 off.
    wide: bool = False
    # Mean error of the estimate by the law's curvature; not corrected. None without a ``se``.
    bias: float | None = None

    @property
    def determination(self) -> Determination:
        """How well the data determines the parameter.

        Not: it is at a bound, has no interval, or ``wide``. Hardly: its interval contains 0 or has
        a half-width of more than half of the value.
        """
        if self.at_bound is not None or self.ci95 is None or self.wide:
            return "not determined"
        low, high = self.ci95
        hardly = low <= 0.0 <= high or high - low > abs(self.value)
        return "hardly determined" if hardly else "determined"


@dataclass(frozen=True)
class ParameterPair:
    """Covariance of two fitted parameters; of a parameter with itself, its variance."""

    parameter: str
    with_parameter: str
    covariance: float | None  # in the product of their units; None: not determined, or at a bound
    correlation: float | None  # -1 to 1
