"""Sensors with their signal path to the converter, and tolerances of the instruments."""

from math import sqrt
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from hbench.config import quantity as q
from hbench.config.identity import Calibration
from hbench.config.quantity import ConfigSection


class Adc(ConfigSection):
    """Analogue-to-digital converter of all sensors."""

    bits: Literal[12]  # a log word holds 1/16 counts
    reference: q.Voltage
    oversampling: q.WholeNumber = Field(ge=1, le=256)  # conversions averaged in one control tick
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

    span: q.PositivePressure


class LoadCell(ConfigSection):
    """The strain-gauge bar between the cylinders (appendix C, equation C.6)."""

    area: Annotated[float, q.quantity("mm^2", gt=0, le=1)]
    youngs_modulus: Annotated[float, q.quantity("GPa", gt=1e8, le=1e12)]
    poisson: q.AnyNumber = Field(ge=0, lt=0.5)
    gauge_factor: q.Number
    bridge_supply: q.Voltage
    amplifier: q.Number
    level: q.Voltage  # output at zero force, at the converter's input

    @property
    def volts_per_newton(self) -> float:
        """Amplified bridge voltage per newton: 2 u_s k (1 + nu) K / (4 A E), equation C.6."""
        bridge = 2 * self.bridge_supply * self.gauge_factor * (1 + self.poisson)
        return bridge * self.amplifier / (4 * self.area * self.youngs_modulus)


class TemperatureSensor(Transducer):
    """The sensor of the oil's temperature in the tank: 0..output over ``lowest``..+ span."""

    span: Annotated[float, q.quantity("K", gt=0, le=500)]
    lowest: q.Temperature


class Accelerometer(Transducer):
    """Accelerometer of the moving mass; ``offset`` is its output at rest (appendix B.2)."""

    span: q.Acceleration  # over 0..output


class Sensors(ConfigSection):
    """Sensors of the measured channels."""

    adc: Adc
    position: PositionSensor
    pressure: PressureSensor
    load_cell: LoadCell
    # On the auxiliary input of the board, one of the two:
    temperature: TemperatureSensor | None = None  # None: not measured
    accelerometer: Accelerometer | None = None  # None: the velocity is that of the position alone

    @model_validator(mode="after")
    def _one_auxiliary_input(self) -> "Sensors":
        if self.temperature is not None and self.accelerometer is not None:
            raise ValueError("the board has one input for 'temperature' or 'accelerometer'")
        return self

    @property
    def force_range_n(self) -> tuple[float, float]:
        """Range of the load cell within the converter's range [N]."""
        cell = self.load_cell
        per_newton = cell.volts_per_newton
        return -cell.level / per_newton, (self.adc.reference - cell.level) / per_newton


Distribution = Literal["rectangular", "triangular", "normal", "standard"]
# Standard uncertainty of a stated tolerance: its divisor (JCGM 100, 4.3.3, 4.3.7 and 4.3.9).
DIVISORS: dict[Distribution, float] = {
    "rectangular": sqrt(3),  # limits, such as those of a data sheet
    "triangular": sqrt(6),  # limits that are seldom reached
    "normal": 2.0,  # expanded uncertainty with k = 2, such as that of a certificate
    "standard": 1.0,  # standard uncertainty, as the source reads its tolerances (6.15)
}


class ErrorSource(ConfigSection):
    """One source of an instrument's error, such as its zero or its hysteresis."""

    tolerance: q.Ratio
    of: Literal["reading", "full_scale"] = "full_scale"
    distribution: Distribution = "rectangular"
    dof: q.AnyNumber | None = Field(default=None, ge=1, allow_inf_nan=False)  # None: infinite
    common: bool = False  # one error in all transducers, calibrated against one standard
    source: str = "assumed"  # certificate with number and date, or data sheet


SourceName = Annotated[str, Field(pattern=r"^[^\W_][\w .,()/°%+-]{0,39}$")]  # of a source of error


class Instrument(ErrorSource):
    """The accuracy class of an instrument, and further sources of its error."""

    full_scale: float
    calibration: Calibration = Calibration()
    further: dict[SourceName, ErrorSource] = Field(default={}, max_length=20)

    @property
    def largest(self) -> float:
        """The tolerance at full scale."""
        return self.tolerance * self.full_scale

    def standard_uncertainty(self, source: ErrorSource, reading: float) -> float:
        """Return that of a reading by one source of error; with the sign of the reading."""
        base = reading if source.of == "reading" else self.full_scale
        return source.tolerance * base / DIVISORS[source.distribution]


class ForceInstrument(Instrument):
    """Tolerance of the load cell."""

    full_scale: q.PositiveForce


class PressureInstrument(Instrument):
    """Tolerance of the pressure transducers."""

    full_scale: q.PositivePressure


class Geometry(ConfigSection):
    """Tolerances of the cylinder's dimensions and of the load cell's alignment."""

    bore: q.Tolerance = 0.0  # of the diameter
    rod: q.Tolerance = 0.0  # of the diameter
    alignment: q.Angle = 0.0  # between the load cell and the motion
    distribution: Distribution = "rectangular"
    source: str = "assumed"


class Instruments(ConfigSection):
    """Tolerances of the instruments, for the uncertainty of friction and efficiency."""

    force: ForceInstrument
    pressure: PressureInstrument
    geometry: Geometry = Geometry()
    expansion: Literal["t_95", "k_2"] = "t_95"  # of the combined uncertainty: Student's factor, 2

    @property
    def as_printed(self) -> "Instruments":
        """The source's own reading: tolerances are standard uncertainties, nothing else counts."""
        printed: dict[str, Any] = {
            "distribution": "standard",
            "dof": None,
            "common": False,
            "further": {},
        }
        return self.model_copy(
            update={
                "force": self.force.model_copy(update=printed),
                "pressure": self.pressure.model_copy(update=printed),
                "geometry": Geometry(),
            }
        )
