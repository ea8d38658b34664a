"""Friction of one cylinder by its own law: the table of laws, and the one call the plant makes.

Static laws stand in ``static_laws.py``, those with a state in ``dynamic_laws.py``.
"""

from typing import NamedTuple

import numpy as np

from hbench.model.compiled import compiled
from hbench.model.friction.dynamic_laws import leuven, lugre, slip_deflection, slipping
from hbench.model.friction.static_laws import (
    marton_lantos,
    pressure_based,
    regularised_sign,
    tustin,
)
from hbench.model.parameters import FrictionParameters

TUSTIN, LUGRE, LEUVEN, MARTON_LANTOS, PRESSURE_BASED = range(5)


@compiled
def steady_parts(
    v: float, p_p: float, p_r: float, level: float, par: FrictionParameters
) -> tuple[float, float]:
    """Dry part, with the sign of v, and viscous part [N] of friction at constant velocity.

    A Leuven law whose elements together carry less than F_dry ends at what they carry.
    """
    if par.law == MARTON_LANTOS:
        return marton_lantos(v, level, par)
    if par.law == PRESSURE_BASED:
        return pressure_based(v, p_p, p_r, level, par)
    return tustin(v, p_p, p_r, level, par)


@compiled
def steady_friction(v: float, p_p: float, p_r: float, par: FrictionParameters) -> float:
    """Friction [N] at constant velocity, with a sharp sign (3.13 with its parenthesis).

    The nominal level, for every law. At v = 0 it is the stiction against extension.
    """
    dry, viscous = steady_parts(v, p_p, p_r, 1.0, par)
    return dry + viscous


@compiled
def friction(
    v: float,
    state: np.ndarray,
    first: int,
    p_p: float,
    p_r: float,
    level: float,
    par: FrictionParameters,
    rates: np.ndarray,
) -> float:
    """Return the force [N]; write the rates [m/s] of the law's own states into ``rates``.

    The law's states stand in ``state`` at ``first`` and every second place after it (see
    ``model/plant.py``), their rates at the same places: LuGre's z, Leuven's deflections, or one
    state that stays (static laws).
    """
    if par.law == LUGRE:
        force, rates[first] = lugre(v, state[first], p_p, p_r, level, par)
        return force
    if par.law == LEUVEN:
        force, z_rate = leuven(v, state, first, p_p, p_r, level, par)
        for i in range(len(par.elements)):
            place = first + 2 * i
            slips = slipping(state[place], z_rate, slip_deflection(i, par))
            rates[place] = 0.0 if slips else z_rate
        return force
    rates[first] = 0.0
    dry, viscous = steady_parts(v, p_p, p_r, level, par)
    return regularised_sign(v) * dry + viscous


@compiled
def hold_slipped(state: np.ndarray, first: int, par: FrictionParameters) -> None:
    """Put Leuven's deflections back to their limits, which a step of finite length overshoots."""
    if par.law == LEUVEN:
        for i in range(len(par.elements)):
            limit, place = slip_deflection(i, par), first + 2 * i
            state[place] = min(max(state[place], -limit), limit)


class Law(NamedTuple):
    """A friction law: its number in compiled code, and how many steps a control tick needs."""

    code: int
    substeps: int


LAWS: dict[str, Law] = {
    "tustin": Law(TUSTIN, substeps=8),  # at rest it chatters with steps above 12.5 us
    "lugre": Law(LUGRE, substeps=1),
    "leuven": Law(LEUVEN, substeps=1),
    "marton_lantos": Law(MARTON_LANTOS, substeps=8),
    "pressure_based": Law(PRESSURE_BASED, substeps=8),
}
