"""Quantities that the sensors measure, and their conversion to ADC counts."""

import numpy as np

from hbench.model.compiled import inlined
from hbench.model.effects.applied import position_reading
from hbench.model.noise import normal
from hbench.model.parameters import PlantParameters
from hbench.model.plant import P_LP, P_LR, P_S, P_TP, P_TR, MassForces
from hbench.model.sensors import FRACTION, N_CHANNELS, SensorParameters


@inlined
def sensed(
    state: np.ndarray, on_masses: MassForces, par: PlantParameters, values: np.ndarray
) -> None:
    """Write the sensed quantities at this moment into ``values``, SI, in ``SENSORS`` order.

    The last one is the acceleration of the moving masses.
    """
    values[0] = position_reading(state, par, par.effects)
    values[1] = state[P_TP]
    values[2] = state[P_TR]
    values[3] = state[P_LP]
    values[4] = state[P_LR]
    values[5] = state[P_S]
    values[6] = on_masses.applied
    values[7] = on_masses.acceleration


@inlined
def convert(
    values: np.ndarray,
    temp_k: float,
    sensors: SensorParameters,
    noise: np.ndarray,
    words: np.ndarray,
) -> None:
    """Write one tick's means of ``values`` (SI) into ``words``, uint16 in 1/16 count.

    ``temp_k`` is the oil's temperature. The auxiliary word stays 0 without a sensor. The converter
    clips at 0 and at its top code; a clipped channel has exactly that value.
    """
    for i in range(N_CHANNELS):
        counts = sensors.per_unit[i] * values[i] + sensors.zero[i]
        words[i] = np.uint16(_word(counts, sensors, noise))
    if sensors.aux_per_unit != 0.0:
        auxiliary = values[N_CHANNELS] if sensors.aux_is_acceleration else temp_k
        counts = sensors.aux_per_unit * auxiliary + sensors.aux_zero
        words[N_CHANNELS] = np.uint16(_word(counts, sensors, noise))


@inlined
def _word(counts: float, sensors: SensorParameters, noise: np.ndarray) -> float:
    if sensors.noise > 0.0:
        counts += sensors.noise * normal(noise)
    counts = min(max(counts, 0.0), sensors.top)
    return FRACTION / sensors.parts * np.floor(sensors.parts * counts + 0.5)
