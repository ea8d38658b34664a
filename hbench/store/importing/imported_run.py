"""Runs in SI from an imported folder, before they are written to a campaign."""

import hashlib
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from hbench.records import RunPlan
from hbench.store.files.bounded_read import check_inside, read_file


@dataclass(frozen=True)
class SourceFile:
    """A file of the imported folder."""

    name: str  # below the folder, with forward slashes
    data: bytes = field(repr=False)

    @cached_property
    def sha256(self) -> str:
        """Checksum of the file."""
        return hashlib.sha256(self.data).hexdigest()


@dataclass(frozen=True)
class ImportedRun:
    """One imported run."""

    plan: RunPlan
    channels: dict[str, np.ndarray]  # in SI, named as in ``import_layout.CHANNELS``
    file: SourceFile
    lines: tuple[int, int]  # its first and last line in the file, from 1


@dataclass(frozen=True)
class ImportedRuns:
    """All runs of an imported folder, with notes for the user."""

    runs: tuple[ImportedRun, ...]
    notes: tuple[str, ...]
    bench: dict[str, Any] | None = None  # the header's section, if the folder has a bench file


def read_source(folder: Path, name: str) -> SourceFile:
    """Read a file below ``folder``. Raises ``DataError``, also for a path outside ``folder``."""
    path = folder / name
    check_inside(folder, path)
    return SourceFile(name, read_file(path))
