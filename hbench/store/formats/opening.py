"""The table of formats, and the opening of a foreign file as a table of columns."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import BinaryIO

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.files.bounded_read import LARGEST_LOG, LARGEST_TEXT, check_size, open_file
from hbench.store.formats.barrier import reader_errors
from hbench.store.formats.excel import open_excel
from hbench.store.formats.matlab.mat import open_mat
from hbench.store.formats.matlab.mat73 import is_mat73, open_mat73
from hbench.store.formats.mdf import open_mdf
from hbench.store.formats.parquet import open_parquet
from hbench.store.formats.table import Table
from hbench.store.formats.tdms import open_tdms
from hbench.store.formats.text import open_text
from hbench.store.formats.twincat import is_twincat, open_twincat


@dataclass(frozen=True)
class FileFormat:
    """A format, its recognition and its reader."""

    name: str  # of messages
    endings: tuple[str, ...]  # of file names, in lower case; none: all
    open: Callable[[BinaryIO, str, Format], Table]
    package: str = ""  # that it needs, ...
    extra: str = ""  # ... which this extra of pip contains
    has_head: Callable[[bytes], bool] | None = None  # from its first _HEAD bytes, besides the name
    largest: int = LARGEST_LOG  # bytes
    is_text: bool = False


LARGEST_BINARY = 1_000_000_000  # bytes; only the mapped channels are read

# The first row that fits a file applies.
FORMATS = (
    FileFormat(
        "MATLAB 7.3",
        (".mat",),
        open_mat73,
        package="h5py",
        extra="matlab73",
        has_head=is_mat73,
        largest=LARGEST_BINARY,
    ),
    FileFormat("MATLAB up to version 7", (".mat",), open_mat),
    FileFormat("Parquet", (".parquet",), open_parquet, package="pyarrow", extra="parquet"),
    FileFormat(
        "TDMS", (".tdms",), open_tdms, package="nptdms", extra="tdms", largest=LARGEST_BINARY
    ),
    FileFormat(
        "MDF", (".mf4", ".mdf"), open_mdf, package="asammdf", extra="mdf", largest=LARGEST_BINARY
    ),
    FileFormat("Excel", (".xlsx", ".xlsm"), open_excel, package="openpyxl", extra="excel"),
    FileFormat(
        "TwinCAT Scope CSV",
        (),
        open_twincat,
        has_head=is_twincat,
        largest=LARGEST_TEXT,
        is_text=True,
    ),
    FileFormat("text", (), open_text, largest=LARGEST_TEXT, is_text=True),
)
_HEAD = 4096
_TOO_LARGE = (
    "Split the log, lower its sampling rate, or save it as TDMS, MDF or MATLAB 7.3, which may have "
    f"{LARGEST_BINARY / 1e6:g} MB."
)
_PACKED = {
    b"\x1f\x8b": "gzip",
    b"PK\x03\x04": "zip",
    b"BZh": "bzip2",
    b"\xfd7zXZ": "xz",
    b"7z\xbc": "7z",
}
_LARGEST = max(row.largest for row in FORMATS)


def format_of(file: BinaryIO, name: str) -> FileFormat:
    """Return the format of an open file by its name and its first bytes."""
    head, ending = file.read(_HEAD), name.lower()
    file.seek(0)
    return next(
        row
        for row in FORMATS
        if (not row.endings or ending.endswith(row.endings))
        and (row.has_head is None or row.has_head(head))
    )


@contextmanager
def open_foreign(path: Path) -> Iterator[tuple[BufferedReader, FileFormat]]:
    """Open a file and determine its format. Raises ``DataError``."""
    with open_file(path, _LARGEST) as file:
        file_format = format_of(file, path.name)
        if file_format.is_text:
            _refuse_packed(file, path)
        check_size(file, str(path), file_format.largest, _TOO_LARGE)
        yield file, file_format


def _refuse_packed(file: BinaryIO, path: Path) -> None:
    head = file.read(_HEAD)
    file.seek(0)
    if head.startswith(b"PK") and (b"[Content_Types].xml" in head or b"docProps/" in head):
        raise DataError(
            f"{path}: is an Office document, such as an Excel workbook",
            "Give a workbook the ending .xlsx.",
        )
    for mark, name in _PACKED.items():
        if head.startswith(mark):
            raise DataError(
                f"{path}: is compressed ({name})",
                "Unpack it, and import the folder that contains the unpacked file.",
            )


@contextmanager
def open_here(path: Path, layout: Format) -> Iterator[Table]:
    """Open a file of any format in this process; its columns can be read until the context ends.

    Raises ``DataError``, also for any other exception until then.
    """
    with open_foreign(path) as (file, file_format), reader_errors(str(path), file_format.name):
        yield file_format.open(file, str(path), layout)
