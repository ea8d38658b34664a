"""Atomic writing: a file is written completely or not at all."""

import errno
import os
import shutil
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from hbench.errors import DataError
from hbench.store.files.bounded_read import check_inside

try:
    import fcntl
except ImportError:  # Windows has no such lock
    fcntl = None  # type: ignore[assignment]


def make_folder(path: Path) -> None:
    """Create a folder and its missing parents, and flush their entries to disk.

    Raises ``OSError``. Without a flush, a power failure can lose a folder with flushed files in it.
    """
    missing = [folder for folder in (path, *path.parents) if not folder.exists()]
    path.mkdir(parents=True, exist_ok=True)
    for folder in reversed(missing):
        with suppress(PermissionError):  # entries may be made in a folder that can't be opened
            _flush_folder(folder.parent)


def write_atomic(path: Path, data: bytes, *, overwrite: bool = True, lasting: bool = True) -> None:
    """Write ``data`` to ``path``: a temporary file beside it, flushed to disk, then renamed.

    A file that is not ``lasting`` is not flushed; a power failure can lose it. Raises ``DataError``
    naming the path if the disk refuses, or if ``path`` exists and ``overwrite`` is False. Then
    ``path`` is unchanged.
    """
    if not overwrite and path.exists():
        raise DataError(f"{path}: exists already; raw logs are never overwritten")
    with whole_file(path, lasting=lasting) as file:
        file.write(data)


@contextmanager
def whole_file(path: Path, *, lasting: bool = True) -> Iterator[IO[bytes]]:
    """Open a temporary file that replaces ``path`` after the last write, as ``write_atomic``."""
    with _replacement(path, lasting=lasting) as file:
        yield file
    if lasting:
        _flush_entries(path.parent)


@contextmanager
def _replacement(path: Path, *, lasting: bool) -> Iterator[IO[bytes]]:
    """Open a temporary file that then replaces ``path``; the folder's entry is not flushed."""
    part = path.with_name(f".{path.name}.part")
    try:
        make_folder(path.parent)
        part.unlink(missing_ok=True)
        with part.open("xb") as file:  # "x" refuses a link in its place
            yield file
            if lasting:
                _flush(file)
        os.replace(part, path)
    except OSError as error:
        raise refused(path, error) from error
    finally:
        with suppress(OSError):
            part.unlink(missing_ok=True)


@contextmanager
def new_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file that does not exist for writing; flush it to disk. Raises ``DataError``."""
    try:
        make_folder(path.parent)
        with path.open("xb") as file:
            yield file
            _flush(file)
    except OSError as error:
        raise refused(path, error) from error


@contextmanager
def temporary_folder(path: Path) -> Iterator[None]:
    """Remove the folder ``path`` and its files before and after; other folders stay as they are.

    Its parents that are missing are removed too where they are empty. Raises ``DataError``.
    """
    missing = [folder for folder in path.parents if not folder.exists()]
    try:
        if path.exists():  # from an import that was killed
            shutil.rmtree(path)  # refuses a link
    except OSError as error:
        raise refused(path, error) from error
    try:
        yield
    finally:
        shutil.rmtree(path, ignore_errors=True)
        with suppress(OSError):
            for folder in missing:
                folder.rmdir()


def move_folder(source: Path, destination: Path) -> None:
    """Move a folder to where nothing is, and flush the move to disk. Raises ``DataError``."""
    try:
        source.rename(destination)
        _flush_folder(destination.parent)
    except OSError as error:
        raise refused(destination, error) from error


def move_files(source: Path, destination: Path) -> None:
    """Move the files of a folder, replacing those of the same name, and flush the moves to disk.

    Raises ``DataError``.
    """
    try:
        make_folder(destination)
        for path in sorted(source.iterdir()):
            os.replace(path, destination / path.name)
        _flush_folder(destination)
    except OSError as error:
        raise refused(destination, error) from error


def write_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write files, named by their paths below ``folder``, each atomically.

    The folders' entries are flushed to disk once, after the last file. Waits while another process
    does this in the same folder. Raises ``DataError``, also for a path out of ``folder``.
    """
    with _only_writer(folder):
        for name, data in files.items():
            check_inside(folder, (folder / name).parent)
            with _replacement(folder / name, lasting=True) as file:
                file.write(data)
        for parent in {(folder / name).parent for name in files}:
            _flush_entries(parent)


def write_document(folder: Path, files: Mapping[str, bytes], written: str) -> None:
    """Write files as ``write_files``, and remove figures that an earlier document alone had.

    ``written`` is a file that each such document has: without it the figures are those of others.
    """
    if (folder / written).is_file():
        drawn = {Path(name).stem for name in files if name.startswith("figures/")}
        remove_files(folder, {name for name in figures_in(folder) if Path(name).stem not in drawn})
    write_files(folder, files)


def figures_in(folder: Path) -> set[str]:
    """Return the figures of a document in a folder and their data, by their paths below it.

    Each has both; other files in the folder, such as photos, are the user's own.
    """
    kinds = (".svg", ".png", ".csv")
    every = [path for path in (folder / "figures").glob("*") if path.suffix in kinds]
    drawn, data = (
        {path.stem for path in every if path.suffix == kind} for kind in (".svg", ".csv")
    )
    return {f"figures/{path.name}" for path in every if path.stem in drawn & data}


@contextmanager
def _only_writer(folder: Path) -> Iterator[None]:
    """Wait for other processes that write files of a folder: all use the same temporary names."""
    handle = None
    try:
        make_folder(folder)
        if fcntl:
            with suppress(PermissionError):  # a folder of others, in which files may be written
                handle = os.open(folder, os.O_RDONLY)
                with suppress(OSError):  # a file system without locks
                    fcntl.flock(handle, fcntl.LOCK_EX)
    except OSError as error:
        raise refused(folder, error) from error
    try:
        yield
    finally:
        if handle is not None:
            os.close(handle)


def remove_files(folder: Path, names: Iterable[str]) -> None:
    """Remove the files that exist, named by their paths below ``folder``.

    Raises ``DataError``, also for a path that leads out of ``folder``.
    """
    for name in sorted(names):
        check_inside(folder, (folder / name).parent)
        try:
            (folder / name).unlink(missing_ok=True)
        except OSError as error:
            raise refused(folder / name, error) from error


def append(path: Path, data: bytes) -> None:
    """Append ``data`` to ``path`` and flush it to disk.

    Raises ``DataError``, after removing a half-written part if the disk permits it.
    """
    length = path.stat().st_size if path.exists() else 0
    try:
        with path.open("ab") as file:
            file.write(data)
            _flush(file)
    except OSError as error:
        with suppress(OSError):
            os.truncate(path, length)
        raise refused(path, error) from error


def rename(path: Path, name: str) -> None:
    """Give a file another name in its folder. Raises ``DataError``."""
    try:
        path.rename(path.with_name(name))
    except OSError as error:
        raise refused(path, error) from error


def truncate(path: Path, length: int) -> None:
    """Cut a file to ``length`` bytes and flush it to disk. Raises ``DataError``."""
    try:
        with path.open("r+b") as file:
            file.truncate(length)
            _flush(file)
    except OSError as error:
        raise refused(path, error) from error


def _flush(file: IO[bytes]) -> None:
    file.flush()
    os.fsync(file.fileno())


def refused(path: Path, error: OSError) -> DataError:
    """Return the error of a path at which the operating system refuses to write."""
    hint = "Check the free space and the folder's permissions."
    if error.errno in (errno.EEXIST, errno.ENOTDIR, errno.EISDIR, errno.ELOOP):
        hint = "Choose another path: a file, folder or link of this name is in the way."
    elif error.errno == errno.ENAMETOOLONG:
        hint = "Choose a shorter name."
    elif error.errno == errno.ENOENT:  # its folder was there: see ``make_folder``
        hint = "Another program moved or removed it. Repeat the command when that one has ended."
    return DataError(f"{path}: can't be written: {error.strerror or error}", hint)


def _flush_entries(folder: Path) -> None:
    """Flush the names of a folder's files to disk. Raises ``DataError``."""
    try:
        _flush_folder(folder)
    except OSError as error:
        raise refused(folder, error) from error


def _flush_folder(folder: Path) -> None:
    if os.name != "posix":  # other systems can't open a folder
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
