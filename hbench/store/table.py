"""Reads a table of text: delimited columns, with or without a header."""

import csv
from dataclasses import dataclass

import numpy as np

from hbench.config.importmap import Format
from hbench.errors import DataError

_DELIMITERS = {"comma": ",", "semicolon": ";", "tab": "\t"}
_GAPS = ("", "nan")


@dataclass(frozen=True)
class Table:
    """Rows of a file as text; a column becomes numbers when it is asked for."""

    names: tuple[str, ...]  # of the columns; empty without a header
    rows: list[list[str]]
    first_line: int  # line of rows[0] in the file, from 1
    decimal: str
    source: str

    def line(self, row: int) -> int:
        """Return the line in the file of a row."""
        return self.first_line + row

    def position(self, column: int | str) -> int:
        """Return where a column stands, from 0. Raises ``DataError``."""
        if isinstance(column, str):
            if column not in self.names:
                have = ", ".join(self.names) or "no header"
                raise DataError(f"{self.source}: no column {column!r}; there are: {have}")
            return self.names.index(column)
        width = len(self.rows[0]) if self.rows else column
        if not 1 <= column <= width:
            raise DataError(f"{self.source}: no column {column}; there are {width}")
        return column - 1

    def numbers(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) as floats; with ``gaps``, NaN where a cell is empty or "nan".

        Raises ``DataError`` naming the line of any other cell that is not a finite number.
        """
        position = self.position(column)
        cells = [row[position] for row in self.rows]
        if self.decimal != ".":
            cells = [cell.replace(self.decimal, ".") for cell in cells]
        try:
            values = np.array(cells, dtype=float)
        except ValueError:
            values = np.array([_float(cell) for cell in cells])
        for row in np.flatnonzero(~np.isfinite(values)):
            if not (gaps and cells[row].strip().lower() in _GAPS):
                raise DataError(
                    f"{self.source}: line {self.line(row)}: column {column}: "
                    f"found {self.rows[row][position]!r}; expected a number"
                )
        return values


def parse_table(data: bytes, source: str, layout: Format) -> Table:
    """Read a table. Raises ``DataError`` naming the line whose number of columns differs."""
    lines = data.decode("utf-8-sig", errors="replace").splitlines()
    while lines and not lines[-1].strip():
        lines.pop()
    if layout.separator == "whitespace":
        rows = [line.split() for line in lines]
    else:
        rows = list(csv.reader(lines, delimiter=_DELIMITERS[layout.separator]))
    names: tuple[str, ...] = ()
    if layout.header and rows:
        names = tuple(name.strip() for name in rows[0])
    skipped = int(layout.header) + layout.skip_rows
    table = Table(names, rows[skipped:], skipped + 1, layout.decimal, source)
    if not table.rows:
        raise DataError(f"{source}: no rows of data after the first {skipped}")
    width = len(names) or len(table.rows[0])
    for row, cells in enumerate(table.rows):
        if len(cells) != width:
            raise DataError(
                f"{source}: line {table.line(row)}: found {len(cells)} columns in "
                f"{lines[skipped + row][:60]!r}; expected {width}"
            )
    return table


def _float(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan
