"""Reader of regular files up to a size limit, for files from untrusted sources."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from io import BufferedReader
from pathlib import Path

_AT_ONCE = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)  # does not wait for a pipe


class FileTooLarge(ValueError):
    """A file exceeds its size limit and was not read."""


@contextmanager
def open_regular_file(path: Path, largest: int) -> Iterator[BufferedReader]:
    """Open a regular file of at most ``largest`` bytes for reading.

    Raises ``OSError``, also for a pipe, a device or a folder, and ``FileTooLarge``.
    """
    handle = os.open(path, os.O_RDONLY | _AT_ONCE)
    with os.fdopen(handle, "rb") as file:
        status = os.fstat(handle)
        if not stat.S_ISREG(status.st_mode):
            raise OSError(0, "not a regular file")
        if status.st_size > largest:
            raise FileTooLarge(
                f"is {status.st_size / 1e6:.6g} MB large; limit {largest / 1e6:g} MB"
            )
        yield file


def read_regular_file(path: Path, largest: int) -> bytes:
    """Return the bytes of a regular file, at most ``largest``.

    Raises ``OSError``, also for a pipe, a device or a folder, and ``FileTooLarge``.
    """
    with open_regular_file(path, largest) as file:
        data = file.read(largest + 1)  # some grow meanwhile, or report no size
    if len(data) > largest:
        raise FileTooLarge(f"is larger than {largest / 1e6:g} MB")
    return data
