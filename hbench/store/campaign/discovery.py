"""Finds campaign folders, and tells by a glance whether one has changed."""

import glob
import hashlib
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress

from hbench.store.campaign.folder import JOURNAL


def find_campaigns(places: Iterable[str], tell: Callable[[str], None]) -> Iterator[str]:
    """Yield the paths of campaign folders in each place: a folder, a pattern, or a campaign itself.

    Folders are searched to any depth; links in them are not followed. A folder that can't be read
    is yielded, so that its reason is found. ``tell`` is given each place that holds none.
    """
    for place in places:
        count = 0
        literal = os.path.lexists(place) or not glob.has_magic(place)
        for match in [place] if literal else glob.iglob(place, recursive=True):
            for path in _below(os.path.abspath(match)):
                count += 1
                yield path
        if not count:
            tell(f"{place}: holds no campaign")


def fingerprint(folder: str, made_by: str) -> str:
    """Return a hash of the names, sizes and times of a campaign's files, and of ``made_by``.

    No file is read: one that was changed, and kept its size and time, is not noticed.
    """
    files: list[tuple] = [_stat(os.path.join(folder, JOURNAL))]
    with suppress(OSError), os.scandir(os.path.join(folder, "runs")) as entries:
        files += sorted((entry.name, *_stat(entry.path)) for entry in entries)
    text = repr((made_by, files)).encode("utf-8", "surrogateescape")
    return hashlib.sha256(text).hexdigest()[:32]


def _stat(path: str) -> tuple[int, ...]:
    try:
        found = os.stat(path)
    except OSError as error:
        return (error.errno or -1,)
    return found.st_size, found.st_mtime_ns


def _below(top: str) -> Iterator[str]:
    folders = iter([top])
    waiting: list[Iterator[str]] = []
    while True:
        for folder in folders:
            if _is_campaign(folder):
                yield folder
                continue
            try:
                inside = _folders_in(folder)
            except (NotADirectoryError, FileNotFoundError):
                continue
            except OSError:
                yield folder
                continue
            waiting.append(folders)
            folders = inside
            break
        else:
            if not waiting:
                return
            folders = waiting.pop()


def _folders_in(folder: str) -> Iterator[str]:
    entries = os.scandir(folder)  # names are read as they are asked for
    return (entry.path for entry in entries if entry.is_dir(follow_symlinks=False))


def _is_campaign(folder: str) -> bool:
    """Tell whether it has a journal, or logs whose journal is missing."""
    return os.path.lexists(os.path.join(folder, JOURNAL)) or os.path.isdir(
        os.path.join(folder, "runs")
    )
