"""Patterns of file names: the numbers for speed, load, pressure and trial."""

import dataclasses
import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from pydantic import ValidationError

from hbench.config.import_map import FIELDS, FileSeries, units_behind
from hbench.store.importing.file_matches import name_pattern
from hbench.store.suggesting.units import unit_in
from hbench.units import parse_unit

_NUMBER = re.compile(r"(?:(?<=[_= ])-)?\d{1,12}(?:[.,]\d{1,12})?")
# A date, perhaps with a time of day, becomes a star.
_DATE = re.compile(
    r"(?<!\d)(19|20)\d\d[-_.]?[01]\d[-_.]?[0-3]\d(?!\d)([-_T ]*\d\d([-_.h]?\d\d){1,2})?"
)
# A unit behind a number, not followed by another letter.
_UNIT = re.compile(
    r"[ _-]?(mm[_-]?s|mmps|cm[_-]?s|m[_-]?s|mps|in[_-]?s|ips|deg[_-]?s|rad[_-]?s|kN|Nm|N|lbf"
    r"|lbs?|MPa|kPa|mbar|bar|psi)"
    r"(?![a-z])",
    re.IGNORECASE,
)
_FIELD_OF = {
    **dict.fromkeys(("mm/s", "cm/s", "m/s", "in/s", "deg/s", "rad/s"), "speed"),
    **dict.fromkeys(("N", "kN", "lbf", "N m"), "load"),
}
# A factor's unit, directly behind a number.
_FACTOR_UNIT = re.compile(r"(mA|A|°C|deg_?C|C|K|Hz|rpm|mm|kg)(?![A-Za-z0-9])")
_FACTORS = {
    **{"mA": ("current", "mA"), "A": ("current", "A"), "Hz": ("frequency", "Hz")},
    **{"mm": ("length", "mm"), "kg": ("mass", "kg")},
    **dict.fromkeys(("°C", "degC", "deg_C", "C"), ("temperature", "°C")),
    **{"K": ("temperature", "K"), "rpm": ("rotation", "rpm")},
}
# Words before a factor without a unit.
_FACTOR_WORDS = {
    "current": re.compile(r"(?<![a-z])(current|strom)[ _=-]?$", re.IGNORECASE),
    "temperature": re.compile(r"(?<![a-z])(temp|temperature|temperatur)[ _=-]?$", re.IGNORECASE),
}
_MOTION = ("length", "frequency")  # together they set the speed, which the position shows
_MOST_VALUES = 12  # of a factor
_DEFAULT_UNITS = {"speed": "mm/s", "load": "N", "pressure": "bar"}
# Words before a number without a unit.
_WORDS = {
    "speed": re.compile(r"(?<![a-z])(v|speed|vel|velocity|geschw)[ _=-]?$", re.IGNORECASE),
    "load": re.compile(
        r"(?<![a-z])(f|load|force|last|kraft|weight|gewicht)[ _=-]?$", re.IGNORECASE
    ),
    "pressure": re.compile(r"(?<![a-z])(p|pressure|druck)[ _=-]?$", re.IGNORECASE),
    "trial": re.compile(
        r"(?<![a-z])(trial|run|rep|repeat|test|take|nr|no|versuch|messung|wdh|wiederholung|lauf)"
        r"[ _=-]?$",
        re.IGNORECASE,
    ),
}
_LONGEST_VALUE = 8  # characters of a number without a unit; longer ones are dates
_LONGEST_TRIAL = 4  # digits; longer numbers are dates or identifiers
_ENDING = re.compile(r"\.[A-Za-z]\w{0,7}$")
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
    units: dict[str, str]  # of its fields
    assumed: tuple[str, ...]  # fields whose unit is not in the names
    label: str
    factors: dict[str, str] = dataclasses.field(
        default_factory=dict
    )  # its other fields, with their units

    def values(self, name: str) -> dict[str, float]:
        """Return the values in SI of the fields with a unit in one of its names."""
        match = name_pattern(_series(self.files, self.factors)).fullmatch(name)
        texts = match.groupdict() if match else {}
        return {
            field: float(texts[field].replace(",", ".")) * parse_unit(unit).factor
            for field, unit in self.units.items()
        }


class _Number(NamedTuple):
    start: int
    stop: int
    text: str
    field: str  # by a unit behind it, otherwise empty
    unit: str


def numbers_of(name: str) -> tuple[str, ...]:
    """Return the numbers in a name, equal for all files of a run."""
    return tuple(_NUMBER.findall(name))


def name_patterns(names: Sequence[str]) -> list[NamePattern]:
    """Return patterns that match each of ``names`` once."""
    groups: dict[str, list[str]] = defaultdict(list)
    for name in names:
        groups[_NUMBER.sub("#", _DATE.sub("*", name))].append(name)
    patterns: list[NamePattern] = []
    for group in groups.values():
        patterns += _patterns(group)
    patterns = list(_with_directions(_with_signs(patterns, names), names))
    alone = []
    for pattern in patterns:
        if set(_matched(pattern, names)) == set(pattern.names):
            alone.append(pattern)
        else:
            alone += map(_literal, pattern.names)
    return _labelled([p for p in alone if _matched(p, p.names)])


def _with_signs(patterns: Sequence[NamePattern], names: Sequence[str]) -> Iterator[NamePattern]:
    """Yield the patterns; those that differ in a minus before a number become one."""
    alike: dict[str, list[NamePattern]] = defaultdict(list)
    for pattern in patterns:
        alike[pattern.files.replace("-{", "{")].append(pattern)
    for files, group in alike.items():
        whole = next((p for p in group if p.files == files), None)
        own = [name for pattern in group for name in pattern.names]
        if whole is not None and len(group) > 1 and set(_matched(whole, names)) == set(own):
            yield replace(whole, names=tuple(sorted(own)))
        else:
            yield from group


def _with_directions(
    patterns: Iterable[NamePattern], names: Sequence[str]
) -> Iterator[NamePattern]:
    """Yield the patterns; two that differ in the word of the direction only become one."""
    left = {pattern.files: pattern for pattern in patterns}
    for files, pattern in list(left.items()):
        for other, starred in _opposites(files):
            whole = replace(pattern, files=starred)
            own = [n for p in (pattern, left.get(other)) if p is not None for n in p.names]
            if {files, other} <= left.keys() and set(_matched(whole, names)) == set(own):
                yield replace(whole, names=tuple(sorted(own)))
                del left[files], left[other]
                break
    yield from left.values()


def _opposites(files: str) -> Iterator[tuple[str, str]]:
    """Yield ``files`` with a direction's word replaced by that of the other, and by a star."""
    for word in _WORD.finditer(_ENDING.sub("", files)):
        for pair in _DIRECTIONS:
            if word[0].lower() in pair:
                other = pair[1 - pair.index(word[0].lower())]
                other = other.upper() if word[0].isupper() else other
                other = other.capitalize() if word[0].istitle() else other
                head, tail = files[: word.start()], files[word.end() :]
                yield f"{head}{other}{tail}", f"{head}*{tail}"


def _matched(pattern: NamePattern, names: Sequence[str]) -> list[str]:
    """Return the names that a pattern matches; none for braces of other meaning."""
    try:
        series = _series(pattern.files, pattern.factors)
    except ValidationError:
        return []
    return list(filter(name_pattern(series).fullmatch, names))


def _series(files: str, factors: Mapping[str, str]) -> FileSeries:
    """Return a series of ``files`` with the units behind its fields. Raises ``ValueError``."""
    units = {f"{name}_unit": unit for name, unit in units_behind(files)}
    given = {"label": "", "files": files, "factors": dict(factors), **units}
    return FileSeries.model_validate(given)


def _literal(name: str) -> NamePattern:
    return NamePattern(name, (name,), {}, (), "")


def _patterns(names: list[str]) -> Iterator[NamePattern]:
    """Yield the patterns of names that differ in numbers only."""
    numbers = {name: list(_numbers(name)) for name in names}
    varied = [len({n.text for n in column}) > 1 for column in zip(*numbers.values(), strict=True)]
    fields = _fields(names[0], numbers[names[0]], varied, list(numbers.values()))
    motion = [i for i, (field, _) in fields.items() if field in _MOTION]
    motion = motion if len(motion) == len(_MOTION) else []
    fields = {i: field for i, field in fields.items() if i not in motion}
    by_files: dict[str, list[str]] = defaultdict(list)
    for name, found in numbers.items():
        stars = [
            i
            for i, number in enumerate(found)
            if i not in fields
            and varied[i]
            and (
                i in motion
                or len(number.text) > _LONGEST_TRIAL
                or _counts_from_zero(numbers.values(), i)
            )
        ]
        by_files[_with_fields(name, found, fields, stars)].append(name)
    factors = {field: unit for field, unit in fields.values() if field not in FIELDS}
    units = {f: unit for f, unit in fields.values() if f != "trial" and f not in factors}
    assumed = tuple(f for f, u in units.items() if not u)
    units = {field: unit or _DEFAULT_UNITS[field] for field, unit in units.items()}
    for files, matched in by_files.items():
        yield NamePattern(files, tuple(matched), units, assumed, "", factors)


def _numbers(name: str) -> Iterator[_Number]:
    """Yield the numbers of a name, and its dates as one number each."""
    end = _ENDING.search(name)
    stop = end.start() if end else len(name)
    dates = list(_DATE.finditer(name, 0, stop))
    for match in sorted((*dates, *_NUMBER.finditer(name, 0, stop)), key=lambda m: m.start()):
        inside = any(d.start() <= match.start() < d.end() for d in dates if d is not match)
        if inside:
            continue
        behind = None if match in dates else _UNIT.match(name, match.end())
        unit = unit_in(behind[1].replace("-", "_")) if behind else None
        field = _FIELD_OF.get(unit, "pressure") if unit else ""
        text = match[0] if field == "load" else match[0].removeprefix("-")
        yield _Number(match.end() - len(text), match.end(), text, field, unit or "")


def _fields(
    name: str, numbers: list[_Number], varied: list[bool], rows: list[list[_Number]]
) -> dict[int, tuple[str, str]]:
    """Return field and unit of the numbers that are one, by their position in the name."""
    fields: dict[int, tuple[str, str]] = {}

    def free(field: str) -> bool:
        return all(field != taken for taken, _ in fields.values())

    for i, number in enumerate(numbers):
        if number.field and free(number.field):
            fields[i] = number.field, number.unit
    for i, number in enumerate(numbers):
        for field in ("speed", "load", "pressure"):
            is_plain = not number.field and len(number.text) <= _LONGEST_VALUE
            is_plain = is_plain and not _FACTOR_UNIT.match(name, number.stop)
            if i not in fields and varied[i] and is_plain and free(field):
                if _WORDS[field].search(name[: number.start]):
                    fields[i] = field, ""
    for i, number in enumerate(numbers):
        if i not in fields and varied[i] and len({row[i].text for row in rows}) <= _MOST_VALUES:
            factor = _factor(name, number)
            if factor is not None and free(factor[0]):
                fields[i] = factor
    rest = [i for i in range(len(numbers)) if i not in fields and _is_trial(rows, i)]
    worded = [i for i in rest if _WORDS["trial"].search(name[: numbers[i].start])]
    at_end = [i for i in rest if not name[numbers[i].stop :].strip("_- ").lstrip(".").isalpha()]
    several = [i for i in rest if varied[i]]
    last = [i for i in rest if _ENDING.fullmatch(name[numbers[i].stop :])]
    for choice in (
        [i for i in worded if varied[i] or len(rows) == 1],
        [i for i in last if varied[i]],
        several if len(several) == 1 else [],
        [i for i in last if len(rows) == 1 and i not in at_end and len(numbers[i].text) < 3],
    ):
        if choice:
            fields[choice[-1]] = "trial", ""
            break
    return fields


def _factor(name: str, number: _Number) -> tuple[str, str] | None:
    """Return the name and unit of the factor that a number is, or None."""
    if behind := _FACTOR_UNIT.match(name, number.stop):
        return _FACTORS[behind[1]]
    before = name[: number.start]
    found = (factor for factor, word in _FACTOR_WORDS.items() if word.search(before))
    factor = None if number.field or len(number.text) > _LONGEST_VALUE else next(found, None)
    return None if factor is None else (factor, "")


def _is_trial(rows: list[list[_Number]], i: int) -> bool:
    """Return whether the numbers at position ``i`` of all names can be numbers of trials."""
    texts = [row[i].text for row in rows]
    return all(t.isdecimal() and len(t) <= _LONGEST_TRIAL and int(t) > 0 for t in texts)


def _counts_from_zero(rows: Iterable[list[_Number]], i: int) -> bool:
    """Return whether the numbers at position ``i`` count all names, beginning with 0."""
    texts = [row[i].text for row in rows]
    return all(map(str.isdecimal, texts)) and sorted(map(int, texts)) == list(range(len(texts)))


def _with_fields(
    name: str, numbers: list[_Number], fields: dict[int, tuple[str, str]], stars: list[int]
) -> str:
    files, end = "", 0
    for i in sorted((*fields, *stars)):
        files += name[end : numbers[i].start] + (f"{{{fields[i][0]}}}" if i in fields else "*")
        end = numbers[i].stop
    return files + name[end:]


def _labelled(patterns: list[NamePattern]) -> list[NamePattern]:
    """Give each pattern a label of its own: the words of its names, with folders if necessary."""
    short = [_label(p.files.rpartition("/")[2]) for p in patterns]
    long = [_label(p.files) for p in patterns]
    labels = [s if short.count(s) == 1 and s else w for s, w in zip(short, long, strict=True)]
    return [replace(p, label=label) for p, label in zip(patterns, labels, strict=True)]


def _label(files: str) -> str:
    text = _ENDING.sub("", files)
    text = re.sub(rf"\{{({'|'.join(FIELDS)})\}}({_UNIT.pattern})?", "\0", text, flags=re.IGNORECASE)
    text = re.sub(rf"\{{[a-z]+\}}({_FACTOR_UNIT.pattern})?", "\0", text)
    text = re.sub(rf"((?<![A-Za-z])[A-Za-z])?\*{_FACTOR_UNIT.pattern}", "\0", text)
    for pattern in (*_WORDS.values(), *_FACTOR_WORDS.values()):
        text = re.sub(rf"{pattern.pattern[:-1]}\0", "\0", text, flags=re.IGNORECASE)
    return " ".join(re.sub(r"[\0_/* ]+", " ", text).split()).strip(" -.=#")
