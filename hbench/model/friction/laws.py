"""Friction of one cylinder by its own law: all choices between laws.

Static laws are in ``static_laws.py``, those with a state in ``dynamic_laws.py``; the table of laws
is ``records/friction_laws.py``.
"""

from typing import NamedTuple

import numpy as np

from hbench.model.compiled import inlined
from hbench.model.friction.dynamic_laws import (
    leuven,
    leuven_step,
    lugre,
    lugre_step,
    slip_deflection,
    slipping,
)
from hbench.model.friction.static_laws import (
    marton_lantos,
    pressure_based,
    regularised_sign,
    tustin,
)
from hbench.model.parameters import FrictionParameters
from hbench.records.friction_laws import FRICTION_LAWS


class CompiledLaw(NamedTuple):
    """Friction law in compiled code: its number, and its integration steps in a control tick."""

    code: int
    substeps: int


# At rest a static law chatters with steps above 12.5 us.
LAWS: dict[str, CompiledLaw] = {
    name: CompiledLaw(code, substeps=1 if law.dynamic else 8)
    for code, (name, law) in enumerate(FRICTION_LAWS.items())
}
_DYNAMIC = frozenset(LAWS[name].code for name, law in FRICTION_LAWS.items() if law.dynamic)
_LUGRE, _LEUVEN = LAWS["lugre"].code, LAWS["leuven"].code
_MARTON_LANTOS, _PRESSURE_BASED = LAWS["marton_lantos"].code, LAWS["pressure_based"].code


def is_dynamic(par: FrictionParameters) -> bool:
    """Return whether the law has states of its own."""
    return par.law in _DYNAMIC


@inlined
def steady_parts(
    v: float, p_p: float, p_r: float, level: float, par: FrictionParameters
) -> tuple[float, float]:
    """Return the dry part, signed like v, and the viscous part [N] of the steady friction.

    Leuven's dry part is limited to the force that its elements carry together.
    """
    if par.law == _MARTON_LANTOS:
        return marton_lantos(v, level, par)
    if par.law == _PRESSURE_BASED:
        return pressure_based(v, p_p, p_r, level, par)
    return tustin(v, p_p, p_r, level, par)


@inlined
def steady_friction(v: float, p_p: float, p_r: float, par: FrictionParameters) -> float:
    """Return friction [N] at constant velocity, with a sharp sign (3.13 with its parenthesis).

    The nominal level, for every law. At v = 0 it is the static friction against extension.
    """
    dry, viscous = steady_parts(v, p_p, p_r, 1.0, par)
    return dry + viscous


@inlined
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

    The law's states are at ``first`` and every second index after it in ``state`` (see
    ``model/plant.py``), their rates at the same indices: LuGre's z, Leuven's deflections, or one
    state that stays (static laws).
    """
    if par.law == _LUGRE:
        force, rates[first] = lugre(v, state[first], p_p, p_r, level, par)
        return force
    if par.law == _LEUVEN:
        force, z_rate = leuven(v, state, first, p_p, p_r, level, par)
        for i in range(len(par.elements)):
            index = first + 2 * i
            slips = slipping(state[index], z_rate, slip_deflection(i, par))
            rates[index] = 0.0 if slips else z_rate
        return force
    rates[first] = 0.0
    dry, viscous = steady_parts(v, p_p, p_r, level, par)
    return regularised_sign(v) * dry + viscous


@inlined
def hold_slipped(state: np.ndarray, first: int, par: FrictionParameters) -> None:
    """Put Leuven's deflections back to their limits, which a step of finite length overshoots."""
    if par.law == _LEUVEN:
        for i in range(len(par.elements)):
            limit, index = slip_deflection(i, par), first + 2 * i
            state[index] = min(max(state[index], -limit), limit)


@inlined
def midpoint_step(
    v: float,
    state: np.ndarray,
    p_p: float,
    p_r: float,
    level: float,
    h: float,
    par: FrictionParameters,
    work: np.ndarray,
) -> float:
    """Advance the law's states by ``h`` [s] at constant v; return the friction [N] in the middle.

    Explicit midpoint rule. ``state`` holds the law's states alone; ``work`` is two rows like it.
    """
    middle, rates = work[0], work[1]
    friction(v, state, 0, p_p, p_r, level, par, rates)
    for i in range(len(state)):
        middle[i] = state[i] + 0.5 * h * rates[i]
    force = friction(v, middle, 0, p_p, p_r, level, par, rates)
    for i in range(len(state)):
        state[i] += h * rates[i]
    hold_slipped(state, 0, par)
    return force


@inlined
def exact_step(
    v: float,
    state: np.ndarray,
    p_p: float,
    p_r: float,
    level: float,
    h: float,
    par: FrictionParameters,
    work: np.ndarray,
) -> float:
    """Advance as ``midpoint_step`` does, but LuGre's and Leuven's states by their exact solution.

    Leuven's has one for n = 1.
    """
    if par.law == _LUGRE:
        return lugre_step(v, state, p_p, p_r, level, h, par)
    if par.law == _LEUVEN and par.shape == 1.0:
        return leuven_step(v, state, p_p, p_r, level, h, par)
    return midpoint_step(v, state, p_p, p_r, level, h, par, work)


def viscous_coefficient(v: float, par: FrictionParameters) -> float:
    """Return B [N s/m], the viscous part's slope; of Marton and Lantos, that at high speed."""
    if par.law == _MARTON_LANTOS:
        return par.extend_high_slope if v > 0 else par.retract_high_slope
    return par.viscous


def settled_deflection(v: float, p_p: float, p_r: float, par: FrictionParameters) -> float | None:
    """Return LuGre's z [m] at constant velocity, F_dry / sigma_0; None without this state."""
    if par.law != _LUGRE:
        return None
    dry, _ = steady_parts(v, p_p, p_r, 1.0, par)
    return dry / par.bristle_stiffness


@inlined
def deflection_under(force: float, v: float, par: FrictionParameters) -> float:
    """Return LuGre's z [m] that carries a friction force, (F - B v) / sigma_0; 0 for other laws."""
    if par.law != _LUGRE:
        return 0.0
    return (force - par.viscous * v) / par.bristle_stiffness
