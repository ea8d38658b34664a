"""The decorators of compiled functions."""

import os
import sys
import zlib
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

from hbench.records import friction_laws

OWN_EFFECTS = os.environ.get("HBENCH_EFFECTS", "")  # a file; see effects/rows.py

_FOLDER = Path(__file__).parent


def cache_key(folder: Path, others: Iterable[Path], own_effects: str) -> str:
    """Return a key that changes whenever a source file of the compiled model does.

    The sources are the Python files below ``folder``, ``others``, and the file ``own_effects`` of
    the user's own effects with those beside it. Numba inlines the functions that a function calls
    but checks only the caller's own file: an edited friction law would leave a stale plant in the
    cache.
    """
    sources = [*sorted(folder.rglob("*.py")), *others]
    if own_effects:
        sources += sorted(Path(own_effects).resolve().parent.glob("*.py"))
    digest = zlib.crc32(own_effects.encode())
    for source in sources:
        digest = zlib.crc32(source.read_bytes(), digest)
    return f"{digest:08x}"


_OTHERS = (Path(friction_laws.__file__),)  # the order of its laws gives their numbers
_CACHE = f"compiled-{cache_key(_FOLDER, _OTHERS, OWN_EFFECTS)}"
_OPTIONS = {
    "forceinline": True,
    "error_model": "numpy",
    "nogil": True,
    "_nrt": False,
    "fastmath": {"contract"},
}


def compiled(function: Callable) -> Any:
    """Compile a function that Python calls, and cache it on disk.

    Division by zero gives infinity, as in numpy. Arrays come from the caller, who keeps them, and
    none is allocated or returned: so references need no counting, which would cost a third of the
    plant's speed. A product and a sum are one operation with one rounding where the processor has
    it; that saves 4 % of a tick. No sum is reordered, and x + 0 y remains x.
    """
    import numba  # takes 0.4 s, and most commands compile nothing

    from hbench.model.compiled_cache import keep_on_disk

    # Vectors that are loaded from numbers just stored wait for them: 3 % of the plant's time.
    numba.config.LOOP_VECTORIZE = 0
    while _waiting:
        _inline(_waiting.pop())
    dispatcher = numba.njit(**_OPTIONS)(function)
    keep_on_disk(dispatcher, function, _CACHE, _FOLDER)
    return dispatcher


def inlined(function: Callable) -> Callable:
    """Compile a function into each compiled function that calls it, as ``compiled`` does.

    Inlining saves passing the parameters as some sixty arguments at each call. Python that calls
    the function runs it uncompiled: code that unpacks the parameters from Python objects would
    double the time of compiling the plant.
    """
    if "numba" in sys.modules:
        _inline(function)
    else:
        _waiting.append(function)
    return function


_waiting: list[Callable] = []  # functions to inline, until the first function is compiled


def _inline(function: Callable) -> None:
    from numba.extending import register_jitable

    register_jitable(no_cpython_wrapper=True, no_cfunc_wrapper=True, **_OPTIONS)(function)
