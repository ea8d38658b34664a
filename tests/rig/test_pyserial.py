"""What pyserial does when a line fails, on a real pseudo-terminal, and what a user then sees.

Each case is first shown to happen, so that another pyserial that behaves otherwise is noticed.
"""

import errno
import os
import pty
import select
import termios
import threading
import time
import tty

import pytest
import serial

from hbench.cli.main import main
from hbench.errors import DeviceError
from hbench.rig.client import BoardClient
from hbench.rig.lines import PtyLine, SocketLine
from hbench.rig.ports import PortBusy, SerialPort
from hbench.rig.serve import WallClock, serve
from hbench.rig.virtual import VirtualRig
from hbench.store.campaign.folder import load_campaign


@pytest.fixture
def line():
    master, slave = pty.openpty()
    tty.setraw(slave)
    name = os.ttyname(slave)
    os.close(slave)
    ends = [master]
    yield ends, name
    for end in ends:
        os.close(end)


def peer_gone(ends, device):
    os.close(ends.pop())


def closed(ends, device):
    device.close()


def reader_stalled(ends, device):
    device.write_timeout = 0.05


CASES = {
    "peer gone, read": (peer_gone, lambda d: d.read(1), serial.SerialException),
    "peer gone, write": (peer_gone, lambda d: d.write(b"x"), OSError),
    "peer gone, in_waiting": (peer_gone, lambda d: d.in_waiting, OSError),
    "peer gone, flush": (peer_gone, lambda d: d.flush(), termios.error),
    "peer gone, reset": (peer_gone, lambda d: d.reset_input_buffer(), termios.error),
    "closed, in_waiting": (closed, lambda d: d.in_waiting, TypeError),
    "closed, read": (closed, lambda d: d.read(1), serial.SerialException),
    "parity on a pty": (None, lambda d: setattr(d, "parity", "E"), termios.error),
    "rts on a pty": (None, lambda d: setattr(d, "rts", True), OSError),
    "stalled reader, write": (
        reader_stalled,
        lambda d: [d.write(bytes(4096)) for _ in range(1000)],
        serial.SerialTimeoutException,
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_what_pyserial_raises_is_one_error_that_names_the_port(line, case):
    happen, use, raises = CASES[case]
    ends, name = line
    port = SerialPort(name)
    if happen:
        happen(ends, port._serial)
    with pytest.raises(raises):
        use(port._serial)
    with pytest.raises(DeviceError, match=f"^{name}: ") as error, port._errors("use"):
        use(port._serial)
    assert error.value.exit_code == 3 and error.value.hint
    port.close()


def test_a_read_that_is_short_is_no_error(line):
    ends, name = line
    port = SerialPort(name)
    os.write(ends[0], b"ab")
    port._serial.timeout = 0.05
    assert port._serial.read(5) == b"ab"
    os.write(ends[0], b"cd")
    assert port.read(1.0) == b"cd"
    port.close()


def test_exclusive_keeps_a_second_hbench_out_and_not_a_plain_opener(line):
    _, name = line
    first = SerialPort(name)
    with pytest.raises(PortBusy, match=name):
        SerialPort(name)
    serial.Serial(name).close()
    first.close()


@pytest.fixture
def hbench(quick_schedule, tmp_path, monkeypatch, capsys):
    """Call ``hbench run`` on a port in this process; returns exit code and stderr."""

    def call(port, *options):
        arguments = ["hbench", "run", quick_schedule(), "-o", tmp_path / "out", "--port", port]
        monkeypatch.setattr("sys.argv", [str(part) for part in (*arguments, *options)])
        try:
            main()
            code = 0
        except SystemExit as end:
            code = end.code or 0
        told = capsys.readouterr().err
        assert "Traceback" not in told
        return code, told

    return call


RAISED = {
    "read": serial.SerialException("device reports readiness to read but returned no data"),
    "in_waiting": OSError(errno.EIO, "Input/output error"),
    "flush": termios.error(errno.EIO, "Input/output error"),
    "closed": TypeError("argument must be an int, or have a fileno() method."),
    "parity": termios.error(errno.EINVAL, "Invalid argument"),
    "write": serial.SerialTimeoutException("Write timeout"),
}


@pytest.mark.parametrize("case", RAISED)
def test_the_command_line_ends_with_exit_code_3_and_a_message(line, hbench, monkeypatch, case):
    def fail(*arguments):
        raise RAISED[case]

    monkeypatch.setattr(serial.Serial, "write", fail)
    code, told = hbench(line[1])
    assert code == 3 and f"error: {line[1]}: " in told and "hint: " in told


def test_a_port_that_another_program_holds_ends_with_exit_code_3(line, hbench):
    holder = SerialPort(line[1])
    code, told = hbench(line[1])
    assert code == 3 and f"error: {line[1]}: " in told
    assert "other program" in told
    holder.close()


class Server:
    """A virtual rig that is served in a thread; ``meddle`` is called with each slice of time."""

    def __init__(self, bench, meddle=lambda server: None, line=None):
        self.rig, self.line = VirtualRig(bench), line or PtyLine()
        self.rig.read(0.0)
        self._stop = threading.Event()
        self._meddle = meddle
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self):
        def over():
            self._meddle(self)
            return self._stop.is_set()

        serve(self.rig, self.line, WallClock(), over)

    def stop(self):
        self._stop.set()
        self._thread.join()


def test_a_cable_pulled_in_the_middle_of_a_run_ends_with_exit_code_3(
    quick_experiment, hbench, tmp_path
):
    def pull(server):
        if (tmp_path / "out" / "runs" / "0001.dat").exists() and not server._stop.is_set():
            server._stop.set()

    server = Server(quick_experiment.bench, pull)
    name = server.line.name
    puller = threading.Thread(target=lambda: (server._thread.join(), server.line.close()))
    puller.start()
    code, told = hbench(name)
    assert code == 3 and f"{name}: serial " in told
    puller.join()
    server.rig.close()
    campaign = load_campaign(tmp_path / "out")
    assert "0001" in campaign.done
    assert all(e.stop.outcome == "done" or name in e.stop.why for e in campaign.entries)


def test_a_second_client_of_a_socket_ends_with_exit_code_3_and_the_first_stays(
    quick_experiment, hbench
):
    server = Server(quick_experiment.bench, line=SocketLine("localhost:0"))
    first = SerialPort(server.line.name)
    client = BoardClient(first)
    client.identify()
    code, told = hbench(server.line.name)
    assert code == 3 and f"error: {server.line.name}: " in told
    assert client.identify().board == "host"
    first.close()
    server.stop()
    server.line.close()
    server.rig.close()


def test_a_plain_second_opener_that_steals_octets_costs_no_run(quick_experiment, hbench, tmp_path):
    """It takes what it can for a while, as a terminal program on the same port does."""
    server, stolen, over = Server(quick_experiment.bench), [], []

    def steal():
        while not (tmp_path / "out" / "runs" / "0001.dat").exists() and not over:
            time.sleep(0.01)
        thief = os.open(server.line.name, os.O_RDWR | os.O_NOCTTY)
        while sum(map(len, stolen)) < 50 and not over:
            if select.select([thief], [], [], 0.1)[0]:
                stolen.append(os.read(thief, 5))
        os.close(thief)

    thread = threading.Thread(target=steal)
    thread.start()
    try:
        code, told = hbench(server.line.name)
        if code:  # the reader found nothing where the system had said that there was something
            assert code == 3 and f"error: {server.line.name}: " in told
            over.append(True)
            assert hbench(server.line.name, "--resume")[0] == 0
        assert b"".join(stolen)
        assert BoardClient(SerialPort(server.line.name)).status()["fault"] == 0
    finally:
        over.append(True)
        thread.join()
        server.stop()
        server.line.close()
        server.rig.close()
    campaign = load_campaign(tmp_path / "out")
    assert [e.plan.run for e in campaign.entries if e.stop and e.stop.outcome == "done"] == [
        plan.run for plan in quick_experiment.plans
    ]
