"""Byte ports to a board: a serial line or socket (pyserial), or the virtual rig.

A port has its own clock. On hardware it is the wall's; the virtual rig's is its simulated time,
so that the client's timeouts mean the same on both.
"""

import errno
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Protocol

import serial

from hbench.errors import DeviceError

_ERRORS: tuple[type[Exception], ...] = (OSError, TypeError, ValueError)  # of a lost or busy port
with suppress(ImportError):  # not on Windows
    import termios

    _ERRORS += (termios.error,)

BAUD = 115_200
_CHUNK = 4096


class PortBusy(DeviceError):
    """Another program has the port open."""


class Port(Protocol):
    """A line of octets to one board."""

    name: str

    def write(self, data: bytes) -> None:
        """Send all octets. Raises ``DeviceError``."""

    def read(self, timeout_s: float) -> bytes:
        """Return what has come, at once if there is something; empty after the timeout."""

    def now(self) -> float:
        """Seconds on the port's clock."""

    def close(self) -> None:
        """Let go of the line."""


class SerialPort:
    """A serial device, or any URL that pyserial opens (``socket://host:port``)."""

    def __init__(self, name: str, baud: int = BAUD):
        self.name = name
        own_lock = {} if "://" in name else {"exclusive": True}
        with self._errors("open"):
            self._serial = serial.serial_for_url(
                name, baudrate=baud, timeout=0, write_timeout=2.0, **own_lock
            )
        self._drain()

    def write(self, data: bytes) -> None:
        """Send all octets."""
        with self._errors("write"):
            self._serial.write(data)

    def read(self, timeout_s: float) -> bytes:
        """Return what has come, at once if there is something; empty after the timeout."""
        with self._errors("read"):
            self._serial.timeout = max(timeout_s, 0.0)
            first = self._serial.read(1)
            if not first:
                return b""
            self._serial.timeout = 0  # the rest of what is there; a socket's in_waiting is 0 or 1
            return first + self._serial.read(_CHUNK)

    def now(self) -> float:
        """Seconds of the monotonic clock."""
        return time.monotonic()

    def close(self) -> None:
        """Close the device; one that has vanished is closed already."""
        try:
            self._serial.close()
        except _ERRORS:
            return

    def _drain(self) -> None:
        """Drop what an earlier session left on the way (USB adapters keep some of it).

        A device that never falls silent is left talking after half a second.
        """
        deadline = self.now() + 0.5
        while self.read(0.02) and self.now() < deadline:
            pass

    @contextmanager
    def _errors(self, action: str) -> Iterator[None]:
        """Turn all that pyserial raises for a lost or busy port into one clear error."""
        try:
            yield
        except serial.SerialTimeoutException as error:
            raise DeviceError(
                f"{self.name}: the line takes no more octets ({error})", _hint(None)
            ) from None
        except _ERRORS as error:
            code = getattr(error, "errno", None)
            kind = PortBusy if code in (errno.EAGAIN, errno.EBUSY) else DeviceError
            raise kind(f"{self.name}: can't {action}: {error}", _hint(code)) from None


def _hint(code: int | None) -> str:
    if code == errno.ENOENT:
        return "No such device; `--port sim` runs on the virtual rig."
    if code in (errno.EACCES, errno.EPERM):
        return "Permission is missing; on Linux add yourself to the group 'dialout'."
    if code in (errno.EAGAIN, errno.EBUSY):
        return "Another program has the port open."
    return "Check that the board has power and the cable is in."
