"""The firmware on an emulated Cortex-M4 (PIL): identical to the host library, bit for bit.

The bench is simulated and the emulator counts instructions, so these tests verify no timing
on hardware.
"""

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from hbench import workflow
from hbench.errors import ConfigError, DeviceError
from hbench.protocol.codec import BY_NAME
from hbench.protocol.dictionary import FAULTS, RECORD, RECORD_FLAGS, REPLY, STATES
from hbench.protocol.frames import Frame, Receiver, encode
from hbench.rig import emulator
from hbench.rig.client import BoardClient
from hbench.rig.emulator import EmulatedFirmware
from hbench.rig.firmware import HostFirmware
from hbench.rig.stepped import SteppedRig
from hbench.store.campaign.folder import load_campaign
from tests.support.commands import hbench
from tests.support.rig_campaign import measure_on_rig
from tests.support.waiting import killed_in_the_end

PATIENCE_S = 60.0
IDENTIFY = BY_NAME["identify"].code


@pytest.fixture
def image(mps2_build, tmp_path, require_tool):
    """A copy of the image for this test only; its emulators must end with the test."""
    require_tool(emulator.PROGRAM)
    copy = shutil.copy(mps2_build / "hbench-mps2.elf", tmp_path / "board.elf")
    yield copy
    for process in emulators_of(copy):
        os.kill(process, signal.SIGKILL)


def emulators_of(image):
    """Ids of the processes that run an image; a zombie has no arguments."""
    processes = []
    for arguments in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            if str(image).encode() in arguments.read_bytes().split(b"\0")[2:5]:
                processes.append(int(arguments.parent.name))
        except OSError:  # it has ended meanwhile
            continue
    return processes


@pytest.fixture
def board(image):
    firmware = EmulatedFirmware(image)
    yield firmware
    firmware.close()


def one_speed(quick_schedule, trials):
    """Trials of 120 mm/s against 2000 N."""
    travel = {"start": "180 mm", "end": "270 mm"}
    changes = {"velocities": ["120 mm/s"], "travel": travel, "window": "0.4 s"}
    schedule = quick_schedule(trials=trials, **changes)
    return workflow.load_experiment(schedule, None)


@pytest.fixture
def experiment(quick_schedule):
    return one_speed(quick_schedule, trials=2)


@pytest.fixture
def measure(monkeypatch, tmp_path, clock):
    """Function that executes an experiment on a port and returns the campaign."""

    def run(experiment, port, name="campaign"):
        monkeypatch.setattr(workflow.campaign, "open_port", lambda *_: port)
        measure_on_rig(experiment, tmp_path / name, port="emulated", clock=clock)
        return load_campaign(tmp_path / name)

    return run


class Recorded:
    """Board that records codes, octets and instructions."""

    def __init__(self, firmware):
        self.firmware = firmware
        self.codes, self.instructions, self.octets = [], [], b""

    def receive(self, data):
        self.firmware.receive(data)

    def poll(self):
        count = self.firmware.poll()
        self._count()
        return count

    def tick(self, words):
        self.codes.append(self.firmware.tick(words))
        self._count()
        return self.codes[-1]

    def _count(self):
        self.instructions.append(getattr(self.firmware, "instructions", 0))

    def transmit(self):
        octets = self.firmware.transmit()
        self.octets += octets
        return octets

    def frames(self):
        """Octets that the board has sent."""
        return [
            (frame.sequence, frame.code, frame.payload.replace(b"host", b"mps2"))
            for frame in Receiver().feed(self.octets)
        ]

    def close(self):
        self.firmware.close()


class Twins:
    """Two boards on one bench with the same inputs; the bench uses the codes of the first."""

    def __init__(self, first, second):
        self.both = first, second

    def receive(self, data):
        for board in self.both:
            board.receive(data)

    def transmit(self):
        return [board.transmit() for board in self.both][0]

    def poll(self):
        return [board.poll() for board in self.both][0]

    def tick(self, words):
        return [board.tick(words) for board in self.both][0]

    def close(self):
        for board in self.both:
            board.close()


def test_a_campaign_has_the_host_librarys_codes_replies_and_log_bit_for_bit(
    image, experiment, measure
):
    emulated, host = Recorded(EmulatedFirmware(image)), Recorded(HostFirmware(1))
    campaign = measure(experiment, SteppedRig("emulated", Twins(emulated, host), experiment.bench))

    assert len(emulated.codes) > 20_000
    assert emulated.codes == host.codes
    assert emulated.frames() == host.frames()

    # The schedule was executed: returns, load, speed, logs.
    codes = np.array(emulated.codes)
    assert codes[:, 0].min() < -100 < 100 < codes[:, 0].max()
    assert all(len(np.unique(codes[:, valve])) > 50 for valve in range(3))
    names = [word.name for word in RECORD]
    for raw in campaign.raw_runs():
        at_reference = (
            raw.words[:, names.index("flags")] & 1 << RECORD_FLAGS.index("at_reference") > 0
        )
        v = raw.words[at_reference, names.index("v")].view(np.int16) * 2e-5
        assert raw.outcome == "done" and at_reference.sum() > 30
        assert v.mean() == pytest.approx(0.12, abs=2e-3)
    assert len(campaign.entries) == 2


def test_the_same_campaign_again_takes_the_same_instructions(image, quick_schedule, measure):
    experiment, boards = one_speed(quick_schedule, trials=1), []
    for name in ("first", "second"):
        boards.append(Recorded(EmulatedFirmware(image)))
        start = time.perf_counter()
        rig = SteppedRig("emulated", boards[-1], experiment.bench)
        measure(experiment, rig, name)
        print(f"{rig.now() / 1e-4 / (time.perf_counter() - start):.0f} ticks/s")
    first, second = boards
    assert first.codes == second.codes
    assert first.octets == second.octets
    assert first.instructions == second.instructions
    assert min(first.instructions) > 0
    print(f"{sum(first.instructions)} instructions in {len(first.codes)} ticks and their polls")


def test_the_image_has_no_double_precision_no_heap_no_library_and_no_fused_arithmetic(
    mps2_build, require_tool
):
    image = mps2_build / "hbench-mps2.elf"

    def output(tool, option):
        command = [require_tool(f"arm-none-eabi-{tool}"), option, image]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    symbols = {line.split()[-1] for line in output("nm", "-n").splitlines()}
    assert {"hb_core_tick", "hb_link_poll"} <= symbols
    strange = re.compile(r"__aeabi_|__.*df|malloc|calloc|free|sbrk|printf|_impure")
    assert not [name for name in symbols if strange.search(name)]
    code = output("objdump", "-d")
    assert "vmul.f32" in code
    # vmla and vmls round the product before they add it, as two instructions would.
    assert not re.search(r"\bvfn?m[as]\.f32|\.f64", code)


def test_requests_in_flight_are_answered_in_their_order(board):
    board.receive(b"".join(encode(Frame(n, IDENTIFY, b"")) for n in range(60)))
    board.poll()
    frames = Receiver().feed(board.transmit())
    assert [(f.sequence, f.code) for f in frames] == [(n, IDENTIFY | REPLY) for n in range(60)]


def test_octets_beyond_the_queue_are_lost_and_the_next_request_is_answered(board):
    board.receive(b"\x01" * 5000 + b"\x00")
    assert board.poll() == 0
    board.receive(b"\x00" + encode(Frame(7, IDENTIFY, b"")))
    assert board.poll() > 0
    (frame,) = Receiver().feed(board.transmit())
    assert (frame.sequence, frame.code) == (7, IDENTIFY | REPLY)


class CutLine:
    """Port that fails to write from a given time on."""

    def __init__(self, rig, cut_s):
        self.name, self.read, self.now = rig.name, rig.read, rig.now
        self.rig, self.cut_s = rig, cut_s

    def write(self, data):
        if self.rig.now() > self.cut_s:
            raise DeviceError("cut")
        self.rig.write(data)

    def close(self):
        pass


def test_a_board_that_loses_its_host_in_a_run_stops(board, short_schedule, measure):
    experiment = workflow.load_experiment(short_schedule(trials=1), None)  # longer than a heartbeat
    rig = SteppedRig("emulated", board, experiment.bench)
    with pytest.raises(DeviceError, match="cut"):
        measure(experiment, CutLine(rig, cut_s=0.8))
    client = BoardClient(rig)
    rig.read(experiment.bench.limits.heartbeat + 0.1)
    status = client.status()
    assert (STATES[status["state"]], FAULTS[status["fault"]]) == ("fault", "heartbeat")


@pytest.mark.parametrize("call", ["tick", "poll", "receive"])
def test_an_emulator_that_is_killed_is_a_device_error_at_the_next_call(board, image, call):
    (process,) = emulators_of(image)
    os.kill(process, signal.SIGKILL)
    words = {"tick": [[0] * 8], "receive": [encode(Frame(1, IDENTIFY, b""))]}
    with pytest.raises(DeviceError, match=r"board\.elf:"):
        getattr(board, call)(*words.get(call, []))


def test_a_missing_image_is_a_configuration_error(tmp_path):
    with pytest.raises(ConfigError, match=r"none\.elf:"):
        EmulatedFirmware(tmp_path / "none.elf")


def test_without_the_emulator_the_hint_is_its_package(mps2_build, monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(DeviceError) as caught:
        EmulatedFirmware(mps2_build / "hbench-mps2.elf")
    assert emulator.PROGRAM in caught.value.message
    assert "qemu-system-arm" in caught.value.hint


def test_a_baud_rate_is_refused_since_the_emulated_uart_has_none(experiment, tmp_path):
    with pytest.raises(ConfigError, match="--baud"):
        workflow.serve_rig(
            tmp_path / "bench.yaml",
            plant=None,
            seed=1,
            image=tmp_path / "board.elf",
            address="localhost:0",
            baud=115200,
            full_speed=False,
            announce=print,
        )


def test_an_invalid_image_is_a_device_error_with_the_emulators_message(image):
    image.write_text("not an image")
    with pytest.raises(DeviceError, match=r"board\.elf: .*Lockup"):
        EmulatedFirmware(image)


def test_another_programs_image_is_a_device_error_and_its_emulator_ends(
    image, tmp_path, require_tool, monkeypatch
):
    source = tmp_path / "other.c"
    source.write_text(
        "void go(void) { for (;;) { } }\n"
        '__attribute__((section(".vectors"))) void *vectors[] = {(void *)0x20001000, go};\n'
    )
    options = ["-mcpu=cortex-m4", "-mthumb", "-nostdlib", "-Wl,--section-start=.vectors=0"]
    subprocess.run([require_tool("arm-none-eabi-gcc"), *options, source, "-o", image], check=True)
    monkeypatch.setattr(emulator, "_TIMEOUT_MS", 300)
    with pytest.raises(DeviceError, match=r"board\.elf:"):
        EmulatedFirmware(image)
    assert not emulators_of(image)


@pytest.fixture
def command(image, experiment, tmp_path):
    """Start ``hbench rig --emulate``; return the process and the name of its port."""
    options = ["--bench", "bench.yaml", "--emulate", str(image), "--socket", "localhost:0"]
    started = subprocess.Popen(
        [sys.executable, "-m", "hbench", "rig", *options],
        stdout=subprocess.PIPE,
        text=True,
        cwd=tmp_path,  # otherwise a checkout in the working folder would be imported
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    with killed_in_the_end(started) as process:
        yield process, process.stdout.readline().strip()


def test_a_campaign_over_the_served_socket_is_accepted_and_marked_as_simulated(command, tmp_path):
    process, port = command
    done = hbench("run", tmp_path / "short.yaml", "--port", port, "-o", tmp_path / "campaign")
    assert done.returncode == 0, done.stderr
    header = load_campaign(tmp_path / "campaign").header
    assert (header["source"], header["firmware"]["board"]) == ("simulated", "mps2")
    results = workflow.analyze(tmp_path / "campaign")
    assert [run.accepted for run in results.runs] == [True, True]


@pytest.mark.parametrize(
    "ending, code", [(signal.SIGINT, 0), (signal.SIGTERM, 0), (signal.SIGKILL, -signal.SIGKILL)]
)
def test_the_emulator_ends_with_the_command_however_that_ends(command, image, ending, code):
    process, _ = command
    assert len(emulators_of(image)) == 1
    process.send_signal(ending)
    rest, _ = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, rest) == (code, "")
    deadline = time.monotonic() + PATIENCE_S
    while emulators_of(image):
        assert time.monotonic() < deadline, "the emulator is still running"
        time.sleep(0.05)
