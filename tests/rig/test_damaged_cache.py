"""A cache of compiled functions that is damaged, refused or write-protected ends no command."""

import fcntl
import importlib.util
import multiprocessing
import os
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import pytest

from hbench.model import compiled_cache
from hbench.model.compiled_cache import keep_on_disk


@pytest.fixture
def twice(tmp_path, monkeypatch):
    """Function that compiles a function as a new process does; returns its hits and misses."""
    source = tmp_path / "source.py"
    source.write_text("def twice(x):\n    return 2.0 * x\n")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))

    def start(package=tmp_path / "package", x=1.5) -> tuple[int, int]:
        spec = importlib.util.spec_from_file_location("source", source)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        monkeypatch.setitem(sys.modules, "source", module)  # numba looks for it there
        dispatcher = numba.njit(module.twice)
        keep_on_disk(dispatcher, module.twice, "compiled-key", package)
        assert dispatcher(x) == 2.0 * x
        stats = dispatcher.stats
        return sum(stats.cache_hits.values()), sum(stats.cache_misses.values())

    return start


def files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*.nb?"))


@pytest.mark.parametrize(
    "damage",
    [
        lambda data: b"",
        lambda data: data[: len(data) // 2],
        lambda data: data[:-1],
        lambda data: bytes(len(data)),
        lambda data: data[: len(data) // 2] + b"\xaa" * 64 + data[len(data) // 2 + 64 :],
        lambda data: b"\x80\x04c__main__\nnothing\n." + data,
    ],
    ids=["empty", "half", "cut", "zeros", "other octets", "another pickle"],
)
def test_a_damaged_file_is_compiled_again_and_replaced(twice, tmp_path, damage):
    assert twice() == (0, 1)
    assert twice() == (1, 0)
    index, code = sorted(files(tmp_path / "package"), key=lambda path: path.suffix == ".nbc")
    for path in (code, index):
        path.write_bytes(damage(path.read_bytes()))
        assert twice() in [(0, 1), (1, 0)]  # of an index, they may be in what is not read
        assert twice() == (1, 0)
    code.write_bytes(damage(code.read_bytes()))
    assert twice() == (0, 1)


def test_a_missing_file_is_compiled_again(twice, tmp_path):
    twice()
    for path in files(tmp_path / "package"):
        kept = path.read_bytes()
        path.unlink()
        assert twice() == (0, 1)
        path.write_bytes(kept)


def test_the_cache_is_the_users_where_the_package_is_write_protected(twice, tmp_path):
    package = tmp_path / "package"
    package.mkdir()
    (package / "__pycache__").write_bytes(b"")  # root may write into any folder
    assert twice(package) == (0, 1)
    assert twice(package) == (1, 0)
    assert {path.parents[1] for path in files(tmp_path)} == {
        tmp_path / "user" / "hbench" / "compiled-key"
    }


def test_a_relative_folder_of_the_user_does_not_count(twice, tmp_path, monkeypatch):
    """As the XDG specification says; it would be another one in each working directory."""
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "package").write_bytes(b"")
    assert twice(tmp_path / "package") == (0, 1)
    assert not (tmp_path / "relative").exists()
    assert {path.parents[3] for path in files(tmp_path)} == {tmp_path / "home" / ".cache"}


def test_without_a_folder_each_process_compiles(twice, tmp_path, monkeypatch):
    (tmp_path / "nothing").write_bytes(b"")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "nothing"))
    for _ in range(2):
        assert twice(tmp_path / "nothing") == (0, 1)
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)  # no home
    assert twice(tmp_path / "nothing") == (0, 1)


def test_a_full_disk_ends_no_command(twice, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", full)
        assert twice() == (0, 1)
        assert not files(tmp_path / "package")
    assert twice() == (0, 1)
    assert twice() == (1, 0)


FORK = multiprocessing.get_context("fork")


def at_the_same_time(twice, monkeypatch, *numbers: float) -> list[tuple[int, int]]:
    """Hits and misses of processes that start together and read the index before any writes it."""
    read = compiled_cache._CheckedFiles._load_index

    def slowly(self) -> dict:
        index = read(self)
        time.sleep(0.2)
        return index

    pipes = [FORK.Pipe(duplex=False) for _ in numbers]
    with monkeypatch.context() as patch:
        patch.setattr(compiled_cache._CheckedFiles, "_load_index", slowly)
        for (_, sent), number in zip(pipes, numbers, strict=True):
            FORK.Process(target=lambda sent=sent, x=number: sent.send(twice(x=x))).start()
    for _, sent in pipes:
        sent.close()
    return [received.recv() for received, _ in pipes]


def test_one_of_the_processes_that_start_together_compiles(twice, monkeypatch):
    """Otherwise each would take 15 s of a core for the plant."""
    assert sorted(at_the_same_time(twice, monkeypatch, 1.5, 1.5)) == [(0, 1), (1, 0)]


def test_processes_that_compile_for_other_types_keep_their_own_code(twice, monkeypatch):
    """Without a lock both would write file 1, and numba would execute it for either type."""
    assert at_the_same_time(twice, monkeypatch, 1.5, 3) == [(0, 1), (0, 1)]
    assert [twice(x=1.5), twice(x=3)] == [(1, 0), (1, 0)]


def test_a_process_that_never_ends_its_compilation_is_not_waited_for_forever(
    twice, tmp_path, monkeypatch
):
    monkeypatch.setattr(compiled_cache, "_LONGEST_WAIT_S", 0.2)
    twice()
    (lock,) = (tmp_path / "package").rglob("*.lock")
    for path in files(tmp_path / "package"):
        path.unlink()
    with lock.open() as stopped:
        fcntl.flock(stopped, fcntl.LOCK_EX)
        assert twice() == (0, 1)
    assert twice() == (1, 0)


def dispatcher_of(expression: str, folder: Path):
    """Return a function of x that is kept in a package of the folder."""
    source = folder / "made.py"
    source.write_text(f"def made(x):\n    return {expression}\n")
    spec = importlib.util.spec_from_file_location("made", source)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    dispatcher = numba.njit(module.made)
    keep_on_disk(dispatcher, module.made, "compiled-key", folder / "package")
    return dispatcher


def test_threads_that_wait_for_one_function_close_its_lock_once(tmp_path, monkeypatch):
    """A second close fails, or closes a file that another thread has opened since."""
    close = os.close

    def slowly(file: int) -> None:
        time.sleep(0.05)
        close(file)

    dispatcher = dispatcher_of("0.5 * x", tmp_path)
    monkeypatch.setattr(compiled_cache.os, "close", slowly)
    with ThreadPoolExecutor(4) as threads:
        assert list(threads.map(dispatcher, [3.0] * 4)) == [1.5] * 4


def test_a_function_that_cannot_be_compiled_leaves_no_lock(tmp_path):
    dispatcher = dispatcher_of("x + 'a'", tmp_path)
    with pytest.raises(numba.core.errors.TypingError):
        dispatcher(1.5)
    (lock,) = (tmp_path / "package").rglob("*.lock")
    with lock.open() as free:
        fcntl.flock(free, fcntl.LOCK_EX | fcntl.LOCK_NB)  # raises BlockingIOError where it is held
