"""The decorator of every compiled function of the model."""

import os
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba

from hbench.records import friction_laws

OWN_EFFECTS = os.environ.get("HBENCH_EFFECTS", "")  # a file; see effects/rows.py

_FOLDER = Path(__file__).parent


def _cache_folder() -> str:
    """Return a folder name that changes whenever a source file of the model does.

    Numba inlines the functions that a function calls but checks only the caller's own file: an
    edited friction law would leave a stale plant in the cache. The table of friction laws gives
    them their numbers, so it is hashed like a file of the model. A file of the user's own effects,
    and those beside it, are the model's too.
    """
    sources = [*sorted(_FOLDER.rglob("*.py")), Path(friction_laws.__file__)]
    if OWN_EFFECTS:
        sources += sorted(Path(OWN_EFFECTS).resolve().parent.glob("*.py"))
    digest = zlib.crc32(OWN_EFFECTS.encode())
    for source in sources:
        digest = zlib.crc32(source.read_bytes(), digest)
    return str(_FOLDER / "__pycache__" / f"compiled-{digest:08x}")


_CACHE = _cache_folder()
_OPTIONS = {"forceinline": True, "error_model": "numpy", "nogil": True, "_nrt": False}


def compiled(function: Callable) -> Any:
    """Compile with numba, inlined into its caller and cached on disk.

    Inlining saves passing the parameters as some sixty arguments at each call. Division by zero
    gives infinity, as in numpy. Arrays come from the caller, who keeps them, and none is allocated
    or returned: so references need no counting, which would cost a third of the plant's speed.
    """
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = _CACHE
    try:
        return numba.njit(cache=True, **_OPTIONS)(function)
    finally:
        numba.config.CACHE_DIR = before


def inlined(function: Callable) -> Any:
    """Compile as ``compiled`` does a function made of others (a closure): its callers cache it."""
    return numba.njit(**_OPTIONS)(function)
