"""Runs in SI from an imported folder, before they become a campaign."""

import hashlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np

from hbench.config.import_layout import Format
from hbench.records import Outcome, RunPlan
from hbench.store.files.bounded_read import check_inside
from hbench.store.formats.opening import open_foreign
from hbench.store.formats.reading import open_table
from hbench.store.formats.table import Table


@dataclass(frozen=True)
class SourceFile:
    """A file of the imported folder."""

    name: str  # below the folder, with forward slashes
    sha256: str
    is_truncated: bool  # a text without a newline at its end


@dataclass(frozen=True)
class StoredLog:
    """A run's log that was written."""

    samples: int
    sha256: str


# Writes a run's log, given the file that it is from, the run's id and its channels in SI, named as
# in ``CHANNELS``.
StoreLog = Callable[[str, str, Mapping[str, np.ndarray]], StoredLog]


@dataclass(frozen=True)
class ImportedRun:
    """One imported run."""

    plan: RunPlan
    log: StoredLog
    file: SourceFile
    lines: tuple[int, int]  # its first and last line in the file, from 1
    outcome: Outcome = "done"  # failed: the log is known to be incomplete
    why: str = ""  # of another outcome than done
    start: datetime | None = None  # by the file's date-times, in UTC where they have no zone


@dataclass(frozen=True)
class ImportedRuns:
    """All runs of an imported folder, with notes for the user."""

    runs: tuple[ImportedRun, ...]
    notes: tuple[str, ...]
    bench: dict[str, Any] | None = None  # the header's section, if the folder has a bench file
    settings: dict[str, Any] | None = None  # the same for a settings file


@contextmanager
def open_source(folder: Path, name: str, layout: Format) -> Iterator[tuple[Table, SourceFile]]:
    """Open a file below ``folder``. Raises ``DataError``, also for a path outside ``folder``."""
    path = folder / name
    check_inside(folder, path)
    with open_table(path, layout) as table:
        yield table, describe_source(folder, name)


def describe_source(folder: Path, name: str) -> SourceFile:
    """Return the record of a file below ``folder``. Raises ``DataError``."""
    path = folder / name
    check_inside(folder, path)
    with open_foreign(path) as (file, file_format):
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
        file.seek(max(0, file.tell() - 2))
        end = file.read().strip(b"\0")[-1:]  # the zero byte is that of UTF-16
        return SourceFile(name, sha256, file_format.is_text and end not in b"\r\n")
