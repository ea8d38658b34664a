"""Whatever a serial device does, the user gets one clear error with exit code 3."""

import os
import pty
import socket
import termios
import threading

import pytest

from hbench.errors import ConfigError, DeviceError, ExitCode
from hbench.rig.ports import PortBusy, SerialPort


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


def test_what_a_socket_has_ready_comes_in_one_read():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = SerialPort(f"socket://127.0.0.1:{server.getsockname()[1]}")
        connection, _ = server.accept()
        with connection:
            connection.sendall(bytes(1000))
            assert port.read(2.0) == bytes(1000)
        port.close()


def test_a_name_that_is_no_url_is_a_device_error():
    with pytest.raises(DeviceError, match="nonsense://"):
        SerialPort("nonsense://x")


def test_a_far_end_that_takes_nothing_is_a_device_error(line):
    port = SerialPort(line[1])
    port._serial.write_timeout = 0.05
    with pytest.raises(DeviceError, match="write failed"):
        for _ in range(1000):
            port.write(bytes(4096))


def test_fewer_octets_than_a_frame_are_returned_as_they_come(line):
    master, name = line
    port = SerialPort(name)
    received = []
    for part in (b"ab", b"c"):
        os.write(master, part)
        received.append(port.read(1.0))
    assert received == [b"ab", b"c"]


def test_octets_that_another_reader_took_are_a_device_error(line, monkeypatch):
    """What pyserial makes of two readers: the line is readable, and then there is nothing."""
    master, name = line
    port = SerialPort(name)
    os.write(master, b"x")
    monkeypatch.setattr("serial.serialposix.os.read", lambda *arguments: b"")
    with pytest.raises(DeviceError, match=name):
        port.read(0.1)


@pytest.mark.parametrize(
    "lost", [OSError(5, "Input/output error"), termios.error(5, "I/O"), TypeError("fileno")]
)
@pytest.mark.parametrize("action", ["read", "write", "close"])
def test_whatever_pyserial_raises_for_a_lost_port_is_one_error(line, monkeypatch, lost, action):
    def fail(*arguments):
        raise lost

    port = SerialPort(line[1])
    monkeypatch.setattr(port._serial, action, fail)
    if action == "close":
        port.close()
        return
    with pytest.raises(DeviceError, match=f"{line[1]}: .*{action}"):
        port.read(0.1) if action == "read" else port.write(b"x")


def test_a_port_open_elsewhere_is_told_from_a_missing_one(line):
    first = SerialPort(line[1])
    with pytest.raises(PortBusy, match=line[1]) as error:
        SerialPort(line[1])
    assert "other program" in error.value.hint
    first.close()
    SerialPort(line[1]).close()


def test_a_device_that_never_falls_silent_can_still_be_opened(line):
    master, name = line
    stop = threading.Event()

    def talk():
        while not stop.wait(0.002):
            os.write(master, b"$GPGGA\r\n")

    thread = threading.Thread(target=talk)
    thread.start()
    try:
        port = SerialPort(name)
        assert port.read(5.0)
        port.close()
    finally:
        stop.set()
        thread.join()


def test_a_server_that_hangs_up_is_a_device_error():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = SerialPort(f"socket://127.0.0.1:{server.getsockname()[1]}")
        server.accept()[0].close()
        with pytest.raises(DeviceError, match="socket disconnected"):
            port.read(5.0)
        port.close()


def test_nobody_listening_is_a_device_error():
    with socket.create_server(("127.0.0.1", 0)) as server:
        number = server.getsockname()[1]
    with pytest.raises(DeviceError, match="open failed"):
        SerialPort(f"socket://127.0.0.1:{number}")


@pytest.mark.parametrize("name", ["socket://localhost", "socket://:5000", "socket://a:b"])
def test_a_socket_without_host_and_port_is_refused_as_a_wrong_option(name):
    with pytest.raises(ConfigError, match="has no host and port") as raised:
        SerialPort(name)
    assert "socket://localhost:5000" in raised.value.hint


def test_a_port_that_does_not_exist_is_named_once_with_the_cause():
    with pytest.raises(DeviceError) as raised:
        SerialPort("/dev/nonexistent-tty")
    assert raised.value.message == (
        "/dev/nonexistent-tty: serial open failed: No such file or directory"
    )
    assert "hbench ports" in raised.value.hint
