"""Friction of one cylinder: the Tustin and the LuGre law (source, section 3.2).

Both share the dry part of the steady curve, with the exponent delta of equation 3.9 and two seal
terms after 3.7, which make it depend on load and direction:

    F_seal  = k_piston |P_p - P_r| + k_rod P_r
    F_dry   = level (F_C + F_seal + (F_stiction - F_C) exp(-(|v|/v_s)^delta))
    F_steady = sign(v) F_dry + B v

``level`` is the scatter from stroke to stroke (see ``scatter.py``); 1 is nominal. Friction is
positive where it opposes extension. A law returns the force and the rate of its bristle z.
"""

from math import copysign, exp, tanh
from typing import TYPE_CHECKING, NamedTuple

from hbench.model.compiled import compiled

if TYPE_CHECKING:
    from hbench.model.parameters import FrictionParameters

REST_VELOCITY_M_S = 1e-3  # width of the regularised sign of the Tustin law


@compiled
def dry_friction(
    v: float, p_p: float, p_r: float, level: float, par: "FrictionParameters"
) -> float:
    """Magnitude F_dry [N] of the steady curve's dry part at velocity v [m/s], pressures in Pa."""
    ratio = abs(v) / par.stribeck_velocity_m_s
    if par.stribeck_exponent != 1.0:
        ratio = ratio**par.stribeck_exponent
    seal = par.piston_seal_m2 * abs(p_p - p_r) + par.rod_seal_m2 * p_r
    return level * (par.coulomb_n + seal + (par.stiction_n - par.coulomb_n) * exp(-ratio))


@compiled
def tustin(
    v: float, z: float, p_p: float, p_r: float, level: float, par: "FrictionParameters"
) -> tuple[float, float]:
    """Tustin: F = tanh(v / 1 mm/s) F_dry(v) + B v (equation 3.2). No bristle; z stays.

    The regularised sign makes rest stiff (an eigenvalue of -6e4 1/s on the reference bench).
    """
    dry = dry_friction(v, p_p, p_r, level, par)
    return tanh(v / REST_VELOCITY_M_S) * dry + par.viscous_n_s_m * v, 0.0


@compiled
def lugre(
    v: float, z: float, p_p: float, p_r: float, level: float, par: "FrictionParameters"
) -> tuple[float, float]:
    """LuGre: F = sigma_0 z + sigma_1 dz/dt + B v, dz/dt = v - |v| z sigma_0 / F_dry(v).

    Equations 3.8 to 3.12. At constant velocity it is the Tustin law with a sharp sign.
    """
    dry = dry_friction(v, p_p, p_r, level, par)
    z_rate = v - abs(v) * z * par.bristle_stiffness_n_m / dry
    force = (
        par.bristle_stiffness_n_m * z + par.bristle_damping_n_s_m * z_rate + par.viscous_n_s_m * v
    )
    return force, z_rate


@compiled
def steady_friction(v: float, p_p: float, p_r: float, par: "FrictionParameters") -> float:
    """Friction [N] at constant velocity: sign(v) F_dry + B v (3.13 with its parenthesis).

    The nominal level, for every law. At v = 0 it is the stiction against extension.
    """
    return copysign(dry_friction(v, p_p, p_r, 1.0, par), v) + par.viscous_n_s_m * v


TUSTIN, LUGRE = range(2)


@compiled
def friction(
    v: float, z: float, p_p: float, p_r: float, level: float, par: "FrictionParameters"
) -> tuple[float, float]:
    """Force [N] and bristle rate [m/s] by the cylinder's own law: the table below, compiled."""
    if par.law == TUSTIN:
        return tustin(v, z, p_p, p_r, level, par)
    return lugre(v, z, p_p, p_r, level, par)


class Law(NamedTuple):
    """A friction law: its number in compiled code, and how many steps a control tick needs."""

    code: int
    substeps: int


LAWS: dict[str, Law] = {
    "tustin": Law(TUSTIN, substeps=8),  # at rest it chatters with steps above 12.5 us
    "lugre": Law(LUGRE, substeps=1),
}
