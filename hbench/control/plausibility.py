"""Values of a bench or plant file that no bench has, or that contradict each other.

The limits of single values are in ``config/bench.py``. What is found here may be right on a bench
that nobody thought of, so it is reported and refused nowhere.
"""

from collections.abc import Iterator
from math import pi, sqrt

from hbench.config.bench import Bench, Cylinder, Plant
from hbench.control.stopping import stopping_time_s
from hbench.model.build import plant_parameters

_STEEL_KG_M3 = 7850.0
_OF_STEEL_ROD = 0.1  # lightest rod over a solid one of steel: a tube of light alloy
_FASTEST_M_S = 20.0  # of a piston: high-speed tensile testing machines


def implausible(plant: Plant) -> tuple[str, ...]:
    """Return what is implausible in a bench or plant file, each with key, value and limit.

    Raises ``ConfigError`` for effects that are not in the catalogue.
    """
    return tuple(_found(plant))


def _found(plant: Plant) -> Iterator[str]:
    for side, cylinder in (("test", plant.test_cylinder), ("load", plant.load_cylinder)):
        mass_kg, least_kg = getattr(plant.moving_mass, side), _lightest_kg(cylinder)
        if mass_kg < least_kg:
            yield (
                f"moving_mass.{side} = {mass_kg:.3g} kg; a rod of {side}_cylinder's rod_diameter "
                f"and stroke has at least {least_kg:.2g} kg ({100 * _OF_STEEL_ROD:.0f} % of solid "
                "steel)"
            )
        friction = getattr(plant.friction, side)
        static_n, coulomb_n = getattr(friction, "stiction", 0.0), getattr(friction, "coulomb", 0.0)
        if static_n < coulomb_n:
            yield (
                f"friction.{side}.stiction = {static_n:.4g} N; static friction is at least "
                f"coulomb = {coulomb_n:.4g} N"
            )
    supply_pa, beta_pa = plant.supply.pressure, plant.oil.bulk_modulus
    if beta_pa < supply_pa:
        yield (
            f"oil.bulk_modulus = {beta_pa / 1e5:.4g} bar; gas alone has that of its pressure, up "
            f"to supply.pressure = {supply_pa / 1e5:.4g} bar"
        )
    opening_m2 = plant.valve.gain * plant.valve.limit
    v_m_s = opening_m2 * sqrt(supply_pa / plant.oil.density) / plant.test_cylinder.area_piston_m2
    if v_m_s > _FASTEST_M_S:
        yield (
            f"valve.gain = {plant.valve.gain:.3g} m^2/V; with it the open valve moves the test "
            f"piston at {v_m_s:.3g} m/s (half of supply.pressure at the edge), pistons reach "
            f"{_FASTEST_M_S:g} m/s"
        )
    if isinstance(plant, Bench):
        needed_s = stopping_time_s(plant_parameters(plant), plant.limits)
        if plant.limits.stopping_time < needed_s:
            yield (
                f"limits.stopping_time = {1e3 * plant.limits.stopping_time:.3g} ms; by masses, "
                f"oil, viscous friction and valve.bandwidth it is {1e3 * needed_s:.3g} ms: the "
                "piston may pass the end of its travel after a fault"
            )


def _lightest_kg(cylinder: Cylinder) -> float:
    rod_m2 = pi / 4 * cylinder.rod_diameter**2  # 0 if not known, with a rod on both sides
    return _OF_STEEL_ROD * _STEEL_KG_M3 * rod_m2 * cylinder.stroke
