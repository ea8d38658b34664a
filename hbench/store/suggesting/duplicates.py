"""Columns that a suggested map leaves out since another one of the same channel is chosen."""

import re
from collections.abc import Mapping, Sequence

from hbench.store.suggesting.choice import Choice
from hbench.store.suggesting.quantities import words_of
from hbench.store.suggesting.samples import SampleColumn

_FILTERED = re.compile(
    r"\b(filtered|filt|filter|gefiltert|smooth|smoothed|geglaettet|tiefpass|lowpass|lp)\b"
)
_RAW = re.compile(r"\b(raw|roh|unfiltered|ungefiltert)\b")


def duplicates(
    columns: Sequence[SampleColumn], choices: Mapping[str, Choice]
) -> dict[str, tuple[str, ...]]:
    """Return the names of the filtered and raw columns of each chosen channel that are left out.

    They are the columns whose names are equal but for words such as ``filt`` and ``raw``. Columns
    with equal words otherwise, such as those of a matrix, are other signals.
    """
    chosen = {choice.column.key for choice in choices.values()}
    left_out = {}
    for channel, choice in choices.items():
        bare = _bare(choice.column)
        names = [
            f"{column.name} ({_kind(column)})"
            for column in columns
            if column.key not in chosen
            and bare
            and _bare(column) == bare
            and _kind(column) != _kind(choice.column)
        ]
        if names:
            left_out[channel] = tuple(names)
    return left_out


def _bare(column: SampleColumn) -> str:
    """Return the words of a column's name without those of a filter and without its unit."""
    words = words_of(re.sub(r"\s*[\[({][^\[\](){}]*[\])}]\s*$", "", column.name))
    return " ".join(_RAW.sub(" ", _FILTERED.sub(" ", words)).split())


def _kind(column: SampleColumn) -> str:
    words = words_of(column.name)
    if _RAW.search(words):
        return "raw"
    return "filtered" if _FILTERED.search(words) else "not filtered"
