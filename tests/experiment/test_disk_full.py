"""A full disk stops the bench first, ends in exit code 4, and costs the run in progress alone."""

import errno
import os
import re
import subprocess
import sys

import pytest

from hbench.errors import DataError, ExitCode
from hbench.protocol.dictionary import FAULTS, STATES
from hbench.rig import virtual
from hbench.rig.client import BoardClient
from hbench.store.campaign.folder import load_campaign
from hbench.store.files import atomic
from tests.support.faults.fault_story import check_against_board, check_nothing_rewritten
from tests.support.faults.faulty_line import Script, World, attempts
from tests.support.rig_campaign import measure_on_rig


@pytest.fixture
def world(quick_experiment, monkeypatch):
    world = World(quick_experiment.bench, Script())
    monkeypatch.setattr(virtual, "VirtualRig", lambda *_: world.open())
    return world


@pytest.fixture
def measure(quick_experiment, tmp_path, clock):
    def run(resume=False):
        return measure_on_rig(quick_experiment, tmp_path / "campaign", resume=resume, clock=clock)

    return run


def full_from(write, patch):
    """The disk takes half of the ``write``-th write, and nothing after it."""
    writes = iter(range(10**6))

    def flush(file):
        before = os.fstat(file.fileno()).st_size
        file.flush()
        if (count := next(writes)) >= write:
            size = os.fstat(file.fileno()).st_size
            os.ftruncate(file.fileno(), before + (size - before) // 2 if count == write else before)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    patch.setattr(atomic, "_flush", flush)


@pytest.mark.parametrize("write", range(13))  # the header, then start, log and stop of four runs
def test_a_disk_that_is_full_at_any_write_stops_the_board_and_costs_one_run(
    world, measure, quick_experiment, tmp_path, write
):
    with pytest.MonkeyPatch.context() as patch:
        full_from(write, patch)
        with pytest.raises(DataError, match=re.escape(os.strerror(errno.ENOSPC))) as error:
            measure()
    assert error.value.exit_code == ExitCode.DATA and "free space" in error.value.hint
    status = BoardClient(world.open()).status()
    assert STATES[status["state"]] in (("idle",) if write < 11 else ("idle", "done"))
    assert FAULTS[status["fault"]] == ("stopped" if 0 < write < 11 else "none")

    resume = write > 0  # else there is no campaign, not half of one
    assert (tmp_path / "campaign" / "campaign.yaml").exists() == resume
    before = check_nothing_rewritten(tmp_path / "campaign", {})
    assert measure(resume).runs == 4 - max(write - 1, 0) // 3
    check_nothing_rewritten(tmp_path / "campaign", before)
    check_against_board(tmp_path / "campaign", quick_experiment, attempts(world.truth.words()))


LIMITED = """
import resource, signal
from hbench.cli.main import main
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # the write fails instead
resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, resource.RLIM_INFINITY))
main()
"""


def test_a_write_that_the_system_refuses_ends_in_exit_code_4_and_resume_completes(
    quick_schedule, measure, tmp_path
):
    """The journal may not grow beyond a size: a real refusal, in the middle of a line."""
    journal = tmp_path / "campaign" / "campaign.yaml"
    measure()
    limit = journal.stat().st_size - 700  # about two runs
    (tmp_path / "campaign").rename(tmp_path / "whole")

    done = subprocess.run(
        [sys.executable, "-c", LIMITED.format(limit=limit)]
        + ["run", str(quick_schedule()), "-o", "campaign"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.returncode == 4, done.stderr
    assert "error: campaign/campaign.yaml: " in done.stderr
    assert "Traceback" not in done.stderr
    made = load_campaign(tmp_path / "campaign").done
    assert 0 < len(made) < 4
    assert measure(resume=True).runs == 4 - len(made)
    assert load_campaign(tmp_path / "campaign").done == {"0001", "0002", "0003", "0004"}
