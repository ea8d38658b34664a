"""Compiled functions on disk; whatever happened to them there, a command runs.

Numba keeps them in a folder. A power cut or a full disk damages files in it, and the folder of an
installed package may be write-protected. Numba would then end each further call with an error, take
a cache that knows nothing of edited models, or execute a damaged function.

The plant takes some 15 s to compile. A lock file lets one process compile a function, while others
that need it wait. Of two that compile it at the same time for arguments of different types, one
would replace the other's machine code, and numba would execute it for both.
"""

import os
import pickle
import time
from collections.abc import Callable
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from threading import Lock
from typing import Any

import numba
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    UserProvidedCacheLocator,
)

try:
    import fcntl
except ImportError:  # Windows has no such lock
    fcntl = None  # type: ignore[assignment]

_DIGEST = sha256().digest_size
_LONGEST_WAIT_S = 120.0  # for a process that may have been stopped
_POLL_S = 0.05


def keep_on_disk(dispatcher: Any, function: Callable, name: str, package: Path) -> None:
    """Let a compiled function be kept in the folder ``name`` of a cache.

    The cache is that of the ``package``, or the user's where that is write-protected. Without
    either, each process compiles the function.
    """
    before = numba.config.CACHE_DIR
    try:
        for folder in (package / "__pycache__", *_users()):
            numba.config.CACHE_DIR = str(folder / name)
            with suppress(RuntimeError):  # numba found no writable folder
                cache = dispatcher._cache = _Cache(function)
                dispatcher.compile = cache.unlocking(dispatcher.compile)
                return
    finally:
        numba.config.CACHE_DIR = before


def _users() -> list[Path]:
    given = Path(os.environ.get("XDG_CACHE_HOME", ""))  # a relative one does not count
    with suppress(RuntimeError):  # no home
        return [(given if given.is_absolute() else Path.home() / ".cache") / "hbench"]
    return []


class _InOneFolder(CompileResultCacheImpl):
    """Numba's serialization, without the other folders that numba would choose."""

    _locator_classes = [UserProvidedCacheLocator]


class _CheckedFiles(IndexDataCacheFile):
    """The files of a function: an index by signature, and machine code with a checksum.

    What is damaged counts as missing.
    """

    def _load_index(self) -> dict:
        try:
            return super()._load_index()
        except Exception:  # whatever pickle makes of any bytes
            return {}

    def _save_data(self, name: str, data: Any) -> None:
        content = self._dump(data)
        with self._open_for_write(self._data_path(name)) as file:
            file.write(sha256(content).digest() + content)

    def _load_data(self, name: str) -> Any:
        data = Path(self._data_path(name)).read_bytes()
        digest, content = data[:_DIGEST], data[_DIGEST:]
        if sha256(content).digest() != digest:
            raise OSError(f"{name}: is damaged")  # the caller takes the file for missing
        return pickle.loads(content)


class _Cache(FunctionCache):
    """Numba's cache of a function, with these files; a disk that refuses them is no error."""

    _impl_class = _InOneFolder

    def __init__(self, function: Callable):
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = _CheckedFiles(self._cache_path, self._impl.filename_base, stamp)
        self._lock: int | None = None  # a file descriptor, while this process compiles
        self._unlocking = Lock()  # threads that waited for the same function end together

    def load_overload(self, *signature: Any) -> Any:
        """Return the function from disk; None if it is missing, and then the cache is locked."""
        found = self._load(signature)
        if found is None:
            self._wait_and_lock()
            found = self._load(signature)  # another process may have compiled it
        return found

    def _load(self, signature: tuple) -> Any:
        with suppress(OSError):
            return super().load_overload(*signature)
        return None

    def save_overload(self, *compiled: Any) -> None:
        with suppress(OSError):
            super().save_overload(*compiled)

    def unlocking(self, compile_signature: Callable) -> Callable:
        """Return numba's ``compile`` that unlocks the cache at its end, also after an error."""

        def compile_and_unlock(signature: Any) -> Any:
            try:
                return compile_signature(signature)
            finally:
                self._unlock()

        return compile_and_unlock

    def _wait_and_lock(self) -> None:
        """Lock the function for this process; the system unlocks it when the process ends."""
        if fcntl is None:
            return
        last = time.monotonic() + _LONGEST_WAIT_S
        path = Path(self._cache_path) / f"{self._impl.filename_base}.lock"
        with suppress(OSError):  # a write-protected folder, or a file system without locks
            self._lock = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
            while True:
                try:
                    fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    return
                except BlockingIOError:
                    if time.monotonic() > last:
                        return
                    time.sleep(_POLL_S)

    def _unlock(self) -> None:
        with self._unlocking:
            if self._lock is not None:
                os.close(self._lock)
                self._lock = None
