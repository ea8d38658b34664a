"""The plant's parameters as plain numbers that compiled code takes: SI, frozen, replaceable.

Vary one with ``par._replace(...)``. Every field is a float unless it says otherwise: another type
would compile everything anew.
"""

from math import pi, sqrt
from typing import NamedTuple

from hbench.config.bench import Cylinder, EndStop, Friction, Plant, Valve
from hbench.model.friction import LAWS


class FrictionParameters(NamedTuple):
    """Friction of one cylinder; see ``friction.py`` for the formulas."""

    law: int  # code in friction.LAWS
    coulomb_n: float
    stiction_n: float
    stribeck_velocity_m_s: float
    stribeck_exponent: float
    viscous_n_s_m: float
    bristle_stiffness_n_m: float  # sigma_0
    bristle_damping_n_s_m: float  # sigma_1
    piston_seal_m2: float  # N per Pa of |P_p - P_r|
    rod_seal_m2: float  # N per Pa of P_r
    scatter: float  # standard deviation of the level from stroke to stroke


class CylinderParameters(NamedTuple):
    """One cylinder. Its piston stands at ``x + offset_m``, between 0 and its stroke."""

    area_piston_m2: float
    area_rod_m2: float
    stroke_m: float
    dead_volume_piston_m3: float
    dead_volume_rod_m3: float
    offset_m: float
    friction: FrictionParameters


class ValveParameters(NamedTuple):
    """The three servo valves, all alike."""

    flow_gain: float  # k_s = K_T sqrt(2/rho), m^3/s per V and sqrt(Pa)
    natural_frequency_rad_s: float
    damping: float
    limit_v: float


class EndStopParameters(NamedTuple):
    """Spring and damper of every cylinder head."""

    stiffness_n_m: float
    damping_n_s_m: float


class PlantParameters(NamedTuple):
    """Everything that the equations of motion need."""

    test: CylinderParameters
    load: CylinderParameters
    mass_test_kg: float
    mass_load_kg: float
    bulk_modulus_pa: float
    p_supply_pa: float
    p_tank_pa: float
    valve: ValveParameters
    end_stop: EndStopParameters
    substeps: int  # of one control tick, as the stiffest friction law needs


def plant_parameters(plant: Plant) -> PlantParameters:
    """Collect the parameters of a plant (or bench) file."""
    laws = (LAWS[plant.friction.test.law], LAWS[plant.friction.load.law])
    return PlantParameters(
        test=_cylinder(plant.test_cylinder, plant.friction.test),
        load=_cylinder(plant.load_cylinder, plant.friction.load),
        mass_test_kg=float(plant.moving_mass.test),
        mass_load_kg=float(plant.moving_mass.load),
        bulk_modulus_pa=float(plant.oil.bulk_modulus),
        p_supply_pa=float(plant.supply.pressure),
        p_tank_pa=float(plant.supply.tank),
        valve=_valve(plant.valve, plant.oil.density),
        end_stop=_end_stop(plant.end_stop),
        substeps=max(law.substeps for law in laws),
    )


def _cylinder(cylinder: Cylinder, friction: Friction) -> CylinderParameters:
    return CylinderParameters(
        area_piston_m2=float(cylinder.area_piston_m2),
        area_rod_m2=float(cylinder.area_rod_m2),
        stroke_m=float(cylinder.stroke),
        dead_volume_piston_m3=float(cylinder.dead_volume_piston),
        dead_volume_rod_m3=float(cylinder.dead_volume_rod),
        offset_m=float(cylinder.offset),
        friction=_friction(friction),
    )


def _friction(friction: Friction) -> FrictionParameters:
    return FrictionParameters(
        law=LAWS[friction.law].code,
        coulomb_n=float(friction.coulomb),
        stiction_n=float(friction.stiction),
        stribeck_velocity_m_s=float(friction.stribeck_velocity),
        stribeck_exponent=float(friction.stribeck_exponent),
        viscous_n_s_m=float(friction.viscous),
        bristle_stiffness_n_m=float(friction.bristle_stiffness),
        bristle_damping_n_s_m=float(friction.bristle_damping),
        piston_seal_m2=float(friction.piston_seal),
        rod_seal_m2=float(friction.rod_seal),
        scatter=float(friction.scatter),
    )


def _valve(valve: Valve, density: float) -> ValveParameters:
    return ValveParameters(
        flow_gain=float(valve.gain) * sqrt(2 / density),
        natural_frequency_rad_s=2 * pi * float(valve.bandwidth),
        damping=float(valve.damping),
        limit_v=float(valve.limit),
    )


def _end_stop(end_stop: EndStop) -> EndStopParameters:
    return EndStopParameters(float(end_stop.stiffness), float(end_stop.damping))
