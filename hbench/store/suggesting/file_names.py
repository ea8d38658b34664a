"""Patterns of file names, with fields for speed, load, pressure, trial and factors."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from pydantic import ValidationError

from hbench.config.import_map import FIELDS, FileSeries, units_behind
from hbench.store.importing.file_matches import name_pattern
from hbench.store.suggesting.name_fields import (
    Field,
    MeasuredSpeeds,
    NameNumber,
    SimilarNames,
    is_long,
    number_fields,
    numbers_in,
    without_ending,
    without_numbers,
    words_of,
)
from hbench.units import parse_unit

_MOTION = {"length", "frequency"}  # together they set the speed, which the position shows
_DEFAULT_UNITS = {"speed": "mm/s", "load": "N", "pressure": "bar"}
# Words of the two directions. The motion shows the direction of each run.
_DIRECTIONS = (
    ("up", "down"), ("up", "dn"), ("auf", "ab"), ("aus", "ein"), ("ausfahren", "einfahren"),
    ("out", "in"), ("ext", "ret"), ("extend", "retract"), ("extending", "retracting"),
    ("fwd", "rev"), ("fwd", "bwd"), ("forward", "backward"), ("vor", "zurück"), ("pos", "neg"),
    ("cw", "ccw"),
)  # fmt: skip
_WORD = re.compile(r"(?<![^\W\d_])[^\W\d_]+(?![^\W\d_]|\})")


@dataclass(frozen=True, eq=False)
class NamePattern:
    """Names that differ in the values of fields only."""

    files: str  # with fields in braces
    names: tuple[str, ...]
    units: dict[str, str] = field(default_factory=dict)  # of speed, load and pressure
    assumed: tuple[str, ...] = ()  # fields whose unit is not in the names
    label: str = ""
    factors: dict[str, str] = field(default_factory=dict)  # its other fields, with their units

    def values(self, name: str) -> dict[str, float]:
        """Return the values in SI of the fields with a unit in one of its names."""
        match = name_pattern(_series(self.files, self.factors)).fullmatch(name)
        texts = match.groupdict() if match else {}
        return {
            key: float(texts[key].replace(",", ".")) * parse_unit(unit).factor
            for key, unit in self.units.items()
        }

    def matching(self, names: Iterable[str]) -> list[str]:
        """Return the names that it matches; none for braces of other meaning."""
        try:
            series = _series(self.files, self.factors)
        except ValidationError:
            return []
        return list(filter(name_pattern(series).fullmatch, names))


def name_patterns(
    names: Sequence[str], speeds_m_s: MeasuredSpeeds | None = None
) -> list[NamePattern]:
    """Return patterns that match each of ``names`` once.

    A number without a unit is a speed if it is the measured one in each file of ``speeds_m_s``.
    """
    similar: dict[str, list[str]] = defaultdict(list)
    for name in names:
        similar[without_numbers(name)].append(name)
    patterns = [
        pattern for group in similar.values() for pattern in _patterns(group, speeds_m_s or {})
    ]
    patterns = list(_with_directions(_with_signs(patterns, names), names))
    exact: list[NamePattern] = []
    for pattern in patterns:
        if set(pattern.matching(names)) == set(pattern.names):
            exact.append(pattern)
        else:  # it matches names of another pattern too
            exact += [NamePattern(name, (name,)) for name in pattern.names]
    return _labelled([p for p in exact if p.matching(p.names)])


def joined_holds(patterns: Sequence[NamePattern], names: Sequence[str]) -> list[NamePattern]:
    """Return patterns of holds; those that differ in a second pressure only become one.

    The holds of a cylinder at several pressures determine its leaks together.
    """
    by_files: dict[str, list[NamePattern]] = defaultdict(list)
    for pattern in patterns:
        files = pattern.files
        for number in reversed(list(numbers_in(files))):
            if number.field == "pressure":
                files = f"{files[: number.start]}*{files[number.stop :]}"
        by_files[files].append(pattern)
    joined: list[NamePattern] = []
    for files, group in by_files.items():
        one = _merged(replace(group[0], files=files), group, names) if len(group) > 1 else None
        joined += group if one is None else [one]
    return _labelled(joined)


def with_speeds(
    patterns: Sequence[NamePattern], names: Sequence[str], speeds_m_s: MeasuredSpeeds
) -> list[NamePattern]:
    """Return patterns of the same files, with fields for numbers that are the measured speeds."""
    found = name_patterns(sorted(n for pattern in patterns for n in pattern.names), speeds_m_s)
    is_exact = all(set(pattern.matching(names)) == set(pattern.names) for pattern in found)
    return found if is_exact else list(patterns)


def _patterns(names: Sequence[str], speeds_m_s: MeasuredSpeeds) -> Iterator[NamePattern]:
    """Yield the patterns of names that differ in numbers only."""
    similar = SimilarNames.of(names)
    fields = number_fields(similar, speeds_m_s)
    motion = {i for i, field in fields.items() if field.name in _MOTION}
    if len(motion) == len(_MOTION):
        fields = {i: field for i, field in fields.items() if i not in motion}
    else:
        motion = set()
    _, example = similar.first
    others = [i for i in range(len(example)) if i not in fields and similar.varies(i)]
    counters = [i for i in others if i in motion or similar.counts_from_zero(i)]
    by_files: dict[str, list[str]] = defaultdict(list)
    for name, numbers in similar.numbers.items():
        stars = [i for i in others if i in counters or is_long(numbers[i].text)]
        by_files[_with_fields(name, numbers, fields, stars)].append(name)
    units = {f.name: f.unit for f in fields.values() if f.name in _DEFAULT_UNITS}
    factors = {f.name: f.unit for f in fields.values() if f.name not in FIELDS}
    assumed = tuple(f.name for i, f in fields.items() if f.name in units and not example[i].unit)
    units = {name: unit or _DEFAULT_UNITS[name] for name, unit in units.items()}
    for files, matched in by_files.items():
        yield NamePattern(files, tuple(matched), units, assumed, "", factors)


def _with_fields(
    name: str, numbers: Sequence[NameNumber], fields: Mapping[int, Field], stars: Iterable[int]
) -> str:
    """Return a name with fields and stars in place of its numbers at these positions."""
    files, end = "", 0
    for i in sorted((*fields, *stars)):
        mark = f"{{{fields[i].name}}}" if i in fields else "*"
        files += name[end : numbers[i].start] + mark
        end = numbers[i].stop
    return files + name[end:]


def _with_signs(patterns: Iterable[NamePattern], names: Sequence[str]) -> Iterator[NamePattern]:
    """Yield the patterns; those that differ in a minus before a number become one."""
    by_files: dict[str, list[NamePattern]] = defaultdict(list)
    for pattern in patterns:
        by_files[pattern.files.replace("-{", "{")].append(pattern)
    for files, group in by_files.items():
        unsigned = next((p for p in group if p.files == files), None)
        merged = None if unsigned is None or len(group) == 1 else _merged(unsigned, group, names)
        yield from group if merged is None else [merged]


def _with_directions(
    patterns: Iterable[NamePattern], names: Sequence[str]
) -> Iterator[NamePattern]:
    """Yield the patterns; two that differ in the word of the direction only become one."""
    single = {pattern.files: pattern for pattern in patterns}
    for files in list(single):
        for opposite, starred in _opposites(files):
            if files not in single or opposite not in single:
                continue
            pair = single[files], single[opposite]
            merged = _merged(replace(pair[0], files=starred), pair, names)
            if merged is not None:
                yield merged
                del single[files], single[opposite]
                break
    yield from single.values()


def _merged(
    pattern: NamePattern, group: Iterable[NamePattern], names: Sequence[str]
) -> NamePattern | None:
    """Return a pattern for the names of a group; None if it does not match just these."""
    merged = sorted(name for each in group for name in each.names)
    is_exact = set(pattern.matching(names)) == set(merged)
    return replace(pattern, names=tuple(merged)) if is_exact else None


def _opposites(files: str) -> Iterator[tuple[str, str]]:
    """Yield ``files`` with a direction's word replaced by that of the other, and by a star."""
    for word in _WORD.finditer(without_ending(files)):
        for pair in _DIRECTIONS:
            if word[0].lower() in pair:
                other = pair[1 - pair.index(word[0].lower())]
                other = other.upper() if word[0].isupper() else other
                other = other.capitalize() if word[0].istitle() else other
                head, tail = files[: word.start()], files[word.end() :]
                yield f"{head}{other}{tail}", f"{head}*{tail}"


def _series(files: str, factors: Mapping[str, str]) -> FileSeries:
    """Return a series of ``files`` with the units behind its fields. Raises ``ValueError``."""
    units = {f"{name}_unit": unit for name, unit in units_behind(files)}
    given = {"label": "", "files": files, "factors": dict(factors), **units}
    return FileSeries.model_validate(given)


def _labelled(patterns: list[NamePattern]) -> list[NamePattern]:
    """Give each pattern a label of its own: the words of its names, with folders if necessary."""
    short = [words_of(p.files.rpartition("/")[2]) for p in patterns]
    long = [words_of(p.files) for p in patterns]
    labels = [s if short.count(s) == 1 and s else w for s, w in zip(short, long, strict=True)]
    return [replace(p, label=label) for p, label in zip(patterns, labels, strict=True)]
