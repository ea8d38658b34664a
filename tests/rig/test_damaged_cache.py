"""A cache of compiled functions that is damaged, refused or write-protected ends no command."""

import importlib.util
import os
from pathlib import Path

import numba
import pytest

from hbench.model.compiled_cache import keep_on_disk


@pytest.fixture
def twice(tmp_path, monkeypatch):
    """Function that compiles a function as a new process does; returns its hits and misses."""
    source = tmp_path / "source.py"
    source.write_text("def twice(x):\n    return 2.0 * x\n")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "user"))

    def start(package=tmp_path / "package") -> tuple[int, int]:
        spec = importlib.util.spec_from_file_location("source", source)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        dispatcher = numba.njit(module.twice)
        keep_on_disk(dispatcher, module.twice, "compiled-key", package)
        assert dispatcher(1.5) == 3.0
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
