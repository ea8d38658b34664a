"""Lock of a folder, such as a campaign's, which excludes other hosts while one writes to it."""

import errno
import os
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path

from hbench.errors import ConfigError, DataError
from hbench.store.files.atomic import make_folder

try:
    import fcntl
except ImportError:  # Windows has no such lock
    fcntl = None  # type: ignore[assignment]


def campaign_lock(folder: Path) -> AbstractContextManager[None]:
    """Lock a campaign's folder. Raises ``ConfigError`` if it is locked."""
    return folder_lock(folder, f"{folder}: another hbench is writing this campaign")


@contextmanager
def folder_lock(folder: Path, locked: str) -> Iterator[None]:
    """Lock a folder, created if missing; the system releases it when the host ends.

    Created folders that stay empty are removed. Raises ``ConfigError`` with the message ``locked``
    if it is locked.
    """
    if folder.exists() and not folder.is_dir():
        raise ConfigError(f"{folder}: is a file", "Give a folder as the campaign's name.")
    created = [path for path in (folder, *folder.parents) if not path.exists()]
    try:
        make_folder(folder)
        handle = os.open(folder, os.O_RDONLY) if fcntl else None
    except OSError as error:
        raise DataError(
            f"{folder}: can't be created or opened: {error.strerror}",
            "Give another folder, or check the permissions of the one above it.",
        ) from None
    try:
        if handle is not None:
            _lock(handle, locked)
        yield
    finally:
        if handle is not None:
            os.close(handle)
        with suppress(OSError):  # removes empty folders only
            for path in created:
                path.rmdir()


def _lock(handle: int, locked: str) -> None:
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EAGAIN, errno.EACCES):  # others: a file system without locks
            raise ConfigError(locked, "Wait until it has ended.") from None
