"""Serves the virtual rig to other programs: ties its simulated time to a client on the wall's.

``WallClock`` lets simulated time follow the wall's. ``FlatOut`` can't simply run as fast as it
goes: two simulated seconds, a bench's usual limit for a silent host, are over in some milliseconds
of the wall. So each word of the client grants a share of simulated time, shorter than that limit;
it is run through at full speed, and then time stands still until the next word. While nobody is
connected, both follow the wall, so that a rig whose client has left stops itself by its own
limit, as a real one does.
"""

import time
from collections.abc import Callable
from typing import Protocol

from hbench.rig.lines import Line
from hbench.rig.ports import Port

_SLICE_S = 0.002  # of the wall, between two looks at the line
_FLAT_SLICE_S = 0.01  # of simulated time, the same
_IDLE_S = 0.1  # of the wall, the same while time stands still
_MAX_GAP_S = 0.1


class Pace(Protocol):
    """How much simulated time is due."""

    def heard(self, simulated_s: float) -> None:
        """The client has spoken."""

    def due_s(self, simulated_s: float) -> float:
        """Simulated seconds to run now."""

    def rest_s(self, simulated_s: float) -> float:
        """Seconds of the wall to wait for the client before that."""


class WallClock:
    """Simulated time follows the wall's.

    Where the two are more than 0.1 s apart, because the machine was busy or asleep, the gap is
    dropped: the bench would run through it before it reads what its host said meanwhile.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic):
        self._clock = clock
        self._zero_s = clock()

    def heard(self, simulated_s: float) -> None:
        """Changes nothing."""

    def due_s(self, simulated_s: float) -> float:
        """Return how far the simulation is behind the wall, s."""
        lag = self._clock() - self._zero_s - simulated_s
        if abs(lag) > _MAX_GAP_S:
            self._zero_s += lag
            return 0.0
        return lag

    def rest_s(self, simulated_s: float) -> float:
        """Return the length of a slice, s."""
        return _SLICE_S


class FlatOut:
    """Simulated time runs at full speed, up to ``share_s`` after the client's last word."""

    def __init__(self, share_s: float):
        self._share_s = share_s
        self._end_s = 0.0

    def heard(self, simulated_s: float) -> None:
        """Grant a new share."""
        self._end_s = simulated_s + self._share_s

    def due_s(self, simulated_s: float) -> float:
        """Return a slice of what is left of the share, s."""
        return min(self._end_s - simulated_s, _FLAT_SLICE_S)

    def rest_s(self, simulated_s: float) -> float:
        """Return zero while time is left."""
        return 0.0 if self._end_s > simulated_s else _IDLE_S


def serve(rig: Port, line: Line, pace: Pace, stop: Callable[[], bool]) -> None:
    """Run the rig for the clients that come over the line, until ``stop()``."""
    alone = WallClock()
    while not stop():
        present = pace if line.connected else alone
        heard = line.read(present.rest_s(rig.now()))
        end_s = rig.now() + present.due_s(rig.now())
        while (left := end_s - rig.now()) > 0:
            line.write(rig.read(left))  # comes back early when the board speaks
        if heard:
            rig.write(heard)
            pace.heard(rig.now())
