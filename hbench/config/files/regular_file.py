"""Reads a file that anybody may have written: a regular one, and no more of it than is allowed."""

import os
import stat
from pathlib import Path

_AT_ONCE = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)  # a pipe is not waited for


class NoSuchSize(ValueError):
    """A file is larger than any of its kind; it was not read."""


def read_regular(path: Path, largest: int) -> bytes:
    """Return the bytes of a regular file, at most ``largest``.

    Raises ``OSError``, also for a pipe, a device or a folder, and ``NoSuchSize``.
    """
    handle = os.open(path, os.O_RDONLY | _AT_ONCE)
    with os.fdopen(handle, "rb") as file:
        status = os.fstat(handle)
        if not stat.S_ISREG(status.st_mode):
            raise OSError(0, "not a regular file")
        if status.st_size > largest:
            raise NoSuchSize(f"is {status.st_size / 1e6:.6g} MB large; limit {largest / 1e6:g} MB")
        data = file.read(largest + 1)  # some grow while they are read, or don't tell their size
    if len(data) > largest:
        raise NoSuchSize(f"is larger than {largest / 1e6:g} MB")
    return data
