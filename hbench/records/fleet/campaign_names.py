"""Names of campaigns: their folders' names, with as much of the path as makes them distinct."""

import os
from collections import Counter
from collections.abc import Sequence
from pathlib import PurePath


def folder_name(path: str) -> str:
    """Return the last part of a campaign's path."""
    return PurePath(path).name or path


def distinct_names(paths: Sequence[str]) -> dict[str, str]:
    """Return the folder's name of each path.

    Where several folders have this name, it is the path below the parent of all folders.
    """
    counts = Counter(map(folder_name, paths))
    if len(counts) == len(paths):
        return {path: folder_name(path) for path in paths}
    parent = os.path.commonpath(paths)
    return {
        path: folder_name(path) if counts[folder_name(path)] == 1 else os.path.relpath(path, parent)
        for path in paths
    }
