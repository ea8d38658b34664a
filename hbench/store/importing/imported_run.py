"""What both ways of import hand on: runs in SI, not yet in a campaign."""

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
        """Hash of its bytes."""
        return hashlib.sha256(self.data).hexdigest()


@dataclass(frozen=True)
class ForeignRun:
    """One run to be imported."""

    plan: RunPlan
    channels: dict[str, np.ndarray]  # in SI, named as in ``importmap.CHANNELS``
    file: SourceFile
    lines: tuple[int, int]  # first and last line of it in the file, from 1


@dataclass(frozen=True)
class ForeignRuns:
    """All runs of an imported folder, and what is to be told of them."""

    runs: tuple[ForeignRun, ...]
    notes: tuple[str, ...]
    bench: dict[str, Any] | None = None  # the header's bench part, where the folder has one


def read_source(folder: Path, name: str) -> SourceFile:
    """Read a file below ``folder``. Raises ``DataError``, also for a path that leaves it."""
    path = folder / name
    check_inside(folder, path)
    return SourceFile(name, read_file(path))
