"""Static friction laws: friction as a function of velocity and pressure alone.

    Tustin              3.2, 3.13    F = sign(v) F_dry(v) + B v
    Marton and Lantos   3.3 to 3.6   two straight lines in either direction
    pressure-based      3.7          sign(v) (k1 exp(k2 |v|) + k3 |P_p - P_r| + k4 P_r) + k5 v

The dry part of the Stribeck curve, which LuGre and Leuven share, has the exponent delta of
equation 3.9 and two seal terms after 3.7, which make it depend on load and direction:

    F_seal  = k_piston |P_p - P_r| + k_rod P_r
    F_dry   = level (F_C + F_seal + (F_stiction - F_C) exp(-(|v|/v_s)^delta))

``level`` is the scatter from stroke to stroke (see ``model/scatter.py``); 1 is nominal. Friction is
positive where it opposes extension. At rest a static law is regularised: sign(v) becomes
tanh(v / 1 mm/s), which makes rest stiff (an eigenvalue of -6e4 1/s on the reference bench).
"""

from math import copysign, exp, tanh

from hbench.model.compiled import compiled
from hbench.model.parameters import FrictionParameters

REST_VELOCITY_M_S = 1e-3  # width of the regularised sign


@compiled
def dry_friction(v: float, p_p: float, p_r: float, level: float, par: FrictionParameters) -> float:
    """Magnitude F_dry [N] of the Stribeck curve's dry part at v [m/s], pressures in Pa."""
    ratio = abs(v) / par.stribeck_velocity
    if par.stribeck_exponent != 1.0:
        ratio = ratio**par.stribeck_exponent
    seal = par.piston_seal * abs(p_p - p_r) + par.rod_seal * p_r
    return level * (par.coulomb + seal + (par.stiction - par.coulomb) * exp(-ratio))


@compiled
def tustin(
    v: float, p_p: float, p_r: float, level: float, par: FrictionParameters
) -> tuple[float, float]:
    """Dry part of the Tustin law with its sign, and its viscous part [N]."""
    return copysign(dry_friction(v, p_p, p_r, level, par), v), par.viscous * v


@compiled
def marton_lantos(v: float, level: float, par: FrictionParameters) -> tuple[float, float]:
    """Return the low line up to the switch velocity, above it the high one (3.3), and 0.

    Below v_SW = (a_1 - a_2) / (b_2 - b_1) (3.6) the falling lower line is the larger of the two
    where friction has a Stribeck minimum, so the larger one holds everywhere.
    """
    speed = abs(v)
    if v >= 0.0:
        low = par.extend_low_force + par.extend_low_slope * speed
        high = par.extend_high_force + par.extend_high_slope * speed
    else:
        low = par.retract_low_force + par.retract_low_slope * speed
        high = par.retract_high_force + par.retract_high_slope * speed
    return copysign(level * max(low, high), v), 0.0


@compiled
def pressure_based(
    v: float, p_p: float, p_r: float, level: float, par: FrictionParameters
) -> tuple[float, float]:
    """Equation 3.7 extended to both signs of velocity, so that it always dissipates."""
    seal = par.piston_seal * abs(p_p - p_r) + par.rod_seal * p_r
    dry = par.stribeck_force * exp(par.stribeck_rate * abs(v)) + seal
    return copysign(level * dry, v), par.viscous * v


@compiled
def regularised_sign(v: float) -> float:
    """|tanh(v / 1 mm/s)|: what a static law's dry part is multiplied with."""
    return abs(tanh(v / REST_VELOCITY_M_S))
