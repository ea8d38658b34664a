"""The plant's parameters built from a plant or bench file."""

from math import pi, sqrt

from hbench.config.bench import Cylinder, EndStop, Plant, Pump, Supply, Valve
from hbench.config.friction import Friction
from hbench.model.effects.catalogue import read_effects, with_effects
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import (
    CylinderParameters,
    EndStopParameters,
    FrictionParameters,
    PlantParameters,
    SupplyParameters,
    ValveParameters,
)


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
        oil_k=float(plant.oil.temperature),
    )
    return with_effects(par, read_effects(plant.effects), plant.learned)


def lone_cylinder(test: CylinderParameters, mass_kg: float = 1.0) -> PlantParameters:
    """Return parameters of a plant in which only the test cylinder and its mass are known.

    The load cylinder has no friction; valves, supply and oil have arbitrary values.
    """
    without_friction = FrictionParameters(law=LAWS["tustin"].code)
    return PlantParameters(
        test=test,
        load=test._replace(friction=without_friction),
        mass_test_kg=mass_kg,
        mass_load_kg=0.0,
        bulk_modulus_pa=1e9,
        supply=SupplyParameters(False, *[0.0] * 11),
        valve=ValveParameters(*[1.0] * 4),
        end_stop=EndStopParameters(0.0, 0.0),
        substeps=1,
    )


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
