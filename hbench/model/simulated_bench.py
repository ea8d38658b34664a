"""The bench as its board sees it: converter words out, DAC codes in.

A tick of it is ``sensed`` and ``convert``, then the board's control step, then ``step`` and
``update_levels``. Compiled loops of ticks write these out: functions around them would cost a sixth
of the speed.
"""

from typing import NamedTuple

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.model.build import plant_parameters
from hbench.model.effects.catalogue import changed_by, read_effects
from hbench.model.noise import new_noise
from hbench.model.parameters import PlantParameters
from hbench.model.plant import initial_state, new_work
from hbench.model.scatter import new_levels
from hbench.model.sensors import N_INPUTS, N_SENSED, SensorParameters, sensor_parameters

VOLTS_PER_CODE = 10.0 / 2048  # AD5724R, 12 bit, +-10 V
_START_PRESSURE_PA = 15e5  # of both load chambers at power-on


class SimulatedBench(NamedTuple):
    """State and parameters of a tick, unpacked in compiled code; the arrays change in place."""

    words: np.ndarray  # (8,) uint16, from the converter to the board
    codes: np.ndarray  # (3,) int16, from the board to the DAC
    state: np.ndarray  # as named in plant.py
    levels: np.ndarray
    noise: np.ndarray
    par: PlantParameters
    sensors: SensorParameters
    values: np.ndarray  # this and the fields below are scratch
    u: np.ndarray
    work: np.ndarray


def new_simulated_bench(bench: Bench, plant: Plant | None, seed: int) -> SimulatedBench:
    """Return the bench at rest in the middle of its stroke.

    ``plant`` replaces the bench's own physics where it is given.
    """
    plant = plant or bench
    own = plant.sensors or bench.sensors
    par, noise = plant_parameters(plant), new_noise(seed)
    middle_m = 0.5 * plant.test_cylinder.stroke
    return SimulatedBench(
        words=np.zeros(N_INPUTS, np.uint16),
        codes=np.zeros(3, np.int16),
        state=initial_state(par, middle_m, _START_PRESSURE_PA, _START_PRESSURE_PA),
        levels=new_levels(noise, par),
        noise=noise,
        par=par,
        sensors=changed_by("sensors", sensor_parameters(own), read_effects(plant.effects)),
        values=np.zeros(N_SENSED),
        u=np.zeros(3),
        work=new_work(par),
    )


def as_run(bench: Bench, plant: Plant | None) -> Bench:
    """Return the bench as the simulated board runs it: effects on the board change its settings.

    The campaign keeps the bench file as it is.
    """
    values = read_effects((plant or bench).effects)
    controllers = changed_by("board", bench.controllers, values)
    return bench.model_copy(update={"controllers": controllers})
