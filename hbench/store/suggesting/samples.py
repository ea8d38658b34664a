"""Columns of some files of a folder, with the meaning of their names."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.files.bounded_read import check_inside, read_whole
from hbench.store.formats.encoding import decoded
from hbench.store.formats.opening import FileFormat, open_foreign
from hbench.store.formats.reading import open_table
from hbench.store.formats.table import Table
from hbench.store.formats.text import TextTable
from hbench.store.suggesting.dialect import Dialect, rows_dialect, text_dialect
from hbench.store.suggesting.quantities import Meaning, common_words, meaning
from hbench.store.suggesting.units import unknown_unit
from hbench.units import unit_in

_MOST_COLUMNS = 300
_LARGEST = 1e19  # of a number, as nanoseconds since 1970: a larger one is no measurement
_WITH_DIALECT = ("text", "Excel")


@dataclass(frozen=True)
class SampleFile:
    """A file with its columns as numbers."""

    name: str
    format_name: str
    dialect: Dialect | None  # of a text or a sheet
    columns: dict[int | str, np.ndarray]  # numbers, NaN for a gap; datetime64 for date-times
    names: dict[int | str, str]  # as in the file; empty without a name
    units: dict[int | str, str]  # stated by the file, but for those in names
    own_times: dict[int | str, np.ndarray]  # [s] stated by the file
    unread: dict[str, str]  # columns that are neither numbers nor date-times: name and first fault
    other_sheets: tuple[str, ...] = ()  # of a workbook, with tables that were not read

    @property
    def signature(self) -> tuple:
        """Key of files that one map can read."""
        layout = None if self.dialect is None else self.dialect.layout
        return self.format_name, layout, frozenset(self.columns)


@dataclass(frozen=True)
class SampleColumn:
    """A column of several files."""

    key: int | str
    name: str
    unit: str | None  # stated by the file or in the name
    in_file: bool  # stated by the file beside the name, so that a map need not state it
    meaning: Meaning
    values: tuple[np.ndarray, ...]  # of each file
    unknown_unit: str = ""  # stated by the file or in the name, but no unit of hbench

    @property
    def is_date_time(self) -> bool:
        """Whether its values are date-times."""
        return self.values[0].dtype.kind == "M"

    @property
    def known(self) -> np.ndarray:
        """Its numbers in all files, without gaps."""
        if self.is_date_time:
            return np.zeros(0)
        values = np.concatenate(self.values)
        return values[np.isfinite(values)]


def read_sample(folder: Path, name: str, like: Dialect | None = None) -> SampleFile | None:
    """Read a file; None if it contains no table of numbers. Raises ``DataError``.

    ``like`` is the dialect of a similar file.
    """
    path = folder / name
    check_inside(folder, path)
    with open_foreign(path) as (file, file_format):
        is_text = file_format.name == "text"
        data = read_whole(file, str(path), file_format.largest) if is_text else b""
    dialect: Dialect | None = None
    others: tuple[str, ...] = ()
    if file_format.name in _WITH_DIALECT:
        dialect = like
        if like is None and file_format.is_text:
            dialect = None if _is_binary(data) else text_dialect(decoded(data))
        elif like is None:
            dialect, others = _sheet_dialect(path)
        if dialect is None:
            return None
    with open_table(path, Format() if dialect is None else dialect.layout) as table:
        return _sample(name, file_format, dialect, table, others)


def _sheet_dialect(path: Path) -> tuple[Dialect | None, tuple[str, ...]]:
    """Return the dialect of a workbook's first sheet that contains a table of numbers.

    Also the other sheets with a table. A cover sheet contains some numbers too: a sheet with less
    than half of the rows of the longest table has none.
    """
    sheets: list[str | None] = [None]
    found: list[tuple[str | None, Dialect, int]] = []
    for name in sheets:
        with open_table(path, Format(header=False, sheet=name)) as sheet:
            assert isinstance(sheet, TextTable)
            rows = list(zip(sheet.lines.tolist(), sheet.rows, strict=True))
            dialect = rows_dialect(rows, {} if name is None else {"sheet": name})
            if dialect is not None:
                found.append((name, dialect, len(rows)))
            sheets += sheet.other_sheets
    least = max((rows for *_, rows in found), default=0) / 2
    tables = [(name, dialect) for name, dialect, rows in found if rows >= least]
    return tables[0][1] if tables else None, tuple(name for name, _ in tables[1:] if name)


def _is_binary(data: bytes) -> bool:
    text = decoded(data[:4096])
    return "\0" in text or sum(not c.isprintable() and not c.isspace() for c in text) > 40


def _sample(
    name: str,
    file_format: FileFormat,
    dialect: Dialect | None,
    table: Table,
    other_sheets: tuple[str, ...],
) -> SampleFile | None:
    columns: dict[int | str, np.ndarray] = {}
    units, own_times = {}, {}
    names = _names(table, dialect)
    unread: dict[str, str] = {}
    for key in table.columns()[:_MOST_COLUMNS]:
        values, fault = _values(table, key)
        if values is None or not printable_key(key):
            unread[names.get(key, str(key))] = fault
            continue
        columns[key] = values
        if unit := table.unit(key):
            units[key] = unit
        if (times := table.own_times(key)) is not None:
            own_times[key] = times
    if not columns:
        if fault := next(iter(unread.values()), ""):
            raise DataError(f"{table.source}: {fault}")
        return None
    names = {key: names.get(key, str(key) if isinstance(key, str) else "") for key in columns}
    return SampleFile(
        name=name,
        format_name=file_format.name,
        dialect=dialect,
        columns=columns,
        names=names,
        units=units,
        own_times=own_times,
        unread=unread,
        other_sheets=other_sheets,
    )


def printable_key(key: int | str) -> bool:
    """Return whether a map can give a column by this name."""
    return isinstance(key, int) or key.isprintable()


def _names(table: Table, dialect: Dialect | None) -> dict[int | str, str]:
    """Return the names of columns that a map gives by number."""
    if isinstance(table, TextTable) and table.names:
        return dict(enumerate(table.names, start=1))
    return dict(enumerate(dialect.names if dialect else (), start=1))


def _values(table: Table, key: int | str) -> tuple[np.ndarray | None, str]:
    """Return a column as numbers or date-times; None with the reason for any other."""
    try:
        values = table.numbers(key, gaps=True)
        empty = np.isnan(values)
    except DataError as error:
        try:
            values = table.date_times(key, gaps=True)
            empty = np.isnat(values)
        except DataError:
            fault = error.message.removeprefix(f"{table.source}: ")
            return None, f"{fault}. {error.hint}" if error.hint else fault
    if len(values) < 2 or empty.all():
        return None, "has no values"
    if values.dtype.kind == "f" and np.nanmax(np.abs(values)) > _LARGEST:
        return None, f"has values above {_LARGEST:g}"
    return values, ""


def sample_columns(files: Sequence[SampleFile]) -> list[SampleColumn]:
    """Return the columns that all ``files`` have."""
    first = files[0]
    common = common_words([name for name in first.names.values() if name])
    columns = []
    for key in first.columns:
        values = tuple(file.columns[key] for file in files if key in file.columns)
        kinds = {column.dtype.kind == "M" for column in values}
        if len(values) < len(files) or len(kinds) > 1:
            continue
        name = first.names[key]
        stated = unit_in(first.units.get(key, ""))
        means = meaning(name, stated, common)
        unknown = unknown_unit(name, first.units.get(key, "")) if means.unit is None else ""
        columns.append(
            SampleColumn(key, name, means.unit, stated is not None, means, values, unknown)
        )
    return columns
