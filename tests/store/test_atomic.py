import errno
import os
import subprocess
import sys
from contextlib import suppress

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


WRITER = """
import sys
from pathlib import Path
from hbench.store.files.atomic import write_files

data = sys.argv[2].encode() * 300_000
for _ in range(40):
    write_files(Path(sys.argv[1]), {"one": data, "below/two": data})
"""


def test_two_processes_write_the_same_files_one_after_the_other(tmp_path):
    both = [
        subprocess.Popen([sys.executable, "-c", WRITER, tmp_path, name], stderr=subprocess.PIPE)
        for name in "ab"
    ]
    seen = set()
    while any(process.poll() is None for process in both):
        with suppress(FileNotFoundError):
            data = (tmp_path / "one").read_bytes()
            assert len(data) == 300_000 and len(set(data)) == 1
            seen.add(data[:1])
    for process in both:
        _, told = process.communicate()
        assert process.returncode == 0, told.decode()
    assert seen == {b"a", b"b"}
    assert not list(tmp_path.rglob(".*"))


@pytest.mark.parametrize("inside", [False, True])
def test_a_file_in_the_way_is_no_lack_of_space(tmp_path, inside):
    (tmp_path / "taken").write_text("kept")
    with pytest.raises(DataError) as error:
        atomic.write_files(
            tmp_path / "taken" / "sub" if inside else tmp_path / "taken", {"a": b"1"}
        )
    assert "in the way" in error.value.hint
    assert (tmp_path / "taken").read_text() == "kept"


def test_a_name_that_is_too_long_is_no_lack_of_space(tmp_path):
    with pytest.raises(DataError) as refused:
        atomic.write_atomic(tmp_path / f"{'x' * 300}.pdf", b"")
    assert "File name too long" in refused.value.message
    assert refused.value.hint == "Choose a shorter name."


def test_a_file_that_another_program_takes_away_is_no_lack_of_space(tmp_path):
    """Two exports into the same folder have the same temporary names."""
    with pytest.raises(DataError) as refused, atomic.whole_file(tmp_path / "runs.csv") as file:
        file.write(b"1")
        (tmp_path / ".runs.csv.part").unlink()
    assert refused.value.message == f"{tmp_path / 'runs.csv'}: can't be written: " + (
        "No such file or directory"
    )
    assert refused.value.hint.startswith("Another program moved or removed it.")


def test_figures_that_an_earlier_document_alone_had_are_removed(tmp_path):
    files = {f"figures/{name}": b"1" for name in ("a.svg", "a.png", "a.csv", "old.svg", "old.csv")}
    atomic.write_document(tmp_path, files | {"page.json": b""}, "page.json")
    for name in ("notes.txt", "photo.png", "sketch.svg"):
        (tmp_path / "figures" / name).write_text("mine")
    new = {"figures/a.svg": b"2", "figures/a.csv": b"2", "page.json": b""}
    atomic.write_document(tmp_path, new, "page.json")
    names = {path.name for path in (tmp_path / "figures").iterdir()}
    assert names == {"a.svg", "a.csv", "a.png", "notes.txt", "photo.png", "sketch.svg"}


def test_figures_of_a_folder_without_the_document_are_kept(tmp_path):
    (tmp_path / "figures").mkdir()
    (tmp_path / "figures" / "mine.svg").write_text("")
    atomic.write_document(tmp_path, {"page.json": b""}, "page.json")
    assert (tmp_path / "figures" / "mine.svg").exists()
