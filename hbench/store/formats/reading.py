"""The reading of a foreign file: text in this process, other formats in one with limits.

Readers of binary formats are large libraries, and a damaged or forged file can crash them, or make
them take all memory. Their process may die; the file is then refused with its name.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from datetime import datetime
from importlib import import_module
from itertools import count
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.files.limited_process import CallKilled, LimitedProcess
from hbench.store.formats.barrier import reader_errors
from hbench.store.formats.opening import LARGEST_BINARY, open_foreign, open_here
from hbench.store.formats.packages import require_package
from hbench.store.formats.table import Table
from hbench.store.formats.text import TextTable

Result = TypeVar("Result")

_process = LimitedProcess(memory=500_000_000, disk=LARGEST_BINARY, seconds=60.0)


@contextmanager
def open_table(path: Path, layout: Format) -> Iterator[Table]:
    """Open a file of any format; its columns can be read until the context ends.

    Raises ``DataError``, also for any other exception until then, and ``ConfigError`` if the
    format's optional package is not installed.
    """
    with open_foreign(path) as (_, file_format):
        if file_format.package:
            require_package(file_format.package, file_format.name, file_format.extra)
    if file_format.is_text:
        with open_here(path, layout) as table:
            yield table
        return
    if file_format.package:
        read_apart(path, _load, file_format.package)  # not a part of the file's memory
    opened = read_apart(path, _open, path, layout)
    if isinstance(opened, TextTable):
        with reader_errors(str(path)):
            yield opened
        return
    try:
        with reader_errors(str(path)):
            yield _RemoteTable(path, opened)
    finally:
        if _process.is_running:
            with suppress(DataError):
                read_apart(path, _close, opened.number)


def read_apart(path: Path, function: Callable[..., Result], *arguments: Any) -> Result:
    """Return ``function(*arguments)``, which reads the file ``path``, from the limited process.

    Raises ``DataError``, also if the process dies.
    """
    try:
        result: Result = _process.call(_barred, path, function, arguments)
    except CallKilled as killed:
        raise DataError(
            f"{path}: can't be read: {killed}",
            "The file is damaged, or larger than it seems; save it again, for example as CSV.",
        ) from None
    return result


class _Head(NamedTuple):
    """What a table in the limited process has besides columns."""

    number: int
    source: str
    names: tuple[str, ...]
    leaves_out_rows: bool
    short_lines: tuple[int, ...]
    started: datetime | None


class _RemoteTable:
    """Table in the limited process."""

    def __init__(self, path: Path, head: _Head):
        self._path = path
        self._number, self.source, self.names = head.number, head.source, head.names
        self.leaves_out_rows, self.short_lines = head.leaves_out_rows, head.short_lines
        self.started = head.started

    def where(self, row: int) -> str:
        """Return a row's position in the file, for messages."""
        return self._call("where", row)

    def lines_of(self, rows: np.ndarray) -> np.ndarray:
        """Return the numbers from 1 of ``rows`` (n,), from 0."""
        return self._call("lines_of", rows)

    def columns(self) -> tuple[int | str, ...]:
        """Return all columns by name or path."""
        return self._call("columns")

    def position(self, column: int | str) -> int:
        """Return a column's index, from 0. Raises ``DataError``."""
        return self._call("position", column)

    def prefetch(self, columns: Iterable[int | str]) -> None:
        """Do nothing: columns are read one by one."""

    def unit(self, column: int | str) -> str | None:
        """Return a column's unit in the file; None if the file has no units."""
        return self._call("unit", column)

    def numbers(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) as floats; ``gaps`` allows NaN. Raises ``DataError``."""
        return self._call("numbers", column, gaps=gaps)

    def date_times(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) of date-times as datetime64 in UTC; ``gaps`` allows NaT."""
        return self._call("date_times", column, gaps=gaps)

    def own_times(self, column: int | str) -> np.ndarray | None:
        """Return the times (n,) [s] that the file states for a column, or None."""
        return self._call("own_times", column)

    def _call(self, method: str, *arguments: Any, **options: Any) -> Any:
        return read_apart(self._path, _method, self._number, method, arguments, options)


# In the limited process.

_tables: dict[int, tuple[Table, ExitStack]] = {}
_numbers = count()


def _barred(path: Path, function: Callable[..., Result], arguments: tuple) -> Result:
    with reader_errors(str(path)):
        return function(*arguments)


def _load(package: str) -> None:
    import_module(package)


def _open(path: Path, layout: Format) -> _Head | TextTable:
    """Open a file; a table of text, such as a sheet, is returned as a whole."""
    with ExitStack() as stack:
        table = stack.enter_context(open_here(path, layout))
        if isinstance(table, TextTable):
            return table
        number = next(_numbers)
        _tables[number] = table, stack.pop_all()
    about = table.names, table.leaves_out_rows, table.short_lines, table.started
    return _Head(number, table.source, *about)


def _method(number: int, name: str, arguments: tuple, options: dict[str, Any]) -> Any:
    return getattr(_tables[number][0], name)(*arguments, **options)


def _close(number: int) -> None:
    _tables.pop(number)[1].close()
