"""A process of its own bears what its calls do, and leaves nothing behind."""

import os
import subprocess
import sys
import time
from pathlib import Path
from pickle import PicklingError

import pytest

from hbench.store.files.limited_process import CallKilled, LimitedProcess
from tests.support.faults import killers

MB = 1_000_000


@pytest.fixture(scope="module")
def process():
    process = LimitedProcess(memory=200 * MB, disk=MB, seconds=30.0)
    yield process
    process.close()


def test_results_and_exceptions_come_back(process):
    assert process.call(killers.double, 21) == 42
    with pytest.raises(KeyError, match="gone"):
        process.call(killers.fail, "gone")
    with pytest.raises((AttributeError, PicklingError), match="unpicklable"):
        process.call(killers.unpicklable)
    assert process.call(killers.double, 1) == 2


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are observed on Linux only")
def test_memory_and_disk_are_limited_for_each_call(process):
    for _ in range(3):
        assert process.call(killers.allocate, 150 * MB) == 150 * MB
    with pytest.raises(MemoryError):
        process.call(killers.allocate, 250 * MB)
    with pytest.raises(OSError):
        process.call(killers.fill_disk, 2 * MB)
    assert process.call(killers.double, 1) == 2


@pytest.mark.parametrize(
    ("function", "reason"),
    [
        (killers.crash, "SIGSEGV"),
        (killers.leave, "exit code 7"),
        (killers.write_garbage, "reader"),
    ],
)
def test_a_death_is_reported_and_the_next_call_answered(process, function, reason):
    with pytest.raises(CallKilled, match=reason):
        process.call(function)
    assert not process.is_running
    assert process.call(killers.double, 1) == 2


def test_a_call_that_takes_too_long_is_ended_and_its_files_are_removed():
    process = LimitedProcess(memory=200 * MB, disk=MB, seconds=2.0)
    left = Path(process.call(killers.temporary_file))
    assert left.exists()
    with pytest.raises(CallKilled, match="2 s"):
        process.call(killers.hang)
    assert not left.exists() and not left.parent.exists()


def test_it_ends_with_the_process_that_started_it_and_removes_its_files():
    program = (
        f"import os, sys; sys.path[:] = {sys.path!r}\n"
        "from tests.support.faults import killers\n"
        "from hbench.store.files.limited_process import LimitedProcess\n"
        "process = LimitedProcess(10**8, 10**6, 30.0)\n"
        "print(process.call(killers.own_id), process.call(killers.temporary_file), flush=True)\n"
        "os._exit(0)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    number, file = done.stdout.split()
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        try:
            os.kill(int(number), 0)
        except ProcessLookupError:
            break
        time.sleep(0.05)
    else:
        pytest.fail("it is still there")
    assert not Path(file).parent.exists()
