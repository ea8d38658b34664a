"""Sensors with their signal path to the converter, and tolerances of the instruments."""

from typing import Annotated, Literal

from pydantic import Field

from hbench.config import quantity as q
from hbench.config.quantity import ConfigSection


class Adc(ConfigSection):
    """Analogue-to-digital converter of all sensors."""

    bits: Literal[12]  # a log word holds 1/16 counts
    reference: q.Voltage
    oversampling: int = Field(ge=1, le=256)  # conversions averaged in one control tick
    noise: q.NoiseVoltage  # standard deviation of one conversion, at the converter's input
    quantised: bool = True
    noisy: bool = True


class Transducer(ConfigSection):
    """Sensor with a 0..output signal over 0..span, through an amplifier (appendix B)."""

    span: float
    output: q.Voltage
    amplifier: q.Number
    offset: q.SignedVoltage = 0.0  # at the converter's input


class PositionSensor(Transducer):
    """The position sensor of the test cylinder."""

    span: q.Length


class PressureSensor(Transducer):
    """One of the five pressure transducers."""

    span: q.Pressure


class LoadCell(ConfigSection):
    """The strain-gauge bar between the cylinders (appendix C, equation C.6)."""

    area: Annotated[float, q.quantity("mm^2", gt=0, le=1)]
    youngs_modulus: Annotated[float, q.quantity("GPa", gt=1e8, le=1e12)]
    poisson: float = Field(ge=0, lt=0.5)
    gauge_factor: q.Number
    bridge_supply: q.Voltage
    amplifier: q.Number
    level: q.Voltage  # output at zero force, at the converter's input

    @property
    def volts_per_newton(self) -> float:
        """Amplified bridge voltage per newton: 2 u_s k (1 + nu) K / (4 A E), equation C.6."""
        bridge = 2 * self.bridge_supply * self.gauge_factor * (1 + self.poisson)
        return bridge * self.amplifier / (4 * self.area * self.youngs_modulus)


class Sensors(ConfigSection):
    """Sensors of the seven measured channels."""

    adc: Adc
    position: PositionSensor
    pressure: PressureSensor
    load_cell: LoadCell

    @property
    def force_range_n(self) -> tuple[float, float]:
        """Range of the load cell within the converter's range [N]."""
        cell = self.load_cell
        per_newton = cell.volts_per_newton
        return -cell.level / per_newton, (self.adc.reference - cell.level) / per_newton


class Instrument(ConfigSection):
    """The stated tolerance of an instrument."""

    tolerance: q.Ratio
    of: Literal["reading", "full_scale"]
    full_scale: float

    @property
    def largest(self) -> float:
        """The tolerance at full scale."""
        return self.tolerance * self.full_scale


class ForceInstrument(Instrument):
    """Tolerance of the load cell."""

    full_scale: q.Force


class PressureInstrument(Instrument):
    """Tolerance of the pressure transducers."""

    full_scale: q.Pressure


class Instruments(ConfigSection):
    """Tolerances for the efficiency's uncertainty (equations 6.16 to 6.19)."""

    force: ForceInstrument
    pressure: PressureInstrument
