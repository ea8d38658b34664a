"""A disk that takes no more: an error that names the file, and no half output under its name.

The system's limit of a file's size takes the place of the disk.
"""

import os
import resource
import subprocess
import sys
from datetime import UTC, datetime

import numpy as np
import pytest
import yaml

from hbench.errors import DataError
from hbench.records import RunPlan, Specimen
from hbench.store.campaign.writer import CampaignWriter
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


def test_a_campaign_that_a_full_disk_ends_is_continued_with_resume(tmp_path):
    """The header fits; the log of the first run does not."""
    plan = RunPlan("0001", "steady", 1, 0.05, Specimen(1e-3, 6e-4))
    at = datetime(2026, 1, 1, tzinfo=UTC)
    header = {"name": "full", "source": "simulated", "created": at.isoformat()}
    writer = CampaignWriter.create(tmp_path / "campaign", header)
    writer.start_run(plan, at)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (8192, hard))
    try:
        with pytest.raises(DataError, match="0001.dat: can't be written: File too large") as found:
            writer.finish_run(plan, np.zeros((9000, 20), dtype=np.uint16), "done", "", at)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert found.value.hint.endswith("Then continue with --resume.")


@pytest.mark.parametrize("value", ["abc", "", "-5", "1e9", "9" * 300])
def test_a_source_date_that_is_no_time_is_refused_before_any_library_reads_it(tmp_path, value):
    done = subprocess.run(
        [sys.executable, "-m", "hbench", "report", str(SAMPLE)],
        capture_output=True,
        text=True,
        env=os.environ | {"SOURCE_DATE_EPOCH": value},
        cwd=tmp_path,
    )
    assert done.returncode == 2
    assert done.stderr.startswith("error: SOURCE_DATE_EPOCH is ")
    assert "hint: " in done.stderr and "Traceback" not in done.stderr
