"""Static friction laws compiled: friction as a function of velocity and pressure alone.

``formulas.py`` holds the formulas. The dry part of the Stribeck curve, which Tustin, LuGre and
Leuven share, has the exponent delta of equation 3.9 and two seal terms after 3.7, which make it
depend on load and direction:

    F_dry = level (F_C + F_seal + (F_s - F_C) exp(-(|v|/v_s)^delta))

``level`` is the scatter from stroke to stroke (see ``model/scatter.py``); 1 is nominal. Friction is
positive where it opposes extension. At rest a static law is regularised: sign(v) becomes
tanh(v / 1 mm/s), which makes rest stiff (an eigenvalue of -6e4 1/s on the reference bench).
"""

from math import copysign, tanh

from hbench.model.compiled import inlined
from hbench.model.friction import formulas
from hbench.model.parameters import FrictionParameters

REST_VELOCITY_M_S = 1e-3  # width of the regularised sign

_seal_force = inlined(formulas.seal_force)
_stribeck_curve = inlined(formulas.stribeck_curve)
_pressure_curve = inlined(formulas.pressure_curve)
_two_lines = inlined(formulas.two_lines)


@inlined
def dry_friction(v: float, p_p: float, p_r: float, level: float, par: FrictionParameters) -> float:
    """Return F_dry [N], the Stribeck curve's dry part at v [m/s], pressures in Pa.

    The curve gets v / v_s, by a multiplication: 1 / v_s is computed once, and a division here would
    cost 3 % of the plant's time.
    """
    seal = _seal_force(p_p, p_r, par.piston_seal, par.rod_seal)
    return level * _stribeck_curve(
        abs(v) * (1.0 / par.stribeck_velocity),
        seal,
        par.coulomb,
        par.stiction,
        1.0,
        par.stribeck_exponent,
    )


@inlined
def tustin(
    v: float, p_p: float, p_r: float, level: float, par: FrictionParameters
) -> tuple[float, float]:
    """Return the dry part of the Tustin law with its sign, and its viscous part [N]."""
    return copysign(dry_friction(v, p_p, p_r, level, par), v), par.viscous * v


@inlined
def marton_lantos(v: float, level: float, par: FrictionParameters) -> tuple[float, float]:
    """Return the two lines of the direction of v, with its sign, and 0 as viscous part [N]."""
    if v >= 0.0:
        dry = _two_lines(
            abs(v), par.extend_low_force, par.extend_low_slope,
            par.extend_high_force, par.extend_high_slope,
        )  # fmt: skip
    else:
        dry = _two_lines(
            abs(v), par.retract_low_force, par.retract_low_slope,
            par.retract_high_force, par.retract_high_slope,
        )  # fmt: skip
    return copysign(level * dry, v), 0.0


@inlined
def pressure_based(
    v: float, p_p: float, p_r: float, level: float, par: FrictionParameters
) -> tuple[float, float]:
    """Equation 3.7 extended to both signs of velocity, so that it always dissipates."""
    seal = _seal_force(p_p, p_r, par.piston_seal, par.rod_seal)
    dry = _pressure_curve(abs(v), seal, par.stribeck_force, par.stribeck_rate)
    return copysign(level * dry, v), par.viscous * v


@inlined
def regularised_sign(v: float) -> float:
    """|tanh(v / 1 mm/s)|, the factor on a static law's dry part."""
    return abs(tanh(v / REST_VELOCITY_M_S))
