"""The served rig is a bench to any client: it runs campaigns, outlives clients, keeps its time."""

import os
import signal
import subprocess
import sys
import threading
import time
from datetime import UTC, datetime, timedelta
from itertools import count

import pytest
import serial

from hbench import workflow
from hbench.errors import ConfigError, DeviceError
from hbench.experiment.upload import uploads
from hbench.protocol.dictionary import FAULTS, STATES
from hbench.rig.board_settings import board_settings
from hbench.rig.client import BoardClient
from hbench.rig.lines import SocketLine, open_line
from hbench.rig.ports import SerialPort
from hbench.rig.serve import FullSpeed, WallClock, serve
from hbench.rig.virtual import VirtualRig
from hbench.store.campaign.folder import load_campaign
from tests.support.rig_campaign import measure_on_rig
from tests.support.waiting import killed_in_the_end, wait_until

PATIENCE_S = 30.0
ADDRESSES = [None, "localhost:0"]  # pseudo-terminal, socket


@pytest.fixture
def experiment(short_schedule):
    """One run of little more than a second."""
    travel = {"start": "100 mm", "end": "220 mm"}
    schedule = short_schedule(velocities=["120 mm/s"], trials=1, travel=travel, window="0.4 s")
    return workflow.load_experiment(schedule, None)


@pytest.fixture
def served(experiment):
    """Return a function that serves a rig in a thread; it returns rig and line.

    With ``share_s`` it is served flat out.
    """
    stop, threads, ends = threading.Event(), [], []

    def start(address=None, share_s=None):
        rig, line = VirtualRig(experiment.bench), open_line(address)
        rig.read(0.0)
        pace = FullSpeed(share_s) if share_s else WallClock()
        threads.append(threading.Thread(target=serve, args=(rig, line, pace, stop.is_set)))
        threads[-1].start()
        ends.extend((line, rig))
        return rig, line

    yield start
    stop.set()
    for thread in threads:
        thread.join(PATIENCE_S)
    for end in ends:
        end.close()


@pytest.mark.parametrize("address, share_s", [(None, None), ("localhost:0", 1.0)])
def test_a_campaign_on_a_served_rig_is_accepted_and_says_that_it_is_simulated(
    served, experiment, tmp_path, clock, address, share_s
):
    _, line = served(address, share_s)
    folder = tmp_path / "campaign"
    measure_on_rig(experiment, folder, port=line.name, clock=clock)
    results = workflow.analyze(folder)
    assert [run.accepted for run in results.runs] == [True]
    header = load_campaign(folder).header
    assert (header["source"], header["port"]) == ("simulated", line.name)
    assert "seed" not in header  # the client doesn't know it


def test_setting_the_computer_s_clock_does_not_change_the_times_of_runs(
    served, experiment, tmp_path
):
    """The clock goes forward by an hour each time that it is read."""
    _, line = served(share_s=1.0)
    hours = count()
    start = datetime(2026, 3, 29, tzinfo=UTC)
    measure_on_rig(
        experiment,
        tmp_path / "campaign",
        port=line.name,
        clock=lambda: start + timedelta(hours=next(hours)),
    )
    (entry,) = load_campaign(tmp_path / "campaign").entries
    began, ended = map(datetime.fromisoformat, (entry.started, entry.stop.at))
    assert timedelta(0) < ended - began < timedelta(seconds=PATIENCE_S)
    assert start <= began < start + timedelta(seconds=PATIENCE_S)


@pytest.mark.parametrize("address", ADDRESSES)
@pytest.mark.parametrize("share_s", [None, 0.2])
def test_a_client_that_leaves_in_the_middle_of_a_run_leaves_a_bench_that_stops_itself(
    served, experiment, address, share_s
):
    rig, line = served(address, share_s)
    port = SerialPort(line.name)
    client = BoardClient(port)
    settings = board_settings(experiment.bench) | {"heartbeat_s": 0.4}
    upload = next(uploads(experiment.plans, client.identify()))
    schedule_crc = client.write_schedule(upload.segments, upload.steps)
    client.start(client.write_settings(settings), schedule_crc)
    port.close()
    left_at = rig.now()
    wait_until(lambda: rig.now() > left_at + 0.5, PATIENCE_S)

    port = SerialPort(line.name)
    client = BoardClient(port)
    status = client.status()
    assert STATES[status["state"]] == "fault" and FAULTS[status["fault"]] == "heartbeat"
    client.clear_fault()
    assert STATES[client.status()["state"]] != "fault"
    port.close()


def test_simulated_time_never_runs_ahead_of_the_wall(served):
    begin = time.monotonic()
    rig, line = served()
    port = SerialPort(line.name)
    for _ in range(20):
        BoardClient(port).identify()
        assert rig.now() <= time.monotonic() - begin + 0.01
    port.close()


def test_a_person_with_a_terminal_program_is_told_who_is_there(served):
    _, line = served()
    with serial.Serial(line.name, timeout=PATIENCE_S) as terminal:
        terminal.write(b"?\r")
        told = terminal.readline()
    assert told.startswith(b"hbench-core ") and told.endswith(b", state idle, fault none\r\n")


def test_a_second_client_is_turned_away_and_the_first_stays(served):
    _, line = served("localhost:0")
    first = SerialPort(line.name)
    BoardClient(first).identify()
    with pytest.raises(DeviceError):
        BoardClient(SerialPort(line.name)).identify()
    assert BoardClient(first).identify().board == "host"
    first.close()


@pytest.mark.parametrize("address", ADDRESSES)
def test_a_client_that_never_reads_does_not_hold_up_the_rig(served, address):
    rig, line = served(address)
    port = SerialPort(line.name)
    for _ in range(3000):  # more answers than the line holds
        port.write(b"\x00\x01\x02\x00")
    now = rig.now()
    wait_until(lambda: rig.now() > now + 0.1, PATIENCE_S)
    port.close()
    port = SerialPort(line.name)
    assert BoardClient(port).identify().board == "host"
    port.close()


class StillRig:
    """A port whose time passes as asked and whose board is silent."""

    name = "still"

    def __init__(self):
        self.time_s = 0.0

    def write(self, data):
        pass

    def read(self, timeout_s):
        self.time_s += timeout_s
        return b""

    def now(self):
        return self.time_s


class ScriptedLine:
    """A client that says a word at some looks at the line; each look takes its whole timeout."""

    name = "script"
    connected = True

    def __init__(self, words_at, stall=None):
        self.words_at = words_at
        self.stall = stall or {}
        self.looks = 0
        self.wall_s = 100.0

    def read(self, timeout_s):
        self.looks += 1
        self.wall_s += timeout_s + self.stall.get(self.looks, 0.0)
        return b"x" if self.looks in self.words_at else b""

    def write(self, data):
        pass


def run(line, pace, looks):
    rig = StillRig()
    serve(rig, line, pace, lambda: line.looks == looks)
    return rig.time_s


def test_flat_out_one_word_of_the_client_buys_one_share_and_silence_nothing():
    assert run(ScriptedLine({3}), FullSpeed(0.4), 200) == pytest.approx(0.4)
    assert run(ScriptedLine(set()), FullSpeed(0.4), 200) == 0.0
    # the second word comes when 6 slices of 10 ms have run, and the share begins anew
    assert run(ScriptedLine({1, 7}), FullSpeed(0.4), 200) == pytest.approx(0.06 + 0.4)


def test_flat_out_waits_for_the_client_without_spinning():
    line = ScriptedLine({1})
    run(line, FullSpeed(0.4), 100)
    waits = 1 + 100 - 1 - 40  # looks before and after the 40 slices of the share
    assert line.wall_s - 100.0 == pytest.approx(0.1 * waits)


def test_simulated_time_follows_the_wall_and_a_stall_is_not_completed_up():
    line = ScriptedLine({5})
    assert run(line, WallClock(lambda: line.wall_s), 500) == pytest.approx(line.wall_s - 100.0)
    stalled = ScriptedLine({5}, stall={50: 30.0})
    simulated = run(stalled, WallClock(lambda: stalled.wall_s), 500)
    assert simulated == pytest.approx(stalled.wall_s - 100.0 - 30.0, abs=0.01)


@pytest.mark.parametrize("address", ["localhost", "localhost:99999", "localhost:x", ":7000", ""])
def test_what_is_no_address_is_refused(address):
    with pytest.raises(ConfigError, match="HOST:PORT"):
        SocketLine(address)


def test_an_address_that_is_taken_is_a_device_error():
    line = SocketLine("localhost:0")
    with pytest.raises(DeviceError, match="--socket"):
        SocketLine(line.name.removeprefix("socket://"))
    line.close()


def test_the_command_prints_the_port_alone_and_ctrl_c_ends_it_well(short_schedule):
    bench = short_schedule().parent / "bench.yaml"
    started = subprocess.Popen(
        [sys.executable, "-m", "hbench", "rig", "--bench", bench, "--socket", "localhost:0"],
        stdout=subprocess.PIPE,
        text=True,
        cwd=bench.parent,  # a checkout in the working folder would be imported instead
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    with killed_in_the_end(started) as process:
        name = process.stdout.readline().strip()
        (found,) = workflow.find_boards([name])
        assert (found.state, found.board.board) == ("board", "host")
        process.send_signal(signal.SIGINT)
        rest, _ = process.communicate(timeout=PATIENCE_S)
        assert (process.returncode, rest) == (0, "")
