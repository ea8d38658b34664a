"""Sensors: from the plant to ADC counts, and the calibration back (appendices B and C).

Every channel is linear: counts = per_unit * value + zero, with 2^bits counts over the reference
voltage (code = 4096 V / 3 V). A control tick averages several conversions and keeps the mean in
1/16 of a count, as the board does.
"""

from math import sqrt
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hbench.config.sensors import Sensors, Transducer
from hbench.model.compiled import compiled
from hbench.model.noise import normal
from hbench.model.plant import P_LP, P_LR, P_S, P_TP, P_TR, X, load_cell_force

if TYPE_CHECKING:
    from hbench.model.parameters import PlantParameters

# In the converter's order.
CHANNELS = ("x", "p_tp", "p_tr", "p_lp", "p_lr", "p_s", "f_applied")
N_CHANNELS = len(CHANNELS)

FRACTION = 16  # parts of a count that a tick's mean is kept in

# Parameter triples of seven channels make 7-tuples that compiled code can index.
Channels = tuple[float, ...]


class SensorParameters(NamedTuple):
    """All channels as plain numbers for compiled code, in ``CHANNELS`` order."""

    per_unit: Channels  # counts per SI unit
    zero: Channels  # counts at 0
    top: float  # largest code
    noise: float  # standard deviation of a tick's mean, in counts
    whole: bool  # a tick's mean is a whole count: quantised, with nothing that dithers


def sensor_parameters(sensors: Sensors) -> SensorParameters:
    """Collect the sensors' parameters for compiled code.

    Noise of at least half a count dithers the converter: its rounding then acts as white noise of
    variance 1/12 count^2, and the mean of n conversions has the variance (sigma^2 + 1/12) / n.
    With less noise than that, this mean is better than a real converter's.
    """
    adc = sensors.adc
    counts_per_volt = 2**adc.bits / adc.reference
    scalings = [_scaling(sensors, name) for name in CHANNELS]
    variance = 0.0
    if adc.noisy:
        rounding = 1 / 12 if adc.quantised else 0.0
        variance = (counts_per_volt * adc.noise) ** 2 + rounding
    return SensorParameters(
        per_unit=tuple(counts_per_volt * volts_per_unit for volts_per_unit, _ in scalings),
        zero=tuple(counts_per_volt * volts for _, volts in scalings),
        top=float(2**adc.bits - 1),
        noise=sqrt(variance / adc.oversampling),
        whole=adc.quantised and not adc.noisy,
    )


def sensor_gains(sensors: Sensors) -> dict[str, tuple[float, float]]:
    """Return the calibration of each channel: value = gain * counts + offset, in SI.

    Counts are whole ADC counts (a log word divided by 16).
    """
    par = sensor_parameters(sensors)
    return {
        name: (1 / per_unit, -zero / per_unit)
        for name, per_unit, zero in zip(CHANNELS, par.per_unit, par.zero, strict=True)
    }


def _scaling(sensors: Sensors, name: str) -> tuple[float, float]:
    """Volts at the converter's input per SI unit, and at 0."""
    if name == "f_applied":
        return sensors.load_cell.volts_per_newton, float(sensors.load_cell.level)
    sensor: Transducer = sensors.position if name == "x" else sensors.pressure
    return sensor.output / sensor.span * sensor.amplifier, float(sensor.offset)


@compiled
def sensed(
    state: np.ndarray,
    levels: np.ndarray,
    par: "PlantParameters",
    values: np.ndarray,
    work: np.ndarray,
) -> None:
    """Write what the sensors see at this moment into ``values``, SI, in ``CHANNELS`` order.

    ``work`` is scratch of the plant's ``new_work``.
    """
    values[0] = state[X]
    values[1] = state[P_TP]
    values[2] = state[P_TR]
    values[3] = state[P_LP]
    values[4] = state[P_LR]
    values[5] = state[P_S]
    values[6] = load_cell_force(state, levels, par, work)


@compiled
def convert(
    values: np.ndarray, sensors: SensorParameters, noise: np.ndarray, words: np.ndarray
) -> None:
    """Write one tick's means of ``values`` (SI) into ``words``, uint16 in 1/16 count.

    The converter clips at 0 and its top code; a clipped channel stands at exactly that.
    """
    for i in range(N_CHANNELS):
        counts = sensors.per_unit[i] * values[i] + sensors.zero[i]
        if sensors.noise > 0.0:
            counts += sensors.noise * normal(noise)
        if sensors.whole:
            counts = np.floor(counts + 0.5)
        counts = min(max(counts, 0.0), sensors.top)
        words[i] = np.uint16(np.floor(FRACTION * counts + 0.5))
