"""Costly values that are made once for all workers of a test session."""

import fcntl
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

folder: Path | None = None  # the session's, set by conftest.py


def once(name: str, make: Callable[[], Any]) -> Any:
    """Return what ``make`` returns; the first worker that asks for ``name`` makes it.

    Other workers wait for it and get a copy. ``name`` is that of a file.
    """
    if folder is None:
        return make()
    path = folder / f"{name}.pickle"
    with (folder / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not path.exists():
            part = path.with_suffix(".part")
            part.write_bytes(pickle.dumps(make()))
            part.rename(path)
        return pickle.loads(path.read_bytes())
