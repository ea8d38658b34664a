"""Rows of a text without quotes: split on demand, and converted to numbers by whole columns."""

from collections.abc import Iterator, Sequence
from itertools import repeat
from typing import overload

import numpy as np


class PlainRows:
    """Rows of cells, each a line of text split at every separator.

    A row may end with a separator; the cells after ``width`` are left out.
    """

    def __init__(self, lines: Sequence[str], separator: str | None, width: int):
        self._lines = lines
        self._separator = separator  # None: white space
        self._width = width

    def __len__(self) -> int:
        return len(self._lines)

    @overload
    def __getitem__(self, row: int) -> list[str]: ...
    @overload
    def __getitem__(self, row: slice) -> "PlainRows": ...
    def __getitem__(self, row: int | slice) -> "list[str] | PlainRows":
        if isinstance(row, slice):
            return PlainRows(self._lines[row], self._separator, self._width)
        return self._lines[row].split(self._separator)[: self._width]

    def __iter__(self) -> Iterator[list[str]]:
        return (line.split(self._separator)[: self._width] for line in self._lines)

    def whole(self) -> Iterator[list[str]]:
        """Yield all cells of each row."""
        return (line.split(self._separator) for line in self._lines)

    def unequal(self) -> Iterator[tuple[int, list[str]]]:
        """Yield the number and the cells of each row without ``width`` cells.

        A blank cell after the last one does not count.
        """
        if (separator := self._separator) is None:
            counts, width = map(len, map(str.split, self._lines)), self._width
        else:
            counts, width = map(str.count, self._lines, repeat(separator)), self._width - 1
        for row in np.flatnonzero(np.fromiter(counts, int, len(self._lines)) != width).tolist():
            cells = self._lines[row].split(separator)
            if len(cells) != self._width + 1 or cells[-1].strip():
                yield row, cells

    def numbers(self, positions: Sequence[int], decimal: str) -> np.ndarray:
        """Return columns (k, n) as floats, an empty cell as NaN; ``decimal`` is the point or comma.

        Raises ``ValueError`` if a cell is not a number. Each number is that of Python's ``float``,
        which also reads a few more notations.
        """
        lines = self._lines
        if decimal != ".":
            lines = with_points("\n".join(lines), decimal).split("\n")
        try:
            return self._columns(lines, positions)
        except ValueError:
            if self._separator is None:
                raise
        return self._columns(_with_nan(lines, self._separator), positions)

    def _columns(self, lines: Sequence[str], positions: Sequence[int]) -> np.ndarray:
        return np.loadtxt(
            lines,
            delimiter=self._separator,
            usecols=positions,
            comments=None,
            ndmin=2,
            unpack=True,
        )


def _with_nan(lines: Sequence[str], separator: str) -> list[str]:
    """Return lines with "nan" in their empty cells."""
    text = "\n".join(("", *lines, ""))
    twice = separator + separator  # replaced twice, since one of three separators is left
    for empty in (twice, twice, f"\n{separator}", f"{separator}\n"):
        text = text.replace(empty, f"{empty[0]}nan{empty[1]}")
    return text.split("\n")[1:-1]


def with_points(text: str, decimal: str) -> str:
    """Return text with points instead of ``decimal``; what had a point is no number any more."""
    return text.replace(".", "?").replace(decimal, ".")


def ungrouped(cell: str, decimal: str, thousands: str) -> str:
    """Return a number without its marks of thousands; other text stays as it is."""
    whole, mark, fraction = cell.strip().partition(decimal)
    groups = whole.lstrip("+-").split(thousands)
    if 1 <= len(groups[0]) <= 3 and all(len(group) == 3 for group in groups[1:]):
        return whole.replace(thousands, "") + mark + fraction
    return cell
