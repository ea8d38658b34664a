"""Reader of text tables: delimited columns, with or without a header."""

import codecs
import csv
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import BinaryIO, ClassVar

import numpy as np

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.files.bounded_read import read_whole

_DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t"}
_GAPS = ("", "nan", "na", "n/a", "null")
_BOMS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}


_FORMAT = (
    "Set 'format' in the map: separator, preamble (lines before the header), comment, skip_rows."
)


@dataclass(frozen=True)
class TextTable:
    """Rows of a file as text; columns are converted to numbers on demand."""

    names: tuple[str, ...]  # of the columns; empty without a header
    units: tuple[str, ...]  # of the columns; empty without a row of units
    rows: list[list[str]]
    lines: np.ndarray  # (n,) line of each row in the file, from 1
    layout: Format
    source: str
    short_lines: tuple[int, ...] = ()
    leaves_out_rows: ClassVar[bool] = False

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
                mapped = self.layout != Format() or len(self.names) == 1
                raise DataError(
                    f"{self.source}: no column {column!r}; the file has: {header}",
                    _FORMAT if mapped else "",
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
        return self.units[self.position(column)].strip(" []()") if self.units else None

    def numbers(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) as floats; with ``gaps``, NaN where a cell is empty or "nan".

        Raises ``DataError`` naming the line of any other cell that is not a finite number.
        """
        position = self.position(column)
        cells = [self._plain(row[position]) for row in self.rows]
        try:
            values = np.array(cells, dtype=float)
        except ValueError:
            values = np.array([_float(cell) for cell in cells])
        for row in np.flatnonzero(~np.isfinite(values)).tolist():
            if not (gaps and cells[row].strip().lower() in _GAPS):
                cell = self.rows[row][position][:60]
                raise DataError(
                    f"{self.source}: {self.where(row)}: column {column}: found {cell!r}; "
                    "expected a number",
                    "Specify a decimal comma in the map: format.decimal." if "," in cell else "",
                )
        return values

    def date_times(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) of ISO 8601 date-times as datetime64 in UTC; ``gaps`` allows NaT.

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
                time = datetime.fromisoformat(cell)
                first = first or time
                time - first  # with and without an offset from UTC don't mix
                times[row] = (time.astimezone(UTC) if time.tzinfo else time).replace(tzinfo=None)
            except (ValueError, TypeError, OverflowError):
                raise DataError(
                    f"{self.source}: {self.where(row)}: column {column}: found {cell[:60]!r}; "
                    "expected a date-time such as 2024-05-01T12:00:00.25"
                ) from None
        return times

    def own_times(self, column: int | str) -> np.ndarray | None:
        """Return None: a text states its times in columns."""
        return None

    def _plain(self, cell: str) -> str:
        """Return a number in Python's notation; other text stays invalid."""
        decimal, thousands = self.layout.decimal, self.layout.thousands
        if thousands is not None:
            whole, mark, fraction = cell.strip().partition(decimal)
            groups = whole.lstrip("+-").split(thousands)
            if 1 <= len(groups[0]) <= 3 and all(len(group) == 3 for group in groups[1:]):
                cell = whole.replace(thousands, "") + mark + fraction
        if decimal != "." and cell:
            cell = cell.translate({ord("."): "?", ord(decimal): "."})
        return cell.replace("_", "?")  # Python reads 1_0 as 10


def open_text(file: BinaryIO, source: str, layout: Format) -> TextTable:
    """Read a file as a table. Raises ``DataError``."""
    return parse_table(read_whole(file, source), source, layout)


def parse_table(data: bytes, source: str, layout: Format) -> TextTable:
    """Read a table. Raises ``DataError`` naming the line whose number of columns differs."""
    kept = list(_lines_of_data(decoded(data), layout))
    rows, lines = _cells(kept, layout, source)
    return table_of_rows(rows, lines, layout, source)


def table_of_rows(
    rows: list[list[str]], lines: list[int], layout: Format, source: str
) -> TextTable:
    """Return the table in ``rows`` of cells. Raises ``DataError`` as ``parse_table`` does."""
    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    if layout.header and rows:
        names, rows, lines = tuple(name.strip() for name in rows[0]), rows[1:], lines[1:]
    if layout.units_row and rows:
        units, rows, lines = tuple(rows[0]), rows[1:], lines[1:]
    rows, lines = rows[layout.skip_rows :], lines[layout.skip_rows :]
    if not rows:
        skipped = layout.preamble + layout.header + layout.units_row + layout.skip_rows
        raise DataError(f"{source}: no rows of data after the first {skipped} lines")
    width = len(names) or len(rows[0])
    for number, cells in enumerate(rows):
        if len(cells) == width + 1 and not cells[-1].strip():
            cells.pop()  # the line ends with a separator
        if len(cells) != width:
            text = _DELIMITERS.get(layout.separator, " ").join(cells)
            raise DataError(
                f"{source}: line {lines[number]}: found {len(cells)} columns in "
                f"{text[:60]!r}; expected {width}",
                _FORMAT,
            )
    if units and len(units) < width:
        raise DataError(f"{source}: the row of units has {len(units)} columns; expected {width}")
    return TextTable(names, units, rows, np.array(lines), layout, source)


def decoded(data: bytes) -> str:
    """Return the text; byte-order mark, zero bytes or UTF-8 faults determine its encoding."""
    for mark, name in _BOMS.items():
        if data.startswith(mark):
            return data.decode(name, errors="replace")
    if data[1:200:2].count(0) > 50 or (len(data) > 3 and data[1] == data[3] == 0):
        return data.decode("utf-16-le", errors="replace")
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def _lines_of_data(text: str, layout: Format) -> Iterator[tuple[int, str]]:
    for number, line in enumerate(text.splitlines(), start=1):
        if number <= layout.preamble or not line.strip():
            continue
        if layout.comment is None or not line.lstrip().startswith(layout.comment):
            yield number, line


def _cells(
    kept: list[tuple[int, str]], layout: Format, source: str
) -> tuple[list[list[str]], list[int]]:
    """Return the cells of each row, and the line in which it ends."""
    texts = [line for _, line in kept]
    if layout.separator == "whitespace":
        return [line.split() for line in texts], [number for number, _ in kept]
    reader, rows, lines = csv.reader(texts, delimiter=_DELIMITERS[layout.separator]), [], []
    try:
        for cells in reader:
            rows.append(cells)
            lines.append(kept[reader.line_num - 1][0])
    except csv.Error as error:  # such as a cell of 100 kB after an unclosed quote
        after = f"after line {lines[-1]}" if lines else "in the first row"
        raise DataError(
            f"{source}: {after}: {error}", "Check that all quotes are closed."
        ) from None
    return rows, lines


def _float(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan
