"""A virtual line with a baud rate takes a real line's time, and a pull fills it.

Time is simulated, so the figures are exact and the same everywhere.
"""

import math
import re

import pytest

from hbench import workflow
from hbench.errors import DeviceError
from hbench.experiment.runner import run_campaign
from hbench.protocol.dictionary import RECORD, STATES
from hbench.protocol.frames import Frame, Receiver, encode
from hbench.rig.client import RECORDS_PER_FRAME, BoardClient
from hbench.rig.firmware import HostFirmware
from hbench.rig.virtual import VirtualRig
from hbench.store.campaign.folder import load_campaign
from tests.support.rig_campaign import measure_on_rig

RECORD_OCTETS = 2 * len(RECORD)
FRAMING = RECORDS_PER_FRAME * RECORD_OCTETS / (2 + 8 + RECORDS_PER_FRAME * RECORD_OCTETS + 2 + 2)
"""Records' share of a full reply: sequence and type, first and next, CRC, COBS and end mark."""
IDENTIFY = 1


class Away(Exception):
    """The test has the rig in the state it wants."""


@pytest.fixture
def backlog(short_schedule):
    """Return a function that makes a rig whose log holds over 800 records that nobody pulled.

    ``running``: in the middle of a run, else with all runs over.
    """

    def make(baud, running):
        schedule = short_schedule(
            bench={"limits": {"heartbeat": "60 s"}},
            velocities=["12 mm/s"],
            trials=1,
            window="14 s" if running else "8 s",
        )
        experiment = workflow.load_experiment(schedule, None)
        rig = VirtualRig(experiment.bench, None, 1, baud)
        client = BoardClient(rig)

        def leave(progress):
            raise Away

        client.stop = lambda: None  # the board goes on alone
        with pytest.raises(Away):
            run_campaign(experiment.plans, experiment.bench, client, Unwritten(), int, leave)
        state = "running" if running else "done"
        while (status := client.status())["log_next"] < 820 or STATES[status["state"]] != state:
            client.wait(0.5)
            assert rig.now() < 60.0
        return rig, client

    return make


class Unwritten:
    """A journal that keeps nothing."""

    def start_run(self, *arguments):
        pass

    def finish_run(self, *arguments):
        pass


@pytest.mark.parametrize("running", [True, False], ids=["while a run goes on", "after the runs"])
@pytest.mark.parametrize("baud", [115_200, 921_600])
def test_a_pull_carries_nine_tenths_of_what_the_line_could(backlog, baud, running):
    rig, client = backlog(baud, running)
    status = client.status()
    begin_s, until = rig.now(), status["log_next"]
    records = sum(len(part.words) for part in client.pull(until - 800, until))
    took_s = rig.now() - begin_s
    assert records == 800
    assert (STATES[client.status()["state"]] == "running") == running
    share = records * RECORD_OCTETS / (took_s * baud / 10)
    print(f"{baud} baud: {share:.4f} of the line, {share / FRAMING:.4f} of what frames allow")
    assert 0.9 <= share <= FRAMING


def ticks_until(board, count):
    """Ticks until the host has ``count`` octets; returns them too."""
    octets, ticks = b"", 0
    while len(octets) < count:
        board.tick([0] * 7)
        board.poll()
        octets += board.transmit()
        ticks += 1
        assert ticks < 100_000
    return ticks, octets


@pytest.mark.parametrize("baud", [19_200, 115_200, 230_400, 921_600])
def test_octets_take_ten_bits_each_and_do_not_drift(baud):
    board = HostFirmware(1, baud)
    request = encode(Frame(9, IDENTIFY, b""))
    reply_octets = len(answer_to(request))
    board.receive(request)
    ticks, _ = ticks_until(board, reply_octets)
    exact = (len(request) + reply_octets) * 10 * 10_000 / baud
    assert exact <= ticks <= math.ceil(exact) + 3  # one for each start, one for the idle loop

    many = 20  # the replies follow each other without a pause
    for sequence in range(many):
        board.receive(encode(Frame(sequence + 1, IDENTIFY, b"")))
    ticks, octets = ticks_until(board, many * reply_octets)
    exact = (len(request) + many * reply_octets) * 10 * 10_000 / baud
    assert exact <= ticks <= math.ceil(exact) + 3
    assert [frame.sequence for frame in Receiver().feed(octets)] == list(range(1, many + 1))
    board.close()


def answer_to(request):
    """What a board without a baud rate answers."""
    board = HostFirmware(1)
    board.receive(request)
    board.poll()
    reply = board.transmit()
    board.close()
    return reply


def test_without_a_rate_octets_take_no_time():
    assert len(answer_to(encode(Frame(9, IDENTIFY, b"")))) > 40


def test_octets_beyond_the_receive_buffer_are_lost_as_on_a_uart():
    """30 requests of 6 octets at once; 128 fit while the first reply goes out."""
    board = HostFirmware(1, 115_200)
    requests = [encode(Frame(n, IDENTIFY, b"")) for n in range(1, 31)]
    board.receive(b"".join(requests))
    octets = b""
    for _ in range(10_000):
        board.tick([0] * 7)
        board.poll()
        octets += board.transmit()
    answered = [frame.sequence for frame in Receiver().feed(octets)]
    assert answered[:21] == list(range(1, 22)), "64 octets and more must be kept"
    assert len(answered) < 30
    board.close()


def measure(schedule, folder, clock, **options):
    return measure_on_rig(workflow.load_experiment(schedule, None), folder, clock=clock, **options)


def test_a_campaign_over_a_line_of_115200_baud_is_whole(short_schedule, tmp_path, clock):
    measure(short_schedule(), tmp_path / "campaign", clock, baud=115_200)
    assert len(load_campaign(tmp_path / "campaign").done) == 4


def test_a_line_too_slow_for_the_log_fails_the_runs_that_it_cost(short_schedule, tmp_path, clock):
    """30 octets a record, 100 records a second: 19 200 baud carry little more than half of it."""
    schedule = short_schedule(velocities=["4 mm/s", "120 mm/s"], trials=1, window="45 s")
    with pytest.raises(DeviceError, match="runs failed: 0001") as error:
        measure(schedule, tmp_path / "campaign", clock, baud=19_200)
    assert "--baud" in error.value.hint
    first = load_campaign(tmp_path / "campaign").entries[0]
    assert first.stop.outcome == "failed" and re.search(r"\blog\b", first.stop.why)
    measure(schedule, tmp_path / "campaign", clock, baud=115_200, resume=True)
    assert load_campaign(tmp_path / "campaign").done == {"0001", "0002"}
