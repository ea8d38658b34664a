"""Effects that some runs, made or planned, would show and separate from each other."""

from dataclasses import dataclass
from typing import Literal

from hbench.records.numbers import FloatOrNan


@dataclass(frozen=True)
class DetectableSize:
    """Smallest value of an effect's coefficient that some runs would show, in its unit."""

    effect: str
    coefficient: str
    smallest: FloatOrNan  # nan: not detectable at ten times its typical value
    typical: FloatOrNan
    unit: str
    limit: Literal["evidence", "size"]  # what determines it: its score, or the least size named

    @property
    def detectable(self) -> bool:
        """Whether the typical value is detectable."""
        return self.smallest <= self.typical


@dataclass(frozen=True)
class EffectPair:
    """Separation of two effects by some runs."""

    first: str
    second: str
    angle_deg: FloatOrNan  # of their signatures; nan: the runs do not show one of them
    lead: FloatOrNan  # expected lead in score of the true effect in the worst case, nats
    distinguishable: bool | None  # None: neither effect is detectable


@dataclass(frozen=True)
class Separability:
    """Effects that some runs would detect, and the separation of each pair."""

    sizes: tuple[DetectableSize, ...]
    pairs: tuple[EffectPair, ...]


@dataclass(frozen=True)
class PlannedEffects:
    """Effects that planned runs would show, by simulation."""

    separability: Separability
    not_tried: dict[str, str]  # effects that the runs do not show at all, with the reason
    shortfalls: tuple[str, ...]  # for which no effect would be named, whatever its size
    missing: tuple[str, ...]  # experiments that make more effects distinguishable
