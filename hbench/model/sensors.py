"""Sensors: their scaling to ADC counts, and the calibration back (appendices B and C).

Every channel is linear: counts = per_unit * value + zero, with 2^bits counts over the reference
voltage (code = 4096 V / 3 V). A control tick averages several conversions and keeps the mean in
1/16 of a count, as the board does.
"""

from math import sqrt
from typing import NamedTuple

from hbench.config.sensors import Sensors, Transducer

# In the converter's order. The auxiliary input has the oil's temperature or an accelerometer.
SENSORS = ("x", "p_tp", "p_tr", "p_lp", "p_lr", "p_s", "f_applied")
INPUTS = (*SENSORS, "auxiliary")
PRESSURES = SENSORS[1:6]
N_CHANNELS, N_INPUTS = len(SENSORS), len(INPUTS)
N_SENSED = N_CHANNELS + 1  # and the acceleration

FRACTION = 16  # parts of a count that a tick's mean is kept in

# Parameter triples of seven channels make 7-tuples that compiled code can index.
Channels = tuple[float, ...]


class SensorParameters(NamedTuple):
    """All channels as plain numbers for compiled code, in the order of ``SENSORS``."""

    per_unit: Channels  # counts per SI unit
    zero: Channels  # counts at 0
    top: float  # largest code
    noise: float  # standard deviation of a tick's mean, in counts
    parts: float  # of a count in a tick's mean: FRACTION, or 1 where nothing dithers the rounding
    # The auxiliary input: counts per K of the oil in the tank, or per m/s^2; 0: there is no sensor.
    aux_per_unit: float = 0.0
    aux_zero: float = 0.0  # counts at 0
    aux_is_acceleration: bool = False


def sensor_parameters(sensors: Sensors) -> SensorParameters:
    """Collect the sensors' parameters for compiled code.

    Noise of at least half a count dithers the converter: its rounding then acts as white noise of
    variance 1/12 count^2, and the mean of n conversions has the variance (sigma^2 + 1/12) / n.
    With less noise than that, this mean is better than a real converter's.
    """
    adc = sensors.adc
    counts_per_volt = 2**adc.bits / adc.reference
    scalings = [_scaling(sensors, name) for name in SENSORS]
    variance = 0.0
    if adc.noisy:
        rounding = 1 / 12 if adc.quantised else 0.0
        variance = (counts_per_volt * adc.noise) ** 2 + rounding
    oil, accelerometer = sensors.temperature, sensors.accelerometer
    auxiliary = accelerometer or oil
    aux_per_unit = aux_zero = 0.0
    if auxiliary is not None:
        aux_per_unit = counts_per_volt * auxiliary.output / auxiliary.span * auxiliary.amplifier
        aux_zero = counts_per_volt * auxiliary.offset
    if oil is not None:
        aux_zero -= aux_per_unit * oil.lowest
    return SensorParameters(
        per_unit=tuple(counts_per_volt * volts_per_unit for volts_per_unit, _ in scalings),
        zero=tuple(counts_per_volt * volts for _, volts in scalings),
        top=float(2**adc.bits - 1),
        noise=sqrt(variance / adc.oversampling),
        parts=1.0 if adc.quantised and not adc.noisy else float(FRACTION),
        aux_per_unit=aux_per_unit,
        aux_zero=aux_zero,
        aux_is_acceleration=accelerometer is not None,
    )


def ideal_sensors() -> SensorParameters:
    """Return sensors that read SI."""
    return SensorParameters((1.0,) * N_CHANNELS, (0.0,) * N_CHANNELS, 0.0, 0.0, 1.0)


def sensor_gains(sensors: Sensors) -> dict[str, tuple[float, float]]:
    """Return the calibration of each channel: value = gain * counts + offset, in SI.

    Counts are whole ADC counts (a log word divided by 16). ``temp_tank`` or ``acceleration``, of
    the auxiliary input, is missing without its sensor.
    """
    par = sensor_parameters(sensors)
    gains = {
        name: (1 / per_unit, -zero / per_unit)
        for name, per_unit, zero in zip(SENSORS, par.per_unit, par.zero, strict=True)
    }
    if par.aux_per_unit:
        name = "acceleration" if par.aux_is_acceleration else "temp_tank"
        gains[name] = (1 / par.aux_per_unit, -par.aux_zero / par.aux_per_unit)
    return gains


def _scaling(sensors: Sensors, name: str) -> tuple[float, float]:
    """Return the volts at the converter's input per SI unit, and at 0."""
    if name == "f_applied":
        return sensors.load_cell.volts_per_newton, float(sensors.load_cell.level)
    sensor: Transducer = sensors.position if name == "x" else sensors.pressure
    return sensor.output / sensor.span * sensor.amplifier, float(sensor.offset)
