"""Types of the records' numbers and texts, and the factor of a normal 95 % interval.

The types are more precise than float, int or str. Python and mypy see the plain type; the JSON
Schemas of the documents follow the marks.
"""

from dataclasses import dataclass
from typing import Annotated

from hbench.records.kinds import KINDS

NORMAL_95 = 1.959964  # half of the interval, in standard deviations


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
