"""Dynamic friction laws, whose state is the deflection of asperities.

    LuGre (3.8 to 3.12)             F = sigma_0 z + sigma_1 dz/dt + B v
                                    dz/dt = v - |v| z sigma_0 / F_dry(v)
    modified Leuven (3.14 to 3.20)  F = F_h + sigma_1 dz/dt + B v,  F_h = sum_i theta_i y_i
                                    dz/dt = v (1 - sign(r) |r|^n),  r = F_h / (sign(v) F_dry(v))

Leuven's hysteresis force is that of N Maxwell-slip elements in parallel, each a spring that slips
at its Coulomb force theta_i and deflection Delta_i = (i/N) Delta_max (the erratum after 3.19):
y_i = delta_i / Delta_i, held at +-1 while it slips. As differential equations, with the elements
driven by z: d(delta_i)/dt = dz/dt while |delta_i| < Delta_i or it is unloaded, else 0.
With one element that never slips and n = 1, Leuven is LuGre with sigma_0 = theta_1 / Delta_1.
"""

import numpy as np

from hbench.model.compiled import inlined
from hbench.model.friction.static_laws import dry_friction
from hbench.model.parameters import FrictionParameters


@inlined
def lugre(
    v: float, z: float, p_p: float, p_r: float, level: float, par: FrictionParameters
) -> tuple[float, float]:
    """Return friction [N] and dz/dt [m/s]. At constant velocity it is the Tustin law."""
    dry = dry_friction(v, p_p, p_r, level, par)
    z_rate = v - abs(v) * z * par.bristle_stiffness / dry
    # The rate last: it takes longest.
    force = par.bristle_stiffness * z + par.viscous * v + par.bristle_damping * z_rate
    return force, z_rate


@inlined
def lugre_step(
    v: float,
    state: np.ndarray,
    p_p: float,
    p_r: float,
    level: float,
    h: float,
    par: FrictionParameters,
) -> float:
    """Advance z by ``h`` [s] at constant v; return the mean friction [N] over the step.

    By the equation's exact solution, so that stiff bristles need no shorter steps:
    z -> z_ss + (z - z_ss) exp(-sigma_0 |v| h / F_dry), z_ss = sign(v) F_dry / sigma_0
    """
    dry = dry_friction(v, p_p, p_r, level, par)
    z, steady = state[0], np.sign(v) * dry / par.bristle_stiffness
    state[0] = steady + (z - steady) * np.exp(-par.bristle_stiffness * abs(v) * h / dry)
    elastic = par.bristle_stiffness * 0.5 * (z + state[0])
    return elastic + par.bristle_damping * (state[0] - z) / h + par.viscous * v


@inlined
def slip_deflection(i: int, par: FrictionParameters) -> float:
    """Delta_i [m] of element i = 0..N-1."""
    return par.presliding * (i + 1) / len(par.elements)


@inlined
def hysteresis_force(state: np.ndarray, first: int, par: FrictionParameters) -> float:
    """F_h [N] (3.20) of the deflections [m]: every second one of ``state`` from ``first`` on."""
    force = 0.0
    for i in range(len(par.elements)):
        y = state[first + 2 * i] / slip_deflection(i, par)
        force += par.elements[i] * min(max(y, -1.0), 1.0)
    return force


@inlined
def leuven(
    v: float,
    state: np.ndarray,
    first: int,
    p_p: float,
    p_r: float,
    level: float,
    par: FrictionParameters,
) -> tuple[float, float]:
    """Return friction [N] and dz/dt [m/s] (3.14, 3.15)."""
    force = hysteresis_force(state, first, par)
    ratio = force / dry_friction(v, p_p, p_r, level, par)
    if v < 0.0:
        ratio = -ratio
    shaped = ratio
    if par.shape != 1.0:
        shaped = abs(ratio) ** par.shape
        if ratio < 0.0:
            shaped = -shaped
    z_rate = v * (1.0 - shaped)
    return force + par.bristle_damping * z_rate + par.viscous * v, z_rate


@inlined
def slipping(deflection: float, z_rate: float, limit: float) -> bool:
    """Return whether an element slips: it is at its limit and driven further."""
    return abs(deflection) >= limit and z_rate * deflection > 0.0


@inlined
def leuven_step(
    v: float,
    state: np.ndarray,
    p_p: float,
    p_r: float,
    level: float,
    h: float,
    par: FrictionParameters,
) -> float:
    """Advance the deflections by ``h`` [s] at constant v, n = 1; return the mean friction [N].

    By the exact solution, so that a short Delta_max needs no shorter steps. While the same elements
    stick, with the stiffness K = sum theta_i / Delta_i, and s = sign(v):
    F_h -> s F_dry + (F_h - s F_dry) exp(-K |v| t / F_dry), z -> z + change of F_h / K
    up to the time when the next of them slips; F_h is averaged by its values at the ends.
    """
    steady = np.sign(v) * dry_friction(v, p_p, p_r, level, par)
    left, force, work = h, hysteresis_force(state, 0, par), 0.0
    while left > 0.0:
        direction = v * (1.0 - force / steady) if v != 0.0 else 0.0
        stiffness, room = 0.0, np.inf
        for i in range(len(par.elements)):
            limit = slip_deflection(i, par)
            if not slipping(state[2 * i], direction, limit):
                stiffness += par.elements[i] / limit
                room = min(room, limit - np.sign(direction) * state[2 * i])
        if direction == 0.0 or stiffness == 0.0:
            return (work + (force + par.bristle_damping * direction) * left) / h + par.viscous * v
        change, rate = np.sign(direction) * room, stiffness * v / steady
        part, after = left, force + stiffness * change
        if abs(after - force) < abs(steady - force):
            part = np.log((steady - force) / (steady - after)) / rate
        if part >= left:
            part, after = left, steady + (force - steady) * np.exp(-rate * left)
            change = (after - force) / stiffness
        for i in range(len(par.elements)):
            limit = slip_deflection(i, par)
            state[2 * i] = min(max(state[2 * i] + change, -limit), limit)
        work += 0.5 * (force + after) * part + par.bristle_damping * change
        left, force = left - part, after
    return work / h + par.viscous * v
