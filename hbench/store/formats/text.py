"""Reader of text tables: delimited columns, with or without a header."""

import csv
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from itertools import chain, compress, islice, repeat
from string import whitespace
from typing import BinaryIO, ClassVar

import numpy as np

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.sentences import plural
from hbench.store.files.bounded_read import LARGEST_TEXT, read_whole
from hbench.store.formats import header_row
from hbench.store.formats.date_times import parse_date_time
from hbench.store.formats.encoding import decoded, is_text
from hbench.store.formats.header_row import ends_with_comment, labview_header, layout_hint
from hbench.store.formats.plain_rows import PlainRows, ungrouped, with_points

_DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t"}
_GAPS = ("", "nan", "na", "n/a", "null")
_COMPARED = 100  # rows with the last one, which a file without a final newline may contain in part
_MOST_SHORT = 5  # rows at the end with too few cells, which are left out


@dataclass(frozen=True)
class TextTable:
    """Rows of a file as text; columns are converted to numbers on demand."""

    names: tuple[str, ...]  # of the columns; empty without a header
    units: tuple[str, ...]  # of the columns; empty without a row of units
    rows: list[list[str]] | PlainRows
    lines: np.ndarray  # (n,) line of each row in the file, from 1
    layout: Format
    source: str
    short_lines: tuple[int, ...] = ()
    times: tuple[tuple[float, float], ...] = ()  # of the columns: start and step [s], of LabVIEW
    other_sheets: tuple[str, ...] = ()  # of a workbook of which no sheet was chosen
    _converted: dict[int, np.ndarray] = field(default_factory=dict, repr=False, compare=False)
    leaves_out_rows: ClassVar[bool] = False

    @property
    def started(self) -> datetime | None:
        """None: columns have no times of their own."""
        return None

    def where(self, row: int) -> str:
        """Return a row's position in the file, for messages."""
        return f"line {self.lines[row]}"

    def lines_of(self, rows: np.ndarray) -> np.ndarray:
        """Return the line in the file, from 1, of each of ``rows`` (n,), from 0."""
        return self.lines[rows]

    def columns(self) -> tuple[int | str, ...]:
        """Return all columns by name; by number where there is no unique name."""
        names = self.names or ("",) * len(self.rows[0])
        return tuple(
            name if name and names.count(name) == 1 else number
            for number, name in enumerate(names, start=1)
        )

    def position(self, column: int | str) -> int:
        """Return a column's index, from 0. Raises ``DataError``."""
        if isinstance(column, str):
            header = ", ".join(self.names) or "no header"
            if column not in self.names:
                raise DataError(
                    f"{self.source}: no column {column!r}; the file has: {header}",
                    header_row.column_hint(
                        self.names, self.other_sheets, self.rows, self.lines, self.layout
                    ),
                )
            if self.names.count(column) > 1:
                raise DataError(
                    f"{self.source}: column {column!r} occurs {self.names.count(column)} times; "
                    f"the file has: {header}",
                    "Give the column's number, from 1.",
                )
            return self.names.index(column)
        width = len(self.rows[0]) if self.rows else column
        if not 1 <= column <= width:
            raise DataError(f"{self.source}: no column {column}; the last is {width}")
        return column - 1

    def unit(self, column: int | str) -> str | None:
        """Return a column's unit in the row of units, without brackets; None without that row."""
        if not self.units:
            return None
        unit = self.units[self.position(column)].strip(" []")
        return unit[1:-1].strip() if unit.startswith("(") and unit.endswith(")") else unit

    def numbers(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) as floats; with ``gaps``, NaN where a cell is empty or "nan".

        Raises ``DataError`` naming the line of any other cell that is not a finite number.
        """
        position = self.position(column)
        if position not in self._converted:
            self.prefetch([column])
        values = self._converted.get(position)
        if values is None:
            values = np.array([_float(cell) for cell in self._plain(position)])
        for row in np.flatnonzero(~np.isfinite(values)).tolist():
            cell = self.rows[row][position]
            is_gap = cell.strip().lower() in _GAPS
            if not (gaps and is_gap):
                needed = "Remove the rows without it: each row needs a value in this column."
                raise DataError(
                    f"{self.source}: {self.where(row)}: column {column}: found {cell[:60]!r}; "
                    "expected a number",
                    needed if is_gap else header_row.cell_hint(cell, self.layout),
                )
        return values

    def prefetch(self, columns: Iterable[int | str]) -> None:
        """Convert columns of numbers together, which is faster than one by one."""
        positions = set()
        for column in columns:
            with suppress(DataError):  # raised again where the column is read
                positions.add(self.position(column))
        needed = sorted(positions - self._converted.keys())
        if isinstance(self.rows, PlainRows) and needed:
            with suppress(ValueError):  # not only numbers: converted cell by cell
                values = self.rows.numbers(needed, self.layout.decimal)
                self._converted.update(zip(needed, values, strict=True))

    def date_times(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) of date-times as datetime64 in UTC; ``gaps`` allows NaT.

        Raises ``DataError`` naming the line.
        """
        position = self.position(column)
        times = np.full(len(self.rows), np.datetime64("NaT", "us"))
        first: datetime | None = None
        for row, cells in enumerate(self.rows):
            cell = cells[position].strip()
            if gaps and cell.lower() in _GAPS:
                continue
            try:
                time = parse_date_time(cell)
                first = first or time
                time - first  # with and without an offset from UTC don't mix
                times[row] = (time.astimezone(UTC) if time.tzinfo else time).replace(tzinfo=None)
            except (ValueError, TypeError, OverflowError):
                raise DataError(
                    f"{self.source}: {self.where(row)}: column {column}: found {cell[:60]!r}; "
                    "expected a date-time such as 2024-05-01T12:00:00.25 or 01.05.2024 12:00:00,25"
                ) from None
        return times

    def own_times(self, column: int | str) -> np.ndarray | None:
        """Return the times (n,) [s] by LabVIEW's header; None if the times are in a column."""
        start, step = self.times[self.position(column)] if self.times else (0.0, 0.0)
        return start + step * np.arange(len(self.rows)) if step else None

    def _plain(self, position: int) -> list[str]:
        """Return a column's cells with numbers in Python's notation; other text stays invalid."""
        decimal, thousands = self.layout.decimal, self.layout.thousands
        cells = [row[position] for row in self.rows]
        if thousands is not None:
            cells = [ungrouped(c, decimal, thousands) if thousands in c else c for c in cells]
        text = "\n".join(cells).replace("_", "?")  # Python reads 1_0 as 10
        return (text if decimal == "." else with_points(text, decimal)).split("\n")


def open_text(file: BinaryIO, source: str, layout: Format) -> TextTable:
    """Read a file as a table. Raises ``DataError``."""
    return parse_table(read_whole(file, source, LARGEST_TEXT), source, layout)


def parse_table(data: bytes, source: str, layout: Format) -> TextTable:
    """Read a table. Raises ``DataError`` naming the line whose number of columns differs."""
    text = decoded(data)
    if not is_text(text):
        raise DataError(
            f"{source}: is not a text file",
            "Give the file the ending of its format, such as .mat, .tdms or .xlsx.",
        )
    numbers, texts = _lines_of_data(text, layout)
    top, above, below = _cells(texts, numbers, layout, source, _rows_above(layout))
    texts, numbers = texts[below:], numbers[below:]
    separator = _DELIMITERS.get(layout.separator)
    if layout.header and top and separator and ends_with_comment(top[0]):
        if max((line.count(separator) for line in texts), default=0) < len(top[0]) - 1:
            top[0].pop()
    rows: list[list[str]] | PlainRows
    if texts and (separator is None or '"' not in text or not any('"' in t for t in texts)):
        if separator == layout.decimal:
            raise DataError(
                f"{source}: decimal ',' and separator comma are ambiguous: numbers have no quotes",
                "Write each number in quotes, or separate the columns with semicolons.",
            )
        first_row = top[0] if layout.header else texts[0].split(separator)
        rows = PlainRows(texts, separator, len(first_row))
    else:
        rows, numbers, _ = _cells(texts, numbers, layout, source)
    ended = text.endswith(("\n", "\r"))
    table = _table(top, rows, [*above, *numbers], layout, source, ended=ended)
    labview = labview_header(text, layout, len(table.names))
    return replace(table, units=table.units or labview.units, times=labview.times)


def table_of_rows(
    rows: list[list[str]], lines: list[int], layout: Format, source: str
) -> TextTable:
    """Return the table in ``rows`` of cells. Raises ``DataError`` as ``parse_table`` does."""
    above = _rows_above(layout)
    return _table(rows[:above], rows[above:], lines, layout, source)


def _rows_above(layout: Format) -> int:
    return layout.header + layout.units_row + layout.skip_rows


def _table(
    top: list[list[str]],
    rows: list[list[str]] | PlainRows,
    lines: list[int],
    layout: Format,
    source: str,
    *,
    ended: bool = True,
) -> TextTable:
    """Return the table of ``rows`` of data below the ``top`` rows; ``lines`` has all numbers.

    ``ended`` is whether the last row is known to be complete.
    """
    names = tuple(name.strip() for name in top[0]) if layout.header and top else ()
    units = tuple(top[layout.header]) if layout.units_row and len(top) > layout.header else ()
    if not len(rows):
        skipped = layout.preamble + _rows_above(layout)
        below = f" below the first {plural(skipped, 'line', f'{skipped} lines')}" if lines else ""
        raise DataError(f"{source}: no rows of data{below}")
    width = len(names) or len(rows[0])
    all_lines, lines = lines, lines[len(top) :]
    whole = rows.whole() if isinstance(rows, PlainRows) else rows
    unequal = list(_unequal(rows, width))
    count = len(rows) - _short_at_end(unequal, len(rows), width)
    last_is_unequal = bool(unequal) and unequal[-1][0] == len(rows) - 1
    if not (ended or last_is_unequal) and _is_cut(rows, width):
        count -= 1
    short = lines[count:]
    for row, cells in (pair for pair in unequal if pair[0] < count):
        text = _DELIMITERS.get(layout.separator, " ").join(cells)
        raise DataError(
            f"{source}: line {lines[row]}: found {len(cells)} columns in "
            f"{text[:60]!r}; expected {width}",
            layout_hint(chain(top, whole), all_lines, layout),
        )
    if units and len(units) < width:
        raise DataError(f"{source}: the row of units has {len(units)} columns; expected {width}")
    return TextTable(
        names, units, rows[:count], np.array(lines[:count]), layout, source, tuple(short)
    )


def _short_at_end(unequal: list[tuple[int, list[str]]], count: int, width: int) -> int:
    """Return how many of ``count`` rows end a table with too few cells.

    A logger that was stopped writes a part of a row, others a remark. Where more rows than
    ``_MOST_SHORT`` are short, or all, the table is not understood: the result is 0.
    """
    end = 0
    while end < len(unequal):
        row, cells = unequal[-1 - end]
        if row != count - 1 - end or len(cells) >= width:
            break
        end += 1
    return end if end <= min(_MOST_SHORT, count - 1) else 0


def _is_cut(rows: list[list[str]] | PlainRows, width: int) -> bool:
    """Return whether the last cell of all is shorter than those of the rows before."""
    last = [len(cells[:width][-1]) for cells in rows[-_COMPARED:]]
    return len(last) > 2 and last[-1] < min(last[:-1])


def _unequal(rows: list[list[str]] | PlainRows, width: int) -> Iterator[tuple[int, list[str]]]:
    """Yield the numbers and cells of rows without ``width`` cells; a blank last one is left out."""
    if isinstance(rows, PlainRows):
        yield from rows.unequal()
        return
    for row, cells in enumerate(rows):
        if len(cells) == width + 1 and not cells[-1].strip():
            cells.pop()  # the line ends with a separator
        if len(cells) != width:
            yield row, cells


def _lines_of_data(text: str, layout: Format) -> tuple[list[int], list[str]]:
    """Return the numbers, from 1, and the texts of the lines that are not left out.

    Lines of blank cells below the header are left out too, as spreadsheets write them.
    """
    lines = text.splitlines()
    kept = _filled(lines, None)
    kept[: layout.preamble] = False
    if (mark := layout.comment) is not None:
        kept &= [not line.lstrip().startswith(mark) for line in lines]
    if separator := _DELIMITERS.get(layout.separator):
        below = np.flatnonzero(kept)[_rows_above(layout) :]  # a header may have no names
        kept[below] = _filled(lines, f'{whitespace}"{separator}')[below]
    return (np.flatnonzero(kept) + 1).tolist(), list(compress(lines, kept.tolist()))


def _filled(lines: list[str], blanks: str | None) -> np.ndarray:
    """Return which of the lines (n,) have other characters than ``blanks``."""
    return np.fromiter(map(bool, map(str.strip, lines, repeat(blanks))), bool, len(lines))


def _cells(
    texts: list[str], numbers: list[int], layout: Format, source: str, most: int | None = None
) -> tuple[list[list[str]], list[int], int]:
    """Return the cells of the first ``most`` rows, or of all.

    Also the number of the line in which each row ends, and how many of the lines are used.
    """
    if layout.separator == "whitespace":
        rows = [line.split() for line in texts[:most]]
        return rows, numbers[:most], len(rows)
    reader = csv.reader(texts, delimiter=_DELIMITERS[layout.separator])
    rows, ends, first, end = [], [], 0, 0
    try:
        for cells in islice(reader, most):
            rows.append(cells)
            first, end = end, reader.line_num
            ends.append(numbers[end - 1])
    except csv.Error as error:  # such as a cell of 100 kB after an unclosed quote
        after = f"after line {ends[-1]}" if ends else "in the first row"
        raise DataError(
            f"{source}: {after}: {error}", "Check that all quotes are closed."
        ) from None
    if end - first > 1 and end == len(texts) and "".join(texts[first:end]).count('"') % 2:
        raise DataError(
            f"{source}: line {numbers[first]}: a quote in {texts[first][:60]!r} is not closed",
            "Close the quote, or remove it.",
        )
    return rows, ends, reader.line_num


def _float(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan
