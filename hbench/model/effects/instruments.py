"""Effects that change parameters of the sensors or of the board, not the plant's equations."""

from typing import TYPE_CHECKING

from hbench.config.bench import Controllers
from hbench.model.effects.couplings import Coefficients

if TYPE_CHECKING:
    from hbench.model.sensors import SensorParameters

_FORCE = 6  # of sensors.SENSORS
_PRESSURES = slice(1, 6)


def load_cell_gain(sensors: "SensorParameters", c: Coefficients) -> "SensorParameters":
    """The load cell shows (1 + e) F. c: e [1]."""
    gains = list(sensors.per_unit)
    gains[_FORCE] *= 1.0 + c[0]
    return sensors._replace(per_unit=tuple(gains))


def load_cell_offset(sensors: "SensorParameters", c: Coefficients) -> "SensorParameters":
    """The load cell shows F + F_0. c: F_0 [N]."""
    zeros = list(sensors.zero)
    zeros[_FORCE] += c[0] * sensors.per_unit[_FORCE]
    return sensors._replace(zero=tuple(zeros))


def pressure_offset(sensors: "SensorParameters", c: Coefficients) -> "SensorParameters":
    """Each transducer shows P + p_0. c: p_0 [Pa] of Tp, Tr, Lp, Lr and the supply."""
    zeros = list(sensors.zero)
    shifts = [p_0 * gain for p_0, gain in zip(c, sensors.per_unit[_PRESSURES], strict=True)]
    zeros[_PRESSURES] = [zero + s for zero, s in zip(zeros[_PRESSURES], shifts, strict=True)]
    return sensors._replace(zero=tuple(zeros))


def pressure_gain(sensors: "SensorParameters", c: Coefficients) -> "SensorParameters":
    """Each transducer shows (1 + e) P. c: e [1] of Tp, Tr, Lp, Lr and the supply."""
    gains = list(sensors.per_unit)
    gains[_PRESSURES] = [gain * (1.0 + e) for gain, e in zip(gains[_PRESSURES], c, strict=True)]
    return sensors._replace(per_unit=tuple(gains))


def slower_filter(controllers: Controllers, c: Coefficients) -> Controllers:
    """Return the board's controllers with a velocity filter (D.11) slower by c [s].

    The logged velocity then lags the logged position by more than the bench file specifies. A lag
    of the position sensor would delay both alike.
    """
    return controllers.model_copy(update={"velocity_filter": controllers.velocity_filter + c[0]})
