"""Way of the piston after the valves close, which ``limits.stopping_time`` bounds."""

from math import acos, exp, pi, sqrt

from hbench.config.bench import Limits
from hbench.model.cylinders import extending_volumes, retracting_volumes
from hbench.model.friction.laws import viscous_coefficient
from hbench.model.parameters import PlantParameters


def stopping_time_s(par: PlantParameters, limits: Limits) -> float:
    """Return the way of the piston over its speed v [s], in the middle of the travel.

    While the spools close, the oil flows on for 2 zeta_v / w_v, the integral of their step
    response. The closed chambers are a spring k = beta sum(A^2 / V) for both masses m, and the
    pressures go on to balance the load, dry friction and B v:

        m x'' = -B (x' - v) - k x,  x(0) = 0,  x'(0) = v

    With w = sqrt(k / m) and zeta = B / (2 m w), the largest x is v / w times 2 zeta, and if
    zeta < 1 additionally exp(-zeta (pi - acos zeta) / sqrt(1 - zeta^2)), the overshoot.
    """
    x_m = 0.5 * (limits.travel_min + limits.travel_max)
    volumes = (*extending_volumes(x_m, par.test), *retracting_volumes(x_m, par.load))
    areas = (
        *(par.test.area_piston_m2, par.test.area_rod_m2),
        *(par.load.area_piston_m2, par.load.area_rod_m2),
    )
    stiffness = par.bulk_modulus_pa * sum(a**2 / v for a, v in zip(areas, volumes, strict=True))
    mass_kg = par.mass_test_kg + par.mass_load_kg
    v_m_s = limits.speed_max
    viscous = max(
        sum(viscous_coefficient(v_m_s, side.friction) for side in (par.test, par.load)), 0
    )
    omega = sqrt(stiffness / mass_kg)
    zeta = viscous / (2 * mass_kg * omega)
    overshoot = exp(-zeta * (pi - acos(zeta)) / sqrt(1 - zeta**2)) if zeta < 1 else 0.0
    closing_s = 2 * par.valve.damping / par.valve.natural_frequency_rad_s
    return closing_s + (2 * zeta + overshoot) / omega
