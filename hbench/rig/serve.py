"""Server of the virtual rig for other programs: relation of simulated time and wall time.

With ``WallClock``, simulated time follows wall time. ``FullSpeed`` can't run without pauses: two
simulated seconds, a bench's usual heartbeat limit, take some milliseconds of wall time. Each
message of the client therefore grants an interval of simulated time shorter than that limit, which
runs at full speed; then time stops until the next message. Without a client, both follow wall
time, so that a rig whose client has left stops by its heartbeat limit, as a real one does.
"""

import time
from collections.abc import Callable
from typing import Protocol

from hbench.rig.lines import ServerLine
from hbench.rig.ports import Port

_SLICE_S = 0.002  # of wall time, between two reads of the line
_FULL_SPEED_SLICE_S = 0.01  # of simulated time, the same
_IDLE_S = 0.1  # of wall time, the same while simulated time is stopped
_MAX_GAP_S = 0.1


class Pace(Protocol):
    """Control of simulated time."""

    def received(self, simulated_s: float) -> None:
        """Note a message of the client."""

    def due_s(self, simulated_s: float) -> float:
        """Return the simulated time to run now, s."""

    def wait_s(self, simulated_s: float) -> float:
        """Return the wall time to wait for the client before that, s."""


class WallClock:
    """Pace at which simulated time follows wall time.

    A difference of more than 0.1 s, caused by a busy or suspended machine, is dropped: otherwise
    the bench would simulate it before reading the host's messages.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._zero_s = clock()

    def received(self, simulated_s: float) -> None:
        """Do nothing."""

    def due_s(self, simulated_s: float) -> float:
        """Return the lag of simulated time behind wall time, s."""
        lag = self._clock() - self._zero_s - simulated_s
        if abs(lag) > _MAX_GAP_S:
            self._zero_s += lag
            return 0.0
        return lag

    def wait_s(self, simulated_s: float) -> float:
        """Return the length of a slice, s."""
        return _SLICE_S


class FullSpeed:
    """Pace at full speed, up to ``interval_s`` of simulated time after a client's message."""

    def __init__(self, interval_s: float):
        self._interval_s = interval_s
        self._end_s = 0.0

    def received(self, simulated_s: float) -> None:
        """Grant a new interval."""
        self._end_s = simulated_s + self._interval_s

    def due_s(self, simulated_s: float) -> float:
        """Return a slice of the remaining interval, s."""
        return min(self._end_s - simulated_s, _FULL_SPEED_SLICE_S)

    def wait_s(self, simulated_s: float) -> float:
        """Return zero during the interval, else the idle time, s."""
        return 0.0 if self._end_s > simulated_s else _IDLE_S


def serve(rig: Port, line: ServerLine, pace: Pace, stop: Callable[[], bool]) -> None:
    """Run the rig for the clients of the line, until ``stop()`` returns True."""
    without_client = WallClock()
    while not stop():
        present = pace if line.connected else without_client
        data = line.read(present.wait_s(rig.now()))
        end_s = rig.now() + present.due_s(rig.now())
        while (left := end_s - rig.now()) > 0:
            line.write(rig.read(left))  # returns early when the board sends
        if data:
            rig.write(data)
            pace.received(rig.now())
