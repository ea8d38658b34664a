"""A board that is stepped from Python, and the simulated bench, behind a byte port.

Where the board's tick can be called from compiled code, ``virtual.py`` is some fifty times faster.
"""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.model.compiled import compiled
from hbench.model.noise import new_noise
from hbench.model.parameters import plant_parameters
from hbench.model.plant import TICK_S, WORK_SHAPE, V, initial_state, step
from hbench.model.scatter import new_levels, update_levels
from hbench.model.sensors import N_CHANNELS, convert, sensed, sensor_parameters

VOLTS_PER_CODE = 10.0 / 2048  # AD5724R, 12 bit, +-10 V
_POLL_TICKS = 10  # the board's idle loop comes round about once a millisecond
_START_PRESSURE_PA = 15e5  # of both load chambers at power-on


class SteppedBoard(Protocol):
    """The firmware somewhere, e.g. ``HostFirmware`` or ``EmulatedFirmware``."""

    def receive(self, data: bytes) -> int:
        """Send octets to the board; returns how many found room."""

    def transmit(self) -> bytes:
        """Take the octets that wait for the host."""

    def poll(self) -> int:
        """Run the idle loop once; returns the number of octets that wait for the host."""

    def tick(self, adc: Sequence[int]) -> tuple[int, int, int]:
        """Run one control tick: converter words (7, in 1/16 count) to DAC codes (3)."""

    def close(self) -> None:
        """Switch the board off."""


@compiled
def _next_words(first, state, levels, noise, par, sensors, buffers):
    """Move the bench on by one tick, but for the ``first``, and convert what the sensors see."""
    values, words, u, work = buffers
    if not first:
        step(state, u, levels, par, TICK_S, work)
        update_levels(levels, state[V], noise, par)
    sensed(state, levels, par, values)
    convert(values, sensors, noise, words)


class SteppedRig:
    """A board and its simulated bench, as a ``Port``; simulated time passes in ``read`` alone.

    ``plant`` stands in for the bench's own physics where it is given.
    """

    def __init__(
        self, name: str, board: SteppedBoard, bench: Bench, plant: Plant | None = None, seed=1
    ):
        plant = plant or bench
        self.name = name
        self._board = board
        self._par = plant_parameters(plant)
        self._sensors = sensor_parameters(plant.sensors)
        self._noise = new_noise(seed)
        self._levels = new_levels(self._noise, self._par)
        self._state = initial_state(
            self._par, 0.5 * plant.test_cylinder.stroke, _START_PRESSURE_PA, _START_PRESSURE_PA
        )
        self._words = np.zeros(N_CHANNELS, np.uint16)
        self._u = np.zeros(3)
        self._buffers = np.zeros(N_CHANNELS), self._words, self._u, np.zeros(WORK_SHAPE)
        self._tick = 0

    def write(self, data: bytes) -> None:
        """Send octets to the board."""
        self._board.receive(data)

    def read(self, timeout_s: float) -> bytes:
        """Let simulated time pass until the board says something or the timeout is over."""
        last = self._tick + max(1, round(timeout_s / TICK_S))
        while self._tick < last:
            self._run_tick()
            if self._tick % _POLL_TICKS == 0 and self._board.poll() > 0:
                break
        return self._board.transmit()

    def now(self) -> float:
        """Simulated seconds since power-on."""
        return self._tick * TICK_S

    def close(self) -> None:
        """Switch the board off."""
        self._board.close()

    def _run_tick(self) -> None:
        _next_words(
            self._tick == 0,
            self._state,
            self._levels,
            self._noise,
            self._par,
            self._sensors,
            self._buffers,
        )
        codes = self._board.tick(self._words.tolist())
        for valve, code in enumerate(codes):
            self._u[valve] = code * VOLTS_PER_CODE
        self._tick += 1
