"""Campaigns of several seeds on all cores: each as if made alone, whatever ends them.

Real processes, in a session of their own that is killed when a test's time is up.
"""

import os
import pickle
import re
import signal
import subprocess
import sys
import time
from contextlib import suppress
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hbench.cli.main import app
from hbench.rig.client import Refused
from hbench.store.campaign.folder import load_campaign

LONG = {"velocities": [f"{v} mm/s" for v in range(60, 160, 20)], "trials": 10}  # 50 runs
LIMIT_S = 100.0  # of a test's wait for anything; it takes some seconds
AT_ONCE_S = 30.0  # it takes less than a second, unless the machine is paused
RUN = """
import signal
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):  # whatever this test was started with
    signal.signal(number, signal.SIG_DFL)
signal.signal(signal.SIGINT, signal.default_int_handler)
from hbench.cli.main import main
main()
"""

INTERRUPTED_WHILE_STARTING = """
import signal, threading, time
from multiprocessing import util
from hbench.parallel.process_pool import map_on_cores

def start(path, arguments, descriptors):
    pid = plain_start(path, arguments, descriptors)
    if "spawn_main" in str(arguments):  # it waits for what it is to do
        signal.pthread_kill(another.ident, signal.SIGINT)
        time.sleep(0.2)
    return pid

plain_start, util.spawnv_passfds = util.spawnv_passfds, start
signal.signal(signal.SIGINT, signal.default_int_handler)
another = threading.Thread(target=time.sleep, args=(60,), daemon=True)
another.start()
try:
    list(map_on_cores(abs, range(3)))
except KeyboardInterrupt:
    print("interrupted")
"""


class Host:
    """``hbench run SCHEDULE -o OUT ...`` as the leader of a group of processes."""

    def __init__(self, schedule: Path, *arguments):
        self.out = schedule.parent / "out"
        self._told = schedule.parent / "told"
        with self._told.open("w") as told:
            self._process = subprocess.Popen(
                [sys.executable, "-X", "faulthandler", "-c", RUN, "run", schedule, "-o", self.out]
                + [str(argument) for argument in arguments],
                stdin=subprocess.DEVNULL,
                stdout=told,
                stderr=told,
                start_new_session=True,
                cwd=schedule.parent,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
            )
        self.pid = self._process.pid

    def ended(self, within_s: float = LIMIT_S) -> tuple[int, str]:
        """Wait; return the exit code and what was told."""
        try:
            return self._process.wait(within_s), self._told.read_text()
        except subprocess.TimeoutExpired:
            self._process.send_signal(signal.SIGABRT)  # it says where each thread is
            self._process.wait(within_s)
            pytest.fail(f"not ended in {within_s} s:\n{self._told.read_text()}")

    def wait_until(self, holds) -> None:
        deadline = time.monotonic() + LIMIT_S
        while not holds():
            assert self._process.poll() is None, self._told.read_text()
            assert time.monotonic() < deadline, "waited in vain"
            time.sleep(0.01)

    def workers(self) -> list[int]:
        """The host's processes that make campaigns."""
        lines = subprocess.run(
            ["ps", "-ww", "-eo", "pid=,ppid=,args="],
            capture_output=True,
            text=True,
            timeout=LIMIT_S,
        ).stdout.splitlines()
        others = [line.split() for line in lines if "resource_tracker" not in line]
        return [int(pid) for pid, parent, *_ in others if int(parent) == self.pid]

    def leaves_nobody(self, within_s: float = AT_ONCE_S) -> bool:
        deadline = time.monotonic() + within_s
        while time.monotonic() < deadline:
            try:
                os.killpg(self.pid, 0)
            except ProcessLookupError:
                return True
            time.sleep(0.05)
        return False

    def kill(self) -> None:
        with suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        self._process.wait(LIMIT_S)


@pytest.fixture
def run():
    hosts = []

    def start(schedule, *arguments):
        hosts.append(Host(schedule, *arguments))
        return hosts[-1]

    yield start
    for host in hosts:
        host.kill()


@pytest.fixture
def run_here(monkeypatch):
    """As ``run``, until the end and in the test's process: others take seconds to start."""

    def start(schedule, *arguments) -> str:
        with monkeypatch.context() as patch:
            patch.setattr("hbench.workflow.seeds.map_on_cores", map)
            command = ["run", schedule, "-o", schedule.parent / "out", *arguments]
            done = CliRunner().invoke(app, list(map(str, command)))
        assert done.exit_code == 0, done.output
        return done.stdout

    return start


def files(folder: Path) -> dict[str, bytes]:
    """A campaign's files, without the time of day."""
    moment = re.compile(rb"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d[.\d]*[+-]\d\d:\d\d")
    names = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    return {str(p.relative_to(folder)): moment.sub(b"now", p.read_bytes()) for p in names}


def logs(campaigns: list[Path]) -> int:
    return sum(len(list(folder.glob("runs/????.dat"))) for folder in campaigns)


def test_each_has_the_bytes_of_one_made_alone_and_resume_makes_what_is_missing(
    run, run_here, quick_schedule, on_the_rig
):
    schedule = quick_schedule()
    code, told = run(schedule, "--campaigns", 2, "--seed", 5).ended()
    assert code == 0, told
    assert "2/2 campaigns" in told and ": 8 runs in" in told
    out = schedule.parent / "out"
    many = {seed: files(out / str(seed)) for seed in (5, 6)}
    (out / "6").rename(schedule.parent / "kept")
    assert ": 8 runs in" in run_here(schedule, "--campaigns", 3, "--seed", 5, "--resume")
    assert files(out / "5") == many[5] and files(out / "6") == many[6]

    on_the_rig(schedule, schedule.parent / "alone", seed=6)
    alone = files(schedule.parent / "alone")
    assert {"campaign.yaml", "runs/0001.dat"} < set(alone)
    assert alone == many[6] != many[5]


def test_what_ends_the_host_ends_all_within_seconds_and_resume_goes_on(
    run, run_here, quick_schedule
):
    """Ctrl-C goes to all processes of a terminal, the others to the host alone."""
    schedule = quick_schedule(**LONG)
    campaigns = [schedule.parent / "out" / seed for seed in "12"]
    made, resume = 0, []
    for number, send in (
        (signal.SIGTERM, os.kill),
        (signal.SIGKILL, os.kill),
        (signal.SIGINT, os.killpg),
    ):
        host = run(schedule, "--campaigns", 2, *resume)
        host.wait_until(lambda before=made: logs(campaigns) >= before + 5)
        send(host.pid, number)
        code, told = host.ended(AT_ONCE_S)
        assert host.leaves_nobody()
        assert code == (-signal.SIGKILL if number == signal.SIGKILL else 130), told
        assert "Traceback" not in told
        assert code < 0 or re.search("interrupted.* --resume", told)
        begun = [folder for folder in campaigns if (folder / "campaign.yaml").exists()]
        made = sum(len(load_campaign(folder).done) for folder in begun)
        assert made < 100
        resume = ["--resume"]
    assert f": {100 - made} runs in" in run_here(schedule, "--campaigns", 2, "--resume")
    assert [len(load_campaign(folder).done) for folder in campaigns] == [50, 50]


def test_ctrl_c_before_anything_is_made_ends_it_without_a_traceback(run, quick_schedule):
    host = run(quick_schedule(**LONG), "--campaigns", 2)
    host.wait_until(host.workers)
    os.killpg(host.pid, signal.SIGINT)
    code, told = host.ended(AT_ONCE_S)
    assert host.leaves_nobody()
    assert code == 130 and "Traceback" not in told, told


def test_ctrl_c_that_another_thread_hears_while_a_process_is_started_waits_for_it():
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED_WHILE_STARTING],
        capture_output=True,
        text=True,
        timeout=LIMIT_S,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert (done.stdout, done.stderr) == ("interrupted\n", "")


def test_a_killed_worker_ends_all_with_a_cause_and_leaves_what_is_finished(
    run, quick_schedule, on_the_rig
):
    schedule = quick_schedule()
    out = schedule.parent / "out"
    on_the_rig(schedule, out / "1")
    first = files(out / "1")

    host = run(schedule, "--campaigns", 300, "--resume")
    host.wait_until(lambda: logs([out / "2"]) == 4)
    os.kill(host.workers()[0], signal.SIGKILL)
    code, told = host.ended(AT_ONCE_S)
    assert host.leaves_nobody()
    assert code == 3, told
    assert re.search(r"^error: .*\bworker\b", told, re.MULTILINE)
    assert "--resume" in told and "Traceback" not in told
    assert files(out / "1") == first
    assert load_campaign(out / "2").done


def test_an_error_of_one_campaign_ends_all_with_its_own_words_and_exit_code(run, quick_schedule):
    schedule = quick_schedule(**LONG)
    out = schedule.parent / "out"
    (out / "2").mkdir(parents=True)
    (out / "2" / "campaign.yaml").write_text("")
    host = run(schedule, "--campaigns", 3)
    code, told = host.ended()
    assert host.leaves_nobody()
    assert code == 2, told
    assert f"error: {out / '2'}: " in told and "\nhint: " in told


def test_an_error_is_the_same_in_another_process():
    error = Refused("start", "not_idle")
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is Refused
    assert (str(again), vars(again)) == (str(error), vars(error))


def test_campaigns_are_for_the_virtual_rig(quick_schedule):
    arguments = ["run", str(quick_schedule()), "-o", "out", "--campaigns", "2", "--port", "none"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 2 and "'--campaigns'" in result.output
