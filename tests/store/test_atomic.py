import errno
import os

import pytest

from hbench.errors import DataError
from hbench.store.files import atomic


@pytest.fixture
def full_disk(monkeypatch):
    """Make one call of the system fail as on a full disk."""

    def fail(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    return lambda name: monkeypatch.setattr(os, name, fail)


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_failed_write_leaves_the_file_as_it_was_and_nothing_beside_it(tmp_path, full_disk, call):
    path = tmp_path / "a.txt"
    atomic.write_atomic(path, b"before")
    full_disk(call)
    with pytest.raises(DataError, match="a.txt: .*No space left") as caught:
        atomic.write_atomic(path, b"after")
    assert caught.value.exit_code == 4
    assert path.read_bytes() == b"before"
    assert os.listdir(tmp_path) == ["a.txt"]


@pytest.mark.parametrize("call", ["fsync", "replace"])
def test_failed_first_write_shows_no_file(tmp_path, full_disk, call):
    full_disk(call)
    with pytest.raises(DataError):
        atomic.write_atomic(tmp_path / "runs" / "a.dat", b"x", overwrite=False)
    assert os.listdir(tmp_path / "runs") == []


def test_protected_file_is_not_overwritten(tmp_path):
    path = tmp_path / "a.dat"
    atomic.write_atomic(path, b"first", overwrite=False)
    with pytest.raises(DataError, match="a.dat"):
        atomic.write_atomic(path, b"second", overwrite=False)
    assert path.read_bytes() == b"first"


def test_failed_append_takes_back_what_was_half_written(tmp_path, full_disk):
    path = tmp_path / "journal"
    atomic.append(path, b"one\n")
    full_disk("fsync")
    with pytest.raises(DataError, match="journal"):
        atomic.append(path, b"two\n")
    assert path.read_bytes() == b"one\n"


def test_a_file_in_the_way_of_a_folder_is_named(tmp_path):
    (tmp_path / "runs").write_text("not a folder")
    with pytest.raises(DataError, match="001.dat: "):
        atomic.write_atomic(tmp_path / "runs" / "001.dat", b"")
