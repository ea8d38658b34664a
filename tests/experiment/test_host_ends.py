"""A host that is killed, interrupted or put to sleep leaves a stopped bench and a whole campaign.

Real processes: ``hbench rig`` on a socket, its board's records tapped past the line, and
``hbench run``.
"""

import os
import pty
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from hbench import workflow
from hbench.protocol.dictionary import FAULTS, RECORD, STATES
from hbench.rig.client import BoardClient
from hbench.rig.ports import SerialPort
from hbench.store.campaign.folder import load_campaign
from tests.support import ROOT
from tests.support.faults.fault_story import check_against_board, check_nothing_rewritten
from tests.support.faults.faulty_line import attempts
from tests.support.waiting import wait_until

PATIENCE_S = 120.0
TAPPED_RIG = ROOT / "tests" / "support" / "faults" / "tapped_rig.py"
RUN = """
import fcntl, os, signal, termios
if os.isatty(0):
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):  # whatever this test was started with
    signal.signal(number, signal.SIG_DFL)
signal.signal(signal.SIGINT, signal.default_int_handler)
from hbench.cli.main import main
main()
"""


class Lab:
    """A rig that is served, and hosts that come and go."""

    def __init__(self, schedule: Path, speed: str):
        self.schedule = schedule
        self.folder = schedule.parent / "campaign"
        self._records = schedule.parent / "records"
        self._processes = []
        bench = schedule.parent / "bench.yaml"
        rig = self._start(
            [TAPPED_RIG, self._records, "--bench", bench, "--socket", "localhost:0"]
            + ["--speed", speed]
        )
        self.port = rig.stdout.readline().strip()

    def host(self, terminal: int | None = None) -> subprocess.Popen:
        """Start ``hbench run``, with ``--resume`` where there is a campaign.

        With ``terminal`` that is its controlling terminal, and takes what it tells.
        """
        resume = ["--resume"] if (self.folder / "campaign.yaml").exists() else []
        return self._start(
            ["-c", RUN, "run", self.schedule, "-o", self.folder, "--port", self.port, *resume],
            terminal,
        )

    def logged(self) -> np.ndarray:
        """All records that the board has published."""
        words = np.frombuffer(self._records.read_bytes(), "<u2")
        return words[: len(words) // len(RECORD) * len(RECORD)].reshape(-1, len(RECORD))

    def status(self) -> dict:
        """Ask the board over a connection of its own."""
        port = SerialPort(self.port)
        try:
            return BoardClient(port).status()
        finally:
            port.close()

    def close(self) -> None:
        for process in self._processes:
            process.kill()
            process.communicate()

    def _start(self, arguments, terminal: int | None = None) -> subprocess.Popen:
        process = subprocess.Popen(
            [sys.executable, *map(str, arguments)],
            stdin=subprocess.DEVNULL if terminal is None else terminal,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE if terminal is None else terminal,
            start_new_session=terminal is not None,
            text=True,
            cwd=self.schedule.parent,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        )
        self._processes.append(process)
        return process


@pytest.fixture
def lab():
    """Return a function that starts a lab."""
    labs = []

    def start(schedule, speed="1"):
        labs.append(Lab(schedule, speed))
        return labs[-1]

    yield start
    for each in labs:
        each.close()


def kill_and_resume(lab, schedule, kills, seed):
    """Kill hosts at random moments, then let one end; check the campaign against the board.

    Return how many died when.
    """
    rng = np.random.default_rng(seed)
    before, died = {}, Counter()
    for _ in range(kills):
        host = lab.host()
        logged = len(lab.logged())
        if rng.random() < 0.8:  # else it dies while it starts
            wait_until(
                lambda n=logged, h=host: len(lab.logged()) > n or h.poll() is not None, PATIENCE_S
            )
        time.sleep(rng.uniform(0.0, 1.0))
        host.kill()
        if host.wait() != -signal.SIGKILL:
            died["after its end"] += 1
        elif len(lab.logged()) > logged:
            died["during runs"] += 1
        else:
            died["as it started"] += 1
        before = check_nothing_rewritten(lab.folder, before)
    host = lab.host()
    _, told = host.communicate(timeout=PATIENCE_S)
    assert host.returncode == 0, told
    check_nothing_rewritten(lab.folder, before)
    experiment = workflow.load_experiment(schedule, None)
    check_against_board(lab.folder, experiment, attempts(lab.logged()))
    return died


def test_a_host_killed_at_any_moment_loses_no_run(lab, quick_schedule):
    schedule = quick_schedule(trials=6)
    died = kill_and_resume(lab(schedule, "max"), schedule, kills=2, seed=1)
    assert died["after its end"] < 2


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10, 20))
def test_hosts_killed_many_times_lose_no_run(lab, quick_schedule, seed):
    schedule = quick_schedule(trials=20)
    died = kill_and_resume(lab(schedule, "max"), schedule, kills=8, seed=seed)
    assert died["after its end"] < 4


@pytest.mark.nightly
def test_five_hundred_killed_hosts_lose_no_run(lab, quick_schedule):
    schedule = quick_schedule(trials=20)
    died = Counter()
    for seed in range(100, 150):
        rig = lab(schedule, "max")
        died += kill_and_resume(rig, schedule, kills=10, seed=seed)
        rig.close()
        shutil.rmtree(rig.folder)
        print(f"\n{died.total()} killed hosts, {seed - 99} campaigns complete: {dict(died)}")
    assert died["after its end"] < 250


def interrupted(lab, interrupt, terminal=None) -> subprocess.Popen:
    """Start a host, wait until its bench moves, interrupt it; the bench must then stand still."""
    host, logged = lab.host(terminal), len(lab.logged())
    wait_until(lambda: len(lab.logged()) > logged + 5 or host.poll() is not None, PATIENCE_S)
    interrupt(host)
    assert host.wait(PATIENCE_S) == 130
    status = lab.status()
    assert (STATES[status["state"]], FAULTS[status["fault"]]) == ("idle", "stopped")
    time.sleep(0.5)
    assert abs(lab.status()["x_m"] - status["x_m"]) < 0.5e-3  # at 80 mm/s it would be 40 mm
    (*_, entry) = load_campaign(lab.folder).entries
    assert entry.stop.outcome == "aborted" and entry.stop.why.startswith("interrupted")
    return host


def test_an_interrupted_host_and_a_closed_terminal_stop_the_board_at_once(lab, quick_schedule):
    lab = lab(quick_schedule())
    for number in (signal.SIGINT, signal.SIGTERM):
        host = interrupted(lab, lambda host, n=number: host.send_signal(n))
        told = host.stderr.read()
        assert re.search("interrupted.* --resume", told)
        assert "Traceback" not in told

    window, terminal = pty.openpty()
    shown = []

    def close(host):
        os.close(terminal)  # of this process; the host has its own
        shown.append(os.read(window, 10_000))
        os.close(window)

    interrupted(lab, close, terminal)
    assert b"run " in shown[0]


def test_a_host_that_sleeps_finds_a_board_that_has_stopped_itself(lab, quick_schedule):
    lab = lab(quick_schedule({"limits": {"heartbeat": "1 s"}}))
    host = lab.host()
    wait_until(lambda: len(lab.logged()) > 5 or host.poll() is not None, PATIENCE_S)
    host.send_signal(signal.SIGSTOP)
    time.sleep(1.3)
    logged = len(lab.logged())
    time.sleep(0.5)
    assert len(lab.logged()) == logged
    host.send_signal(signal.SIGCONT)
    _, told = host.communicate(timeout=PATIENCE_S)
    assert host.returncode == 3
    assert re.search(r"^error: run .*: heartbeat\b", told, re.MULTILINE) and "--resume" in told
    status = lab.status()
    assert (STATES[status["state"]], FAULTS[status["fault"]]) == ("fault", "heartbeat")
