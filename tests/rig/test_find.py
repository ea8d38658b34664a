"""Looking for boards: each port gets its own verdict, and is let go of afterwards."""

import json
import os
import pty

import pytest
from serial.tools import list_ports
from typer.testing import CliRunner

from hbench.cli.main import app
from hbench.errors import DeviceError
from hbench.protocol.codec import BY_NAME, pack
from hbench.protocol.dictionary import REPLY
from hbench.protocol.frames import Frame, Receiver, encode
from hbench.rig.discovery import ListedPort, probe_ports, system_ports
from hbench.rig.ports import PortBusy, SerialPort
from tests.support.board.paper import IDENTITY


class Device:
    """A port that answers identify with an identity, or talks without end, or not at all."""

    def __init__(self, name, identity=None, chatter=b""):
        self.name, self.identity, self.chatter = name, identity, chatter
        self.waiting, self.time, self.closed = b"", 0.0, False

    def write(self, data):
        for frame in Receiver().feed(data):
            if self.identity:
                payload = pack(BY_NAME["identify"].reply, self.identity)
                self.waiting += encode(Frame(frame.sequence, frame.code | REPLY, payload))

    def read(self, timeout_s):
        data, self.waiting = self.waiting or self.chatter, b""
        self.time += 0.001 if data else timeout_s
        return data

    def now(self):
        return self.time

    def close(self):
        self.closed = True


DEVICES = {
    "A": Device("A", IDENTITY),
    "B": Device("B"),
    "C": Device("C", chatter=b"$GPGGA,092750.000,5321.6802,N\r\n"),
    "D": Device("D", IDENTITY | {"dictionary": 1}),
}


def opener(name):
    if name == "E":
        raise PortBusy("E: can't open")
    if name == "F":
        raise DeviceError("F: refused")
    return DEVICES[name]


@pytest.fixture
def found():
    return {
        f.port.name: f for f in probe_ports([ListedPort(n, f"port {n}") for n in "ABCDEF"], opener)
    }


def test_each_port_gets_its_verdict(found):
    states = {name: f.state for name, f in found.items()}
    assert states == {
        "A": "board", "B": "silent", "C": "silent", "D": "error", "E": "busy", "F": "error"
    }  # fmt: skip
    assert (found["A"].board.board, found["A"].board.firmware) == ("paper", "test 1")
    assert "'test 1' on board 'paper'" in found["D"].why  # of another version, by name
    assert found["F"].why == "F: refused"


def test_a_silent_port_costs_about_half_a_second_and_every_port_is_closed(found):
    assert all(device.closed for device in DEVICES.values())
    quiet = Device("B")
    probe_ports([ListedPort("B", "")], lambda name: quiet)
    assert quiet.now() == pytest.approx(0.5, abs=0.05)


def test_a_port_that_another_program_has_open_is_busy_and_stays_its():
    master, slave = pty.openpty()
    name = os.ttyname(slave)
    other = SerialPort(name)
    (found,) = probe_ports([ListedPort(name, "")])
    assert found.state == "busy"
    os.write(master, b"for the other")
    assert other.read(1.0) == b"for the other"
    other.close()
    for end in (master, slave):
        os.close(end)


def test_the_systems_ports_come_in_order_without_placeholder_descriptions(monkeypatch):
    ports = [list_ports_info("/dev/ttyUSB10", "FT232R"), list_ports_info("/dev/ttyUSB9", "n/a")]
    monkeypatch.setattr(list_ports, "comports", lambda: ports)
    assert system_ports() == (ListedPort("/dev/ttyUSB9", ""), ListedPort("/dev/ttyUSB10", "FT232R"))


def list_ports_info(device, description):
    from serial.tools.list_ports_common import ListPortInfo

    info = ListPortInfo(device)
    info.description = description
    return info


@pytest.fixture
def command(monkeypatch):
    """Return a function that runs ``hbench ports`` where a board and a busy port are there."""
    from hbench.workflow import board

    monkeypatch.setattr(
        board, "system_ports", lambda: [ListedPort("A", "probe"), ListedPort("E", "")]
    )
    monkeypatch.setattr(board, "probe_ports", lambda ports: probe_ports(ports, opener))

    def run(*arguments):
        result = CliRunner().invoke(app, ["ports", *arguments])
        assert result.exit_code == 0, result.output
        return result.stdout

    return run


def test_the_table_tells_boards_from_busy_ports(command):
    assert command().splitlines() == [
        "A  board 'paper', firmware 'test 1'  probe",
        "E  busy",
    ]


def test_json_is_one_object(command):
    ports = json.loads(command("--json"))["ports"]
    assert [(p["port"], p["state"], p["firmware"], p["board"]) for p in ports] == [
        ("A", "board", "test 1", "paper"),
        ("E", "busy", None, None),
    ]


def test_named_ports_are_looked_at_alone(command):
    assert command("B") == "B  silent\n"


def test_no_ports_are_said_to_be_none(command, monkeypatch):
    from hbench.workflow import board

    monkeypatch.setattr(board, "system_ports", lambda: ())
    (line,) = command().splitlines()
    assert not any(line.startswith(f"{name} ") for name in DEVICES)
    assert json.loads(command("--json"))["ports"] == []


def test_the_name_of_a_board_is_no_command_to_the_terminal():
    device = Device("A", IDENTITY | {"firmware": "\x1b]0;title\x07\x1b[2J", "board": "a\rb"})
    (probed,) = probe_ports([ListedPort("A", "")], lambda name: device)
    assert (probed.board.firmware, probed.board.board) == ("?]0;title??[2J", "a?b")
