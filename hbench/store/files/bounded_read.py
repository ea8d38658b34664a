"""Reading of files up to a size limit."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path
from typing import BinaryIO

from hbench.config.files.regular_file import FileTooLarge, open_regular_file
from hbench.errors import DataError

# In bytes. Reading a log takes up to twelve times its size in memory.
LARGEST_LOG = 40_000_000  # of a run; an hour and a half of a board's log at 100 Hz
LARGEST_TEXT = 200_000_000  # of another bench; five channels for an hour at 1 kHz take 130
LARGEST_UNPACKED = 200_000_000  # what a compressed file may take in memory
LARGEST_JOURNAL = 8_000_000  # some nine thousand runs
_PART = 65_536

_TOO_LARGE = "Check that it is the right file; split a longer log."


def read_file(path: Path, largest: int = LARGEST_LOG, hint: str = "") -> bytes:
    """Return a file's bytes. Raises ``DataError``; a too large file is refused before reading."""
    with open_file(path, largest, hint) as file:
        return read_whole(file, str(path), largest)


@contextmanager
def open_file(path: Path, largest: int, hint: str = "") -> Iterator[BufferedReader]:
    """Open a regular file of at most ``largest`` bytes. Raises ``DataError``."""
    try:
        with open_regular_file(path, largest) as file:
            yield file
    except FileTooLarge as error:
        raise DataError(f"{path}: {error}", _TOO_LARGE) from None
    except OSError as error:
        raise DataError(f"{path}: {error.strerror or error}", hint) from None


def check_size(file: BinaryIO, source: str, largest: int, hint: str) -> None:
    """Raise ``DataError`` for an open file of more than ``largest`` bytes."""
    size = os.fstat(file.fileno()).st_size
    if size > largest:
        raise DataError(f"{source}: is {size / 1e6:.6g} MB large; limit {largest / 1e6:g} MB", hint)


def check_unpacked(size: int, source: str, hint: str) -> None:
    """Raise ``DataError`` for a compressed file that takes more than ``LARGEST_UNPACKED``."""
    if size > LARGEST_UNPACKED:
        raise DataError(
            f"{source}: unpacks to {size / 1e6:.6g} MB; limit {LARGEST_UNPACKED / 1e6:g} MB", hint
        )


def read_whole(file: BinaryIO, source: str, largest: int = LARGEST_LOG) -> bytes:
    """Return the bytes of an open file. Raises ``DataError`` for more than ``largest``.

    Some files grow meanwhile, or report no size, so the limit is checked while reading. One read
    of up to ``largest`` bytes would reserve them first: ten times the time of reading a run's log.
    """
    data = bytearray()
    while part := file.read(_PART):
        data += part
        if len(data) > largest:
            raise DataError(f"{source}: is larger than {largest / 1e6:g} MB", _TOO_LARGE)
    return bytes(data)


def check_inside(folder: Path, path: Path) -> None:
    """Raise ``DataError`` if ``path`` is outside ``folder``, for example through a link."""
    try:
        inside = path.resolve().is_relative_to(folder.resolve())
    except (ValueError, OSError, RuntimeError):  # a NUL, too long, or a loop of links
        raise DataError(f"{folder}: {str(path)[-60:]!r} is not a valid path") from None
    if not inside:
        raise DataError(
            f"{path}: is outside {folder}",
            "Put the file itself into the folder; links and paths out of it are refused.",
        )
