"""The table of formats, and the opening of a foreign file as a table of columns."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from hbench.config.import_layout import Format
from hbench.store.files.bounded_read import LARGEST_LOG, open_file
from hbench.store.formats.arrays import Arrays
from hbench.store.formats.mat import open_mat
from hbench.store.formats.parquet import open_parquet
from hbench.store.formats.text import TextTable, open_text

AnyTable = TextTable | Arrays


@dataclass(frozen=True)
class FileFormat:
    """A format, its recognition and its reader."""

    name: str
    endings: tuple[str, ...]  # of file names, in lower case; none: all
    open: Callable[[BinaryIO, str, Format], AnyTable]
    extra: str = ""  # of pip, if it needs an optional package
    largest: int = LARGEST_LOG  # bytes
    is_text: bool = False


# The first row that fits a file applies.
FORMATS = (
    FileFormat("MATLAB up to version 7", (".mat",), open_mat),
    FileFormat("Parquet", (".parquet",), open_parquet, extra="parquet"),
    FileFormat("text", (), open_text, is_text=True),
)


def format_of(path: Path) -> FileFormat:
    """Return the format of a file by the ending of its name."""
    name = path.name.lower()
    return next(row for row in FORMATS if not row.endings or name.endswith(row.endings))


@contextmanager
def open_table(path: Path, layout: Format) -> Iterator[AnyTable]:
    """Open a file of any format; its columns can be read until the context ends.

    Raises ``DataError``, and ``ConfigError`` if the format's optional package is not installed.
    """
    row = format_of(path)
    with open_file(path, row.largest) as file:
        yield row.open(file, str(path), layout)
