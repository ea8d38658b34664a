"""The plant's parameters as plain numbers that compiled code takes: SI, frozen, replaceable.

Vary one with ``par._replace(...)``. Every field is a float unless it says otherwise: another type
would compile everything anew.
"""

from math import pi, sqrt
from typing import NamedTuple

from hbench.config.bench import Cylinder, EndStop, Plant, Pump, Supply, Valve
from hbench.config.friction import Friction
from hbench.model.effects import read_effects, with_effects
from hbench.model.friction import LAWS


class FrictionParameters(NamedTuple):
    """Friction of one cylinder, the keys of the bench file in SI; see ``friction.py``.

    What the cylinder's law does not have stays at its default here and is not read.
    """

    law: int  # code in friction.LAWS
    scatter: float = 0.0  # standard deviation of the level from stroke to stroke
    viscous: float = 0.0  # B, N s/m
    piston_seal: float = 0.0  # N per Pa of |P_p - P_r|
    rod_seal: float = 0.0  # N per Pa of P_r
    # Stribeck curve: Tustin, LuGre, Leuven
    coulomb: float = 0.0  # F_C, N
    stiction: float = 0.0  # F_stiction, N
    stribeck_velocity: float = 1.0  # m/s
    stribeck_exponent: float = 1.0  # delta
    # LuGre, Leuven
    bristle_stiffness: float = 0.0  # sigma_0, N/m
    bristle_damping: float = 0.0  # sigma_1, N s/m
    presliding: float = 1.0  # Delta_max, m
    shape: float = 1.0  # n
    elements: tuple[float, ...] = (0.0,)  # theta_i, N; compiled anew for another number
    # Marton and Lantos: intercepts in N, slopes in N s/m
    extend_low_force: float = 0.0
    extend_low_slope: float = 0.0
    extend_high_force: float = 0.0
    extend_high_slope: float = 0.0
    retract_low_force: float = 0.0
    retract_low_slope: float = 0.0
    retract_high_force: float = 0.0
    retract_high_slope: float = 0.0
    # pressure-based
    stribeck_force: float = 0.0  # k1, N
    stribeck_rate: float = 0.0  # k2, s/m


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


class SupplyParameters(NamedTuple):
    """Pressure source and tank; see ``supply.py`` for the formulas."""

    has_pump: bool  # False: constant pressure
    pressure_pa: float
    tank_pa: float
    flow_m3_s: float
    cut_off_pa: float
    band_pa: float
    compensator_lag_s: float
    swash_lag_s: float
    relief_pa: float
    relief_gain: float  # m^3/s per Pa
    leakage: float  # m^3/s per Pa
    capacity: float  # m^3 per Pa


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
    supply: SupplyParameters
    valve: ValveParameters
    end_stop: EndStopParameters
    substeps: int  # of one control tick, as the stiffest friction law needs
    effects: tuple[tuple[float, ...], ...] | None = None  # coefficients; see effects.py


def plant_parameters(plant: Plant) -> PlantParameters:
    """Collect the parameters of a plant (or bench) file.

    Raises ``ConfigError`` for effects that are not in the catalogue or out of range.
    """
    laws = (LAWS[plant.friction.test.law], LAWS[plant.friction.load.law])
    test = _cylinder(plant.test_cylinder, plant.friction.test)
    load = _cylinder(plant.load_cylinder, plant.friction.load)
    par = PlantParameters(
        test=test,
        load=load,
        mass_test_kg=float(plant.moving_mass.test),
        mass_load_kg=float(plant.moving_mass.load),
        bulk_modulus_pa=float(plant.oil.bulk_modulus),
        supply=_supply(plant.supply),
        valve=_valve(plant.valve, plant.oil.density),
        end_stop=_end_stop(plant.end_stop),
        substeps=max(law.substeps for law in laws),
    )
    return with_effects(par, read_effects(plant.effects))


def _cylinder(cylinder: Cylinder, friction: Friction) -> CylinderParameters:
    return CylinderParameters(
        area_piston_m2=float(cylinder.area_piston_m2),
        area_rod_m2=float(cylinder.area_rod_m2),
        stroke_m=float(cylinder.stroke),
        dead_volume_piston_m3=float(cylinder.dead_volume_piston),
        dead_volume_rod_m3=float(cylinder.dead_volume_rod),
        offset_m=float(cylinder.offset),
        friction=friction_parameters(friction),
    )


def friction_parameters(friction: Friction) -> FrictionParameters:
    """Collect the parameters of one cylinder's friction."""
    values = friction.model_dump(exclude={"law"})
    for direction in ("extend", "retract"):  # the two lines of Marton and Lantos
        lines = values.pop(direction, None) or {}
        values |= {f"{direction}_{name}": value for name, value in lines.items()}
    elements = tuple(map(float, values.pop("elements", (0.0,))))
    numbers = {name: float(value) for name, value in values.items()}
    return FrictionParameters(law=LAWS[friction.law].code, elements=elements, **numbers)


def _valve(valve: Valve, density: float) -> ValveParameters:
    return ValveParameters(
        flow_gain=float(valve.gain) * sqrt(2 / density),
        natural_frequency_rad_s=2 * pi * float(valve.bandwidth),
        damping=float(valve.damping),
        limit_v=float(valve.limit),
    )


def _supply(supply: Supply) -> SupplyParameters:
    values = supply.pump.model_dump() if supply.pump else dict.fromkeys(Pump.model_fields, 1.0)
    return SupplyParameters(
        supply.pump is not None, float(supply.pressure), float(supply.tank), *values.values()
    )


def _end_stop(end_stop: EndStop) -> EndStopParameters:
    return EndStopParameters(float(end_stop.stiffness), float(end_stop.damping))
