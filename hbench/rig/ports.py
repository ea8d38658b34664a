"""Byte ports to a board: a serial line or socket (pyserial), or the virtual rig.

A port has its own clock: wall time on hardware, simulated time on the virtual rig, so that the
client's timeouts have the same meaning on both.
"""

import errno
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Protocol
from urllib.parse import urlsplit

import serial

from hbench.errors import ConfigError, DeviceError

_ERRORS: tuple[type[Exception], ...] = (OSError, TypeError, ValueError)  # of a lost or busy port
with suppress(ImportError):  # not on Windows
    import termios

    _ERRORS += (termios.error,)

BAUD = 115_200
_CHUNK = 4096
_SOCKET = "socket://"
_SOCKET_HINT = "Check the address, and that the board's server or `hbench rig --socket` runs there."


class PortBusy(DeviceError):
    """A port opened by another program."""


class Port(Protocol):
    """A line of octets to one board."""

    name: str

    def write(self, data: bytes) -> None:
        """Send all octets. Raises ``DeviceError``."""

    def read(self, timeout_s: float) -> bytes:
        """Return the octets received, as soon as there are any; empty after the timeout."""

    def now(self) -> float:
        """Return the port's clock, s."""

    def close(self) -> None:
        """Close the line."""


class SerialPort:
    """A serial device, or any URL that pyserial opens (``socket://host:port``)."""

    def __init__(self, name: str, baud: int = BAUD, parity: str = "N"):
        self.name = name
        if name.startswith(_SOCKET):
            _check_address(name)
        own_lock = {} if "://" in name else {"exclusive": True}
        with self._errors("open"):
            self._serial = serial.serial_for_url(
                name, baudrate=baud, parity=parity, timeout=0, write_timeout=2.0, **own_lock
            )
        self._drain()

    def write(self, data: bytes) -> None:
        """Send all octets."""
        with self._errors("write"):
            self._serial.write(data)

    def read(self, timeout_s: float) -> bytes:
        """Return the octets received, as soon as there are any; empty after the timeout."""
        with self._errors("read"):
            self._serial.timeout = max(timeout_s, 0.0)
            first = self._serial.read(1)
            if not first:
                return b""
            self._serial.timeout = 0  # reads what else has arrived; in_waiting fails with sockets
            return first + self._serial.read(_CHUNK)

    def now(self) -> float:
        """Return the monotonic clock, s."""
        return time.monotonic()

    def close(self) -> None:
        """Close the device; a vanished device is closed already."""
        try:
            self._serial.close()
        except _ERRORS:
            return

    def _drain(self) -> None:
        """Drop octets of an earlier session (USB adapters buffer some), for at most 0.5 s."""
        deadline = self.now() + 0.5
        while self.read(0.02) and self.now() < deadline:
            pass

    @contextmanager
    def _errors(self, action: str) -> Iterator[None]:
        """Convert pyserial's errors for a lost or busy port to ``DeviceError``."""
        try:
            yield
        except serial.SerialTimeoutException as error:
            raise DeviceError(f"{self.name}: serial write failed: {error}", _hint(None)) from None
        except _ERRORS as error:
            code = getattr(error, "errno", None)
            kind = PortBusy if code in (errno.EAGAIN, errno.EBUSY) else DeviceError
            hint = _SOCKET_HINT if self.name.startswith(_SOCKET) else _hint(code)
            raise kind(f"{self.name}: serial {action} failed: {_cause(error)}", hint) from None


def _check_address(name: str) -> None:
    """Raise ``ConfigError`` where a socket's address has no host or no port."""
    try:
        parts = urlsplit(name)
        complete = bool(parts.hostname and parts.port)
    except ValueError:  # a port that is no number
        complete = False
    if not complete:
        raise ConfigError(
            f"{name}: has no host and port", "Give both, such as socket://localhost:5000."
        )


def _cause(error: Exception) -> str:
    """Return the system's words for an error, without the port's name, which pyserial repeats."""
    code = getattr(error, "errno", None)
    return os.strerror(code) if code else str(error)


def _hint(code: int | None) -> str:
    if code == errno.ENOENT:
        return "List the serial ports with `hbench ports`; --port sim is the virtual rig."
    if code in (errno.EACCES, errno.EPERM):
        return "Get permission for the port; on Linux add yourself to the group 'dialout'."
    if code in (errno.EAGAIN, errno.EBUSY):
        return "Close the other program that has the port open."
    return "Check the board's power and the cable."
