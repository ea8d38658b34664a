"""Steps of a search for missing effects, and its result."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field

from hbench.reconcile.learned.table import LawFound
from hbench.reconcile.linearised import LinearisedModel
from hbench.reconcile.search.candidates import EvaluatedCandidate
from hbench.records import Candidate


@dataclass(frozen=True)
class SearchStep:
    """Step of the search: evaluated candidates, best first, and the effect that was added."""

    before: LinearisedModel
    evaluated: tuple[EvaluatedCandidate, ...]
    added: str | None
    ambiguous: tuple[Candidate, ...]  # where none was added
    dropped: tuple[str, ...] = ()  # earlier effects that the added one makes superfluous

    @property
    def added_size(self) -> float:
        """The size of the effect that was added, in typical sizes; 0 where none was."""
        sizes = {each.candidate.name: each.candidate.size for each in self.evaluated}
        return sizes[self.added] if self.added else 0.0


@dataclass(frozen=True)
class Unconfirmed:
    """Model with an effect that does not reduce the gap of held-out runs, and all its effects."""

    model: LinearisedModel
    effects: tuple[str, ...]


@dataclass(frozen=True)
class SmallEffects:
    """Model with effects that are too small to be named, and the steps that added them."""

    model: LinearisedModel
    steps: tuple[SearchStep, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """The effects, in order."""
        return added_names(self.steps)


@dataclass(frozen=True)
class SearchResult:
    """Given and refitted model, steps of the search, and final model."""

    given: LinearisedModel
    refitted: LinearisedModel
    steps: tuple[SearchStep, ...]
    final: LinearisedModel
    refused: str = ""  # why the refit is refused; the refitted model is then the given one
    laws: tuple[LawFound, ...] = ()  # learned, in the final model
    unlearned: LinearisedModel | None = None  # the final model without them; None: it has none
    unconfirmed: Mapping[str, Unconfirmed] = field(default_factory=dict)  # not in the final model
    ruled_out: Mapping[str, str] = field(default_factory=dict)  # added, then not named: why
    small: SmallEffects | None = None  # not in the final model; with them it has no gap

    @property
    def names(self) -> tuple[str, ...]:
        """The effects that were added and not dropped, in order."""
        return added_names(self.steps, self.ruled_out)

    @property
    def additions(self) -> tuple[SearchStep, ...]:
        """The steps that added the named effects; the last one of an effect that was dropped."""
        last = {step.added: step for step in self.steps}
        return tuple(last[name] for name in self.names)

    @property
    def confirmed(self) -> tuple[str, ...]:
        """The effects of the final model."""
        return tuple(name for name in self.names if name not in self.unconfirmed)

    @property
    def without_laws(self) -> LinearisedModel:
        """The final model without learned laws."""
        return self.unlearned or self.final

    @property
    def with_small(self) -> LinearisedModel:
        """The model with all effects that were found, also the small ones, without learned laws."""
        return self.small.model if self.small else self.without_laws

    @property
    def unchanged(self) -> bool:
        """Whether the final model is the given one: the refit is refused and nothing is added."""
        return bool(self.refused) and not self.confirmed and not self.laws


def added_names(
    steps: Sequence[SearchStep], ruled_out: Collection[str] = frozenset()
) -> tuple[str, ...]:
    """Return the effects that the steps add and do not drop, in order, but those ``ruled_out``."""
    dropped = {name: i for i, step in enumerate(steps) for name in step.dropped}
    return tuple(
        step.added
        for i, step in enumerate(steps)
        if step.added and i >= dropped.get(step.added, 0) and step.added not in ruled_out
    )
