"""Looks at serial ports for boards: what is there, and what answers.

Two answers are waited for on each port, 0.5 s in all. Opening a port may toggle its control lines
(DTR, RTS), which resets some boards.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal

from serial.tools import list_ports

from hbench.errors import DeviceError
from hbench.rig.client import BoardClient, Identity, NoAnswer
from hbench.rig.ports import Port, PortBusy, SerialPort

State = Literal["board", "silent", "busy", "error"]
_ATTEMPTS = 2


@dataclass(frozen=True)
class Listed:
    """A port, as the system lists it."""

    name: str
    description: str


@dataclass(frozen=True)
class Found:
    """What a look at a port showed."""

    port: Listed
    state: State
    board: Identity | None = None
    why: str = ""  # of an error


def system_ports() -> tuple[Listed, ...]:
    """Return the serial ports that the system knows, by name; no pseudo-terminals or sockets."""
    listed = sorted(list_ports.comports())
    return tuple(Listed(p.device, "" if p.description == "n/a" else p.description) for p in listed)


def look(ports: Iterable[Listed], opener: Callable[[str], Port] = SerialPort) -> tuple[Found, ...]:
    """Ask on each port who is there; each is open for its own look alone."""
    return tuple(_look(port, opener) for port in ports)


def _look(port: Listed, opener: Callable[[str], Port]) -> Found:
    try:
        line = opener(port.name)
        try:
            return Found(port, "board", BoardClient(line, _ATTEMPTS).identify())
        finally:
            line.close()
    except PortBusy:
        return Found(port, "busy")
    except NoAnswer:
        return Found(port, "silent")
    except DeviceError as error:
        return Found(port, "error", why=error.message)
