"""CSV exports of TwinCAT Scope View.

Lines of metadata, a row of names and blank lines come before the data. A column ``Name`` contains
the times of the columns that follow it until the next one [ms, or ticks of 100 ns since 1601]::

    Name,Crane,
    File,C:\\crane.csv,
    Starttime of export,133898804820400000,onsdag 23. april 2025,13:14:42.040
    Endtime of export,133898805323500000,onsdag 23. april 2025,13:15:32.350

    Name,Pa,Pb,Name,X
    Unit,bar,bar,Unit,m

    0,23.09,0.19,0,0.72
    10,23.08,0.19,5,0.72

The separator is a comma, a semicolon or a tab. Rows about each channel may follow the names. Slower
channels end before the others, and the last rows of an interrupted export are incomplete.
"""

import csv
import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import BinaryIO, ClassVar, Literal

import numpy as np

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.files.bounded_read import LARGEST_TEXT, read_whole
from hbench.store.formats.encoding import decoded
from hbench.store.formats.text import TextTable

_TIME = "Name"
_START, _UNIT, _END = "Starttime of export", "Unit", "EOF"
_SEPARATORS: dict[str, Literal["comma", "semicolon", "tab"]] = {
    ",": "comma",
    ";": "semicolon",
    "\t": "tab",
}
_ZERO_TICKS = datetime(1601, 1, 1, tzinfo=UTC)
_TICKS = re.compile(r"\d{15,18}")  # as milliseconds more than 30 000 years


def is_twincat(head: bytes) -> bool:
    """Return whether a file that begins with ``head`` is an export of TwinCAT Scope."""
    text = decoded(head)
    return re.match(rf"{_TIME}[,;\t]", text) is not None and _START in text


@dataclass(frozen=True)
class ScopeTable(TextTable):
    """Rows of an export; a row that has not all of its cells is left out."""

    start_ticks: int = 0  # start of the export
    leaves_out_rows: ClassVar[bool] = True

    @property
    def started(self) -> datetime | None:
        """Start of the export; None if it is not stated."""
        if not self.start_ticks:
            return None
        return _ZERO_TICKS + timedelta(microseconds=self.start_ticks / 10)

    def own_times(self, column: int | str) -> np.ndarray:
        """Return the times (n,) [s] of a column's rows; NaN where there is none."""
        before = self.names[: self.position(column) + 1]
        if _TIME not in before:
            raise DataError(f"{self.source}: column {column}: no column {_TIME!r} before it")
        position = len(before) - 1 - before[::-1].index(_TIME)
        cells = [row[position].strip() for row in self.rows]
        if not any(map(_TICKS.fullmatch, cells)):
            return self.numbers(position + 1, gaps=True) * 1e-3
        ticks = (int(c) - self.start_ticks if _TICKS.fullmatch(c) else np.nan for c in cells)
        return np.fromiter(ticks, float, len(cells)) * 1e-7


def open_twincat(file: BinaryIO, source: str, layout: Format) -> ScopeTable:
    """Read an export; ``layout`` is not used. Raises ``DataError``."""
    text = decoded(read_whole(file, source, LARGEST_TEXT))
    separator = text[len(_TIME)]
    try:
        rows = list(enumerate(csv.reader(text.splitlines(), delimiter=separator), start=1))
    except csv.Error as error:
        raise DataError(f"{source}: {error}") from None
    start = next((cells[1] for _, cells in rows if cells[:1] == [_START] and cells[1:]), "")
    header = next((n for n, (_, cells) in enumerate(rows) if n and cells[:1] == [_TIME]), len(rows))
    first = next((n for n, (_, cells) in enumerate(rows) if n > header and _is_data(cells)), None)
    if first is None:
        raise DataError(f"{source}: is an export of TwinCAT Scope without a row of names and data")
    names = [name.strip() for name in rows[header][1]]
    width = len(names) - (names[-1] == "")
    units = next((cells for _, cells in rows[header:first] if cells[:1] == [_UNIT]), [])
    data = [(line, cells) for line, cells in rows[first:] if cells and cells[0] != _END]
    full = [(line, cells) for line, cells in data if len(cells) >= width]
    if not full:
        raise DataError(f"{source}: no row of data has {width} cells, as the row of names")
    is_comma = separator != "," and any("," in cell for _, cells in full[:100] for cell in cells)
    return ScopeTable(
        names=tuple(names[:width]),
        units=tuple(unit.partition(" ")[0] for unit in [*units, *[""] * width][:width])
        if units
        else (),
        rows=[cells for _, cells in full],
        lines=np.array([line for line, _ in full]),
        layout=Format(separator=_SEPARATORS[separator], decimal="," if is_comma else "."),
        source=source,
        short_lines=tuple(line for line, cells in data if len(cells) < width),
        start_ticks=int(start) if _TICKS.fullmatch(start) else 0,
    )


def _is_data(cells: list[str]) -> bool:
    return bool(cells) and cells[0].strip()[:1] in set("-0123456789")
