"""Whatever a serial device does, the user gets one clear error with exit code 3."""

import os
import pty
import socket
import threading

import pytest

from hbench.errors import DeviceError, ExitCode
from hbench.rig.ports import SerialPort


@pytest.fixture
def line():
    master, slave = pty.openpty()
    yield master, os.ttyname(slave)
    for end in (master, slave):
        try:
            os.close(end)
        except OSError:
            pass


def test_octets_go_both_ways(line):
    master, name = line
    port = SerialPort(name)
    port.write(b"\x00ping\xff\r\n\x11\x13")
    assert os.read(master, 100) == b"\x00ping\xff\r\n\x11\x13"
    os.write(master, b"\x00pong\xff\r\n\x11\x13")
    assert port.read(1.0) == b"\x00pong\xff\r\n\x11\x13"
    port.close()


def test_silence_is_an_empty_read_after_the_timeout(line):
    port = SerialPort(line[1])
    start = port.now()
    assert port.read(0.05) == b""
    assert 0.04 < port.now() - start < 1.0


def test_leftovers_of_an_earlier_session_are_dropped(line):
    master, name = line
    os.write(master, b"old")
    port = SerialPort(name)
    assert port.read(0.0) == b""


def test_a_missing_device_is_named():
    with pytest.raises(DeviceError, match="/dev/nothing-here") as error:
        SerialPort("/dev/nothing-here")
    assert error.value.exit_code == ExitCode.DEVICE
    assert "--port sim" in error.value.hint


def test_a_port_that_is_open_elsewhere_is_refused(line):
    first = SerialPort(line[1])
    with pytest.raises(DeviceError, match="can't open"):
        SerialPort(line[1])
    first.close()


@pytest.mark.parametrize("action", ["read", "write"])
def test_a_vanished_device_is_a_device_error(line, action):
    master, name = line
    port = SerialPort(name)
    os.close(master)
    with pytest.raises(DeviceError, match=name):
        for _ in range(3):
            port.read(0.05) if action == "read" else port.write(b"x")
    port.close()


def test_a_closed_port_is_a_device_error(line):
    port = SerialPort(line[1])
    port.close()
    with pytest.raises(DeviceError):
        port.read(0.01)
    port.close()


def test_a_socket_is_a_port_too():
    server = socket.create_server(("127.0.0.1", 0))

    def echo():
        connection, _ = server.accept()
        with connection:
            connection.sendall(connection.recv(100)[::-1])
            connection.recv(1)

    thread = threading.Thread(target=echo, daemon=True)
    thread.start()
    port = SerialPort(f"socket://127.0.0.1:{server.getsockname()[1]}")
    port.write(b"abc")
    received = b""
    while len(received) < 3:
        received += port.read(2.0)
    assert received == b"cba"
    port.close()
    thread.join(5)
    server.close()


def test_a_name_that_is_no_url_is_a_device_error():
    with pytest.raises(DeviceError, match="nonsense://"):
        SerialPort("nonsense://x")
