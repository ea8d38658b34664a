"""Discovery of boards on the serial ports.

Each port gets two identification requests, 0.5 s in all. Opening a port may toggle its control
lines (DTR, RTS), which resets some boards.
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
class ListedPort:
    """Serial port in the system's list."""

    name: str
    description: str


@dataclass(frozen=True)
class ProbedPort:
    """Result of probing a port."""

    port: ListedPort
    state: State
    board: Identity | None = None
    why: str = ""  # reason of an error


def system_ports() -> tuple[ListedPort, ...]:
    """Return the system's serial ports in order of name, without pseudo-terminals and sockets."""
    listed = sorted(list_ports.comports())
    return tuple(
        ListedPort(p.device, "" if p.description == "n/a" else p.description) for p in listed
    )


def probe_ports(
    ports: Iterable[ListedPort], opener: Callable[[str], Port] = SerialPort
) -> tuple[ProbedPort, ...]:
    """Request the identity on each port; only one port is open at a time."""
    return tuple(_probe(port, opener) for port in ports)


def _probe(port: ListedPort, opener: Callable[[str], Port]) -> ProbedPort:
    try:
        line = opener(port.name)
        try:
            return ProbedPort(port, "board", BoardClient(line, _ATTEMPTS).identify())
        finally:
            line.close()
    except PortBusy:
        return ProbedPort(port, "busy")
    except NoAnswer:
        return ProbedPort(port, "silent")
    except DeviceError as error:
        return ProbedPort(port, "error", why=error.message)
