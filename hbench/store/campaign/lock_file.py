"""Keeps other hosts out of a campaign while one makes it."""

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hbench.errors import ConfigError, DataError

try:
    import fcntl
except ImportError:  # Windows has no such lock
    fcntl = None  # type: ignore[assignment]


@contextmanager
def only_host(folder: Path) -> Iterator[None]:
    """Hold a campaign's folder, which is made if need be; the system lets go of it with the host.

    Raises ``ConfigError`` where another host holds it.
    """
    if folder.exists() and not folder.is_dir():
        raise ConfigError(f"{folder}: is a file", "A campaign is a folder; name another.")
    made = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY) if fcntl else None
    except OSError as error:
        raise DataError(f"{folder}: can't be used: {error.strerror}") from None
    try:
        if handle is not None:
            _lock(handle, folder)
        yield
    finally:
        if handle is not None:
            os.close(handle)
        if made:
            with suppress(OSError):  # only what is empty goes
                folder.rmdir()


def _lock(handle: int, folder: Path) -> None:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EAGAIN, errno.EACCES):  # others: a file system without locks
            raise ConfigError(
                f"{folder}: another hbench is making this campaign", "Wait until it has ended."
            ) from None
