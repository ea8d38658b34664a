"""Fields of the numbers in file names: speed, load, pressure, trial, or a factor.

The unit behind a number or the word before it shows the field; a trial's number may stand alone.
"""

import re
from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from hbench.config.import_map import FIELDS
from hbench.units import parse_unit, unit_in

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
_MOST_VALUES = 12  # of a factor
# Words before a number without a unit.
_WORDS = {
    "speed": re.compile(r"(?<![a-z])(v|speed|vel|velocity|geschw)[ _=-]?$", re.IGNORECASE),
    "load": re.compile(
        r"(?<![a-z])(f|load|force|last|kraft|weight|gewicht)[ _=-]?$", re.IGNORECASE
    ),
    "pressure": re.compile(r"(?<![a-z])(p|pressure|druck)[ _=-]?$", re.IGNORECASE),
    "trial": re.compile(
        r"(?<![a-z])(trial|run|rep|repeat|test|take|nr|no|versuch|messung|wdh|wiederholung|lauf)"
        r"[ _=.-]{0,2}#?$",
        re.IGNORECASE,
    ),
}
_IS_NUMBER = re.compile(r"\d+(\.\d+)?")  # and no date
_LONGEST_VALUE = 8  # characters of a number without a unit; longer ones are dates
_LONGEST_TRIAL = 4  # digits; longer numbers are dates or identifiers
_ENDING = re.compile(r"\.[A-Za-z]\w{0,7}$")


_SPEED_UNITS = ("mm/s", "m/s", "cm/s", "in/s")  # of a number that is the measured speed
_NEAR_SPEED = 0.05  # of it

MeasuredSpeeds = Mapping[str, Sequence[float]]  # sizes of the constant speeds in some files, m/s


class NameNumber(NamedTuple):
    """A number, or a date, in a file name."""

    start: int  # its characters in the name
    stop: int
    text: str
    field: str  # by a unit behind it, otherwise empty
    unit: str


class Field(NamedTuple):
    """What a number in a file name is."""

    name: str  # speed, load, pressure, trial, or a factor
    unit: str  # empty: not in the name


@dataclass(frozen=True)
class SimilarNames:
    """File names that differ in numbers only, with the m numbers of each."""

    numbers: Mapping[str, Sequence[NameNumber]]

    @classmethod
    def of(cls, names: Sequence[str]) -> "SimilarNames":
        """Find the numbers of ``names``."""
        return cls({name: list(numbers_in(name)) for name in names})

    @property
    def first(self) -> tuple[str, Sequence[NameNumber]]:
        """The first name with its numbers, as an example of all."""
        return next(iter(self.numbers.items()))

    def texts(self, i: int) -> list[str]:
        """Return the number at position i of each name, as it is written."""
        return [numbers[i].text for numbers in self.numbers.values()]

    def varies(self, i: int) -> bool:
        """Return whether the numbers at position i differ."""
        return len(set(self.texts(i))) > 1

    def counts_from_zero(self, i: int) -> bool:
        """Return whether the numbers at position i count the names, beginning with 0."""
        texts = self.texts(i)
        return all(map(str.isdecimal, texts)) and sorted(map(int, texts)) == list(range(len(texts)))


def numbers_of(name: str) -> tuple[str, ...]:
    """Return the numbers in a name, equal for all files of a run."""
    return tuple(_NUMBER.findall(name))


def without_numbers(name: str) -> str:
    """Return a name with a mark in place of each date and each number."""
    return _NUMBER.sub("#", _DATE.sub("*", name))


def words_of(files: str) -> str:
    """Return the words of a pattern without its fields, with their units and words, and stars."""
    text = _ENDING.sub("", files)
    text = re.sub(rf"\{{({'|'.join(FIELDS)})\}}({_UNIT.pattern})?", "\0", text, flags=re.IGNORECASE)
    text = re.sub(rf"\{{[a-z]+\}}({_FACTOR_UNIT.pattern})?", "\0", text)
    text = re.sub(rf"((?<![A-Za-z])[A-Za-z])?\*{_FACTOR_UNIT.pattern}", "\0", text)
    text = re.sub(rf"\*{_UNIT.pattern}", "\0", text, flags=re.IGNORECASE)
    for pattern in (*_WORDS.values(), *_FACTOR_WORDS.values()):
        text = re.sub(rf"{pattern.pattern[:-1]}\0", "\0", text, flags=re.IGNORECASE)
    return " ".join(re.sub(r"[\0_/* ]+", " ", text).split()).strip(" -.=#")


def without_ending(files: str) -> str:
    """Return a name without the ending of its format."""
    return _ENDING.sub("", files)


def is_long(text: str) -> bool:
    """Return whether a number is too long for that of a trial: a date or an identifier."""
    return len(text) > _LONGEST_TRIAL


def numbers_in(name: str) -> Iterator[NameNumber]:
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
        yield NameNumber(match.end() - len(text), match.end(), text, field, unit or "")


def number_fields(similar: SimilarNames, speeds_m_s: MeasuredSpeeds) -> dict[int, Field]:
    """Return the fields of the numbers that are one, by their position in the name.

    A unit is more certain than a measured speed, this more than a word, and all more than the place
    of a trial. No two numbers are the same field: the first counts.
    """
    fields: dict[int, Field] = {}
    for i, field in (
        *_by_units(similar),
        *_by_motion(similar, speeds_m_s),
        *_by_words(similar),
        *_factors(similar),
    ):
        if i not in fields and all(field.name != taken.name for taken in fields.values()):
            fields[i] = field
    trial = _trial(similar, fields)
    return fields if trial is None else {**fields, trial: Field("trial", "")}


def _by_units(similar: SimilarNames) -> Iterator[tuple[int, Field]]:
    _, numbers = similar.first
    for i, number in enumerate(numbers):
        if number.field:
            yield i, Field(number.field, number.unit)


def _by_words(similar: SimilarNames) -> Iterator[tuple[int, Field]]:
    name, numbers = similar.first
    for i, number in enumerate(numbers):
        has_unit = number.field or _FACTOR_UNIT.match(name, number.stop)
        if has_unit or len(number.text) > _LONGEST_VALUE or not similar.varies(i):
            continue
        for field in ("speed", "load", "pressure"):
            if _WORDS[field].search(name[: number.start]):
                yield i, Field(field, "")


def _by_motion(similar: SimilarNames, speeds_m_s: MeasuredSpeeds) -> Iterator[tuple[int, Field]]:
    """Yield the numbers that are a constant speed of each file in some unit, of several speeds.

    Numbers whose speeds are all in every file do not distinguish the files: they count something.
    """
    known = [name for name in similar.numbers if speeds_m_s.get(name)]
    for i in range(len(similar.first[1])):
        texts = [similar.numbers[name][i].text.replace(",", ".") for name in known]
        if len(set(texts)) < 2 or not all(_IS_NUMBER.fullmatch(text) for text in texts):
            continue
        for unit in _SPEED_UNITS:
            values = [float(text) * parse_unit(unit).factor for text in texts]
            if not all(_has(speeds_m_s[name], v) for name, v in zip(known, values, strict=True)):
                continue
            if not all(_has(speeds_m_s[name], v) for name in known for v in values):
                yield i, Field("speed", unit)


def _has(speeds_m_s: Sequence[float], v_m_s: float) -> bool:
    return any(abs(speed - v_m_s) < _NEAR_SPEED * v_m_s for speed in speeds_m_s)


def _factors(similar: SimilarNames) -> Iterator[tuple[int, Field]]:
    """Yield the numbers with a factor's unit or word that have few values."""
    name, numbers = similar.first
    for i, number in enumerate(numbers):
        if similar.varies(i) and len(set(similar.texts(i))) <= _MOST_VALUES:
            factor = _factor(name, number)
            if factor is not None:
                yield i, factor


def _factor(name: str, number: NameNumber) -> Field | None:
    if behind := _FACTOR_UNIT.match(name, number.stop):
        return Field(*_FACTORS[behind[1]])
    if number.field or len(number.text) > _LONGEST_VALUE:
        return None
    before = name[: number.start]
    worded = (factor for factor, word in _FACTOR_WORDS.items() if word.search(before))
    factor = next(worded, None)
    return None if factor is None else Field(factor, "")


def _trial(similar: SimilarNames, taken: Container[int]) -> int | None:
    """Return the position of the trial's number, or None.

    It is the last one behind a word for it; else the one that ends the name and differs from name
    to name; else the only other one that differs. In a single name, one or two digits at the end
    are a trial's.
    """
    name, numbers = similar.first
    single = len(similar.numbers) == 1
    possible = [i for i in range(len(numbers)) if i not in taken and _is_trial(similar.texts(i))]
    varied = [i for i in possible if similar.varies(i)]
    worded = [i for i in possible if _WORDS["trial"].search(name[: numbers[i].start])]
    last = [i for i in possible if _ENDING.fullmatch(name[numbers[i].stop :])]
    for choice in (
        worded if single else [i for i in worded if i in varied],
        [i for i in last if i in varied],
        varied if len(varied) == 1 else [],
        [i for i in last if single and _is_short(name, numbers[i])],
    ):
        if choice:
            return choice[-1]
    return None


def _is_trial(texts: Sequence[str]) -> bool:
    """Return whether numbers can be those of trials."""
    return all(t.isdecimal() and not is_long(t) and int(t) > 0 for t in texts)


def _is_short(name: str, number: NameNumber) -> bool:
    """Return whether a number has one or two digits, and only letters follow its point."""
    return len(number.text) < 3 and name[number.stop :].removeprefix(".").isalpha()
