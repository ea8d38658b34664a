"""What else was varied from file to file: a column, such as a temperature, that has few values."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hbench.store.suggesting.quantities import words_of
from hbench.store.suggesting.samples import SampleColumn

# Of the words of a column's name.
_WORDS = {
    "temperature": re.compile(r"\b(temp|temperature|temperatur)\b"),
    "current": re.compile(r"\b(current|strom)\b"),
    "frequency": re.compile(r"\b(frequency|freq|frequenz)\b"),
    "humidity": re.compile(r"\b(humidity|feuchte)\b"),
}
_UNIT = re.compile(r"[\[({]\s*([^\[\](){}]{1,10}?)\s*[\])}]\s*$")
_MOST_VALUES = 6
_SPREADS = 6.0  # standard deviations within a file: a larger difference is another value
_SAME = 0.02  # of the largest value: a smaller difference is none


@dataclass(frozen=True)
class ColumnFactor:
    """A quantity that is nearly constant in a file and has few values in all files."""

    name: str  # of the factor in a map
    column: str  # its name in the files
    unit: str  # as it is written there
    values: tuple[float, ...]  # of each file, rounded

    def text(self, value: float) -> str:
        """Return a value with its unit."""
        return f"{value:g} {self.unit}".rstrip()


def column_factors(
    columns: Sequence[SampleColumn], units: Mapping[int | str, str]
) -> tuple[ColumnFactor, ...]:
    """Return the factors among ``columns``, one of each name.

    ``units`` are those that the files state beside the names.
    """
    found: dict[str, ColumnFactor] = {}
    for column in columns:
        words = words_of(column.name)
        name = next((name for name, pattern in _WORDS.items() if pattern.search(words)), "")
        if not name or name in found or column.is_date_time:
            continue
        values = _values(column.values)
        if values is not None:
            bracket = _UNIT.search(column.name)
            unit = units.get(column.key) or (bracket[1] if bracket else "")
            found[name] = ColumnFactor(name, column.name, unit, values)
    return tuple(found.values())


def _values(files: Sequence[np.ndarray]) -> tuple[float, ...] | None:
    """Return the value of each file, if there are few; None otherwise."""
    known = [y[np.isfinite(y)] for y in files]
    if not all(map(len, known)):
        return None
    medians = np.array([np.median(y) for y in known])
    spread = max(float(np.std(y)) for y in known)
    least = max(_SPREADS * spread, _SAME * float(np.abs(medians).max()))
    order = np.argsort(medians)
    groups = np.split(order, np.flatnonzero(np.diff(medians[order]) > least) + 1)
    if not 2 <= len(groups) <= _MOST_VALUES:
        return None
    values = np.zeros(len(files))
    for group in groups:
        values[group] = float(f"{np.median(medians[group]):.2g}")
    return tuple(values.tolist())
