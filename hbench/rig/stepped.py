"""Virtual rig whose board is stepped from Python, such as an emulated one.

``virtual.py`` is some fifty times faster; it needs a board that compiled code can call.
"""

from collections.abc import Sequence
from typing import Protocol

from hbench.config.bench import Bench, Plant
from hbench.model.compiled import compiled
from hbench.model.effects.applied import oil_temperature
from hbench.model.plant import TICK_S, V, forces, step
from hbench.model.scatter import update_levels
from hbench.model.sensing import convert, sensed
from hbench.model.simulated_bench import VOLTS_PER_CODE, new_simulated_bench
from hbench.rig.firmware import POLL_TICKS


class SteppedBoard(Protocol):
    """Firmware that is called step by step: ``HostFirmware`` or ``EmulatedFirmware``."""

    def receive(self, data: bytes) -> object:
        """Send octets to the board; those beyond its queue are lost."""

    def transmit(self) -> bytes:
        """Return the octets for the host, and remove them from the queue."""

    def poll(self) -> int:
        """Run the idle loop once; return the number of octets for the host."""

    def tick(self, adc: Sequence[int]) -> tuple[int, int, int]:
        """Run one control tick: converter words (8, in 1/16 count) to DAC codes (3)."""

    def close(self) -> None:
        """Switch the board off."""


@compiled
def _next_words(first, bench):
    """Simulate one tick (none before the ``first`` call), then convert the sensors' values."""
    words, codes, state, levels, noise, par, sensors, values, u, work = bench
    if not first:
        for valve in range(3):
            u[valve] = codes[valve] * VOLTS_PER_CODE
        on_masses = forces(state, levels, par, work[0])
        step(state, u, on_masses, levels, par, TICK_S, work)
        update_levels(levels, state[V], noise, par)
    sensed(state, forces(state, levels, par, work[0]), par, values)
    convert(values, oil_temperature(state, par, par.effects), sensors, noise, words)


class SteppedRig:
    """A board and its simulated bench, as a ``Port``; simulated time advances in ``read`` only.

    ``plant`` replaces the bench's own physics.
    """

    def __init__(
        self,
        name: str,
        board: SteppedBoard,
        bench: Bench,
        plant: Plant | None = None,
        seed: int = 1,
    ):
        self.name = name
        self._board = board
        self._bench = new_simulated_bench(bench, plant, seed)
        self._tick = 0

    def write(self, data: bytes) -> None:
        """Send octets to the board."""
        self._board.receive(data)

    def read(self, timeout_s: float) -> bytes:
        """Simulate until the board sends octets or the timeout is over; return the octets."""
        last = self._tick + max(1, round(timeout_s / TICK_S))
        while self._tick < last:
            _next_words(self._tick == 0, self._bench)
            self._bench.codes[:] = self._board.tick(self._bench.words.tolist())
            self._tick += 1
            if self._tick % POLL_TICKS == 0 and self._board.poll() > 0:
                break
        return self._board.transmit()

    def now(self) -> float:
        """Simulated seconds since power-on."""
        return self._tick * TICK_S

    def close(self) -> None:
        """Switch the board off."""
        self._board.close()
