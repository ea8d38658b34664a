"""Search for campaign folders, and a quick test of whether one has changed."""

import glob
import hashlib
import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress

from hbench.store.campaign.folder import JOURNAL

_INDICES = ("runs.csv", "runs.parquet")  # of exported logs, which are in runs/ too


def find_campaigns(patterns: Iterable[str], note: Callable[[str], None]) -> Iterator[str]:
    """Yield the paths of all campaign folders.

    Each of ``patterns`` is a campaign, a folder that contains campaigns, or a glob pattern.
    Folders are searched to any depth; links in them are not followed. Exported logs are no
    campaign. An unreadable folder is yielded too, so that reading it reports the reason. ``note``
    gets a message for each pattern without a campaign.
    """
    for pattern in patterns:
        count = 0
        literal = os.path.lexists(pattern) or not glob.has_magic(pattern)
        for match in [pattern] if literal else glob.iglob(pattern, recursive=True):
            for path in _campaigns_below(os.path.abspath(match)):
                count += 1
                yield path
        if not count:
            note(f"{pattern}: contains no campaign")


def fingerprint(folder: str, settings: str) -> str:
    """Return a hash of the names, sizes and times of a campaign's files, and of ``settings``.

    No file is read: a change that keeps a file's size and time goes unnoticed.
    """
    files: list[tuple] = [_stat(os.path.join(folder, JOURNAL))]
    with suppress(OSError), os.scandir(os.path.join(folder, "runs")) as entries:
        files += sorted((entry.name, *_stat(entry.path)) for entry in entries)
    text = repr((settings, files)).encode("utf-8", "surrogateescape")
    return hashlib.sha256(text).hexdigest()[:32]


def _stat(path: str) -> tuple[int, ...]:
    try:
        status = os.stat(path)
    except OSError as error:
        return (error.errno or -1,)
    return status.st_size, status.st_mtime_ns


def _campaigns_below(top: str) -> Iterator[str]:
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
    """Return whether the folder has a journal, or logs whose journal is missing."""

    def has(name: str) -> bool:
        return os.path.lexists(os.path.join(folder, name))

    if has(JOURNAL):
        return True
    return os.path.isdir(os.path.join(folder, "runs")) and not any(map(has, _INDICES))
