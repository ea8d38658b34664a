"""Notes on imported files; like notes on many files become one, with the range of its numbers."""

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from hbench.sentences import abridged

ROTARY_NOTE = (
    "rotary actuator: in all results 1 m stands for 1 rad, 1 N for 1 N m and an area of 1 m^2 for "
    "1 m^3/rad"
)
_NAMED = 3  # files named in a note on many
_LONGEST = 60  # letters of a name


@dataclass(frozen=True)
class FileNote:
    """A note on one file: a text with names in braces for its numbers."""

    file: str
    text: str
    numbers: Mapping[str, float] = field(default_factory=dict)


def merged(notes: Iterable[FileNote]) -> list[str]:
    """Return the notes as sentences: one for all files with the same text, in their order."""
    groups: dict[str, list[FileNote]] = defaultdict(list)
    for note in notes:
        groups[note.text].append(note)
    return [f"{_files(group)}: {_filled(group)}" for group in groups.values()]


def first_names(names: Iterable[str]) -> str:
    """Return the first of some names of files or sheets, for a message; ``none`` without any."""
    return abridged([name[:_LONGEST] for name in names], _NAMED) or "none"


def _files(group: list[FileNote]) -> str:
    names = list(dict.fromkeys(note.file for note in group))
    return names[0] if len(names) == 1 else f"{len(names)} files ({first_names(names)})"


def _filled(group: list[FileNote]) -> str:
    filled = {}
    for name in group[0].numbers:
        values = [note.numbers[name] for note in group]
        low, high = f"{min(values):.4g}", f"{max(values):.4g}"
        filled[name] = low if low == high else f"{low} to {high}"
    return group[0].text.format_map(filled) if filled else group[0].text
