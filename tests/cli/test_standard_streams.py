"""A closed or full terminal ends no measurement; a result that is not written is an error."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from hbench.store.campaign.folder import load_campaign
from tests.support import ROOT
from tests.support.waiting import killed_in_the_end

SAMPLE = Path("stribeck-small")  # a copy: the command writes results to it
LIMITS = ROOT / "configs" / "limits.yaml"
FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.exists(), reason="no /dev/full")


def hbench(*arguments, redirections: str) -> subprocess.CompletedProcess:
    command = [sys.executable, "-m", "hbench", *map(str, arguments)]
    return subprocess.run(
        ["sh", "-c", f'exec "$@" {redirections}', "sh", *command],
        capture_output=True,
        text=True,
        cwd="/",  # the installed package, not the sources
    )


@needs_full
def test_a_result_that_a_full_disk_does_not_take_is_an_error(monkeypatch):
    # Python 3.13, or another in this mode, reports what fails as it closes its streams.
    monkeypatch.setenv("PYTHONDEVMODE", "1")
    done = hbench(
        "run", ROOT / "configs" / "demo.yaml", "--check", "--json", redirections=">/dev/full"
    )
    assert done.returncode == 4
    assert done.stderr.splitlines()[-2:] == [
        "error: stdout: can't be written: No space left on device",
        "hint: Check the free space where the output goes.",
    ]
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize(
    "redirections",
    [
        pytest.param("2>/dev/full", marks=needs_full),
        pytest.param("2>&-", marks=pytest.mark.slow),
        "<&- >&- 2>&-",
    ],
)
def test_a_measurement_goes_on_where_nothing_takes_its_messages(
    quick_schedule, tmp_path, redirections
):
    folder = tmp_path / "campaign"
    done = hbench("run", quick_schedule(), "-o", folder, redirections=redirections)
    assert done.returncode == 0
    campaign = load_campaign(folder)
    assert not campaign.warnings and not campaign.damaged()
    assert len(campaign.done) == len(campaign.entries) > 0


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["--help"], 0),
        pytest.param(["simulate"], 0, marks=pytest.mark.slow),
        (["accept", SAMPLE, "--limits", LIMITS, "--fail"], 6),
    ],
    ids=["help", "list", "verdict"],
)
def test_a_reader_that_has_ended_does_not_change_the_exit_code(tmp_path, arguments, code):
    shutil.copytree(ROOT / "data_samples" / SAMPLE, tmp_path / SAMPLE)
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-m", "hbench", *map(str, arguments)],
        stdout=writing,
        stderr=subprocess.PIPE,
        text=True,
        cwd=tmp_path,
    )
    os.close(writing)
    assert (done.returncode, done.stderr) == (code, "")


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no choice of a core")
@pytest.mark.parametrize("times", [2, pytest.param(20, marks=pytest.mark.slow)])
def test_what_an_interrupt_follows_at_once_is_written_once(times):
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(cores)})  # so that the reader runs before the writer goes on
    try:
        for _ in range(times):
            started = subprocess.Popen(
                [sys.executable, "-m", "hbench", "rig", "--socket", "localhost:0"],
                stdout=subprocess.PIPE,
                text=True,
                cwd="/",
            )
            with killed_in_the_end(started) as process:
                assert process.stdout.readline().startswith("socket://")
                process.send_signal(signal.SIGINT)
                assert process.communicate(timeout=60.0)[0] == ""
                assert process.returncode == 0
    finally:
        os.sched_setaffinity(0, cores)
