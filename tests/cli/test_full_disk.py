"""A disk that takes no more: an error that names the file, and no half output under its name.

The system's limit of a file's size takes the place of the disk.
"""

import resource
import subprocess
import sys

import pytest
import yaml

from tests.support import ROOT
from tests.support.certificates import FILE, LIMITS

SAMPLE = ROOT / "data_samples" / "stribeck-small"


def hbench(folder, largest_bytes, *arguments):
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (largest_bytes, largest_bytes))

    return subprocess.run(
        [sys.executable, "-m", "hbench", *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=folder,
        preexec_fn=limit,
    )


def test_an_init_that_the_disk_interrupts_leaves_nothing_and_can_be_repeated(tmp_path):
    done = hbench(tmp_path, 4096, "init", "mine")
    assert done.returncode == 4
    assert done.stderr.startswith("error: mine/bench-aau.yaml: can't be written: File too large")
    assert not list(tmp_path.rglob("*.*"))
    assert hbench(tmp_path, 10**6, "init", "mine").returncode == 0


def test_a_half_archive_is_no_campaign_and_the_command_can_be_repeated(tmp_path):
    (tmp_path / "limits.yaml").write_text(LIMITS)
    certificate = FILE | {"limits": "limits.yaml"}
    (tmp_path / "with.yaml").write_text(yaml.safe_dump(certificate, allow_unicode=True))
    before = {path.name for path in tmp_path.iterdir()}
    command = ("certificate", SAMPLE, "--with", "with.yaml", "-o", "crate")
    done = hbench(tmp_path, 100_000, *command)
    assert done.returncode == 4
    assert "can't be written: File too large" in done.stderr
    assert {path.name for path in tmp_path.iterdir()} == before
    assert hbench(tmp_path, 10**8, *command).returncode == 0


@pytest.mark.parametrize(
    "command",
    [
        ("fleet", SAMPLE, "-o", "taken"),
        ("reconcile", SAMPLE, "--model", ROOT / "configs" / "model-aau.yaml", "-o", "taken"),
    ],
    ids=["fleet", "reconcile"],
)
def test_a_file_in_the_way_of_a_folder_is_named_with_what_to_do(tmp_path, command):
    (tmp_path / "taken").write_text("mine")
    done = hbench(tmp_path, 10**8, *command)
    assert done.returncode == 4
    assert "error: taken" in done.stderr and "can't be written: File exists" in done.stderr
    assert "hint: Choose another path" in done.stderr
    assert (tmp_path / "taken").read_text() == "mine"
