"""Nuisance parameters: what a bench file knows only roughly, refitted before the search.

Three kinds. A factor on a value of the plant file has a prior (standard deviation of its logarithm)
and bounds at three of them. A coefficient of an effect has a tolerance: instruments within their
class and valves of one type differ by so much, so it is no effect below that limit. Inside it is
taken as equally likely (JCGM 100, 4.3.7: standard deviation a / sqrt 3), and bounded by it. The
drift of a sensor over the campaign (``measured/disturbances.py``) has half of its offset's limit.
"""

from collections.abc import Mapping
from math import log1p, sqrt
from typing import Any

from hbench.config.bench import Plant
from hbench.config.scaling import value_paths
from hbench.config.sensors import Instrument, Instruments
from hbench.errors import ConfigError
from hbench.model.effects.catalogue import read_effects
from hbench.reconcile.column_names import CoefficientKey
from hbench.units import from_si, to_si

_FRICTION = {  # a first guess of a seal's friction may be off by a factor of 5
    "coulomb": 0.8,
    "stiction": 0.8,
    "stribeck_velocity": 0.5,
    "stribeck_exponent": 0.25,  # a guess of 2 instead of 1 is within the bounds
    "viscous": 0.8,
    "bristle_stiffness": 0.8,
    "stribeck_force": 0.8,
}
_SUPPLY = "supply.pressure"
# Assumed accuracy of a plant file's values, as standard deviations of their logarithms.
FACTORS: Mapping[str, float] = {
    _SUPPLY: 0.02,
    "supply.tank": 0.8,  # return lines have filters, coolers and check valves
    "valve.gain": 0.15,
    "valve.bandwidth": 0.15,
    "oil.bulk_modulus": 0.3,
    "test_cylinder.dead_volume_piston": 0.3,
    "test_cylinder.dead_volume_rod": 0.3,
    "load_cylinder.dead_volume_piston": 0.3,
    "load_cylinder.dead_volume_rod": 0.3,
    **{
        path: prior
        for side in ("test", "load")
        for path, prior in {
            f"moving_mass.{side}": 0.2,
            **{f"friction.{side}.{name}": prior for name, prior in _FRICTION.items()},
        }.items()
    },
}
BOUND = 3.0  # priors
_LEAST_FRICTION = 0.002  # of the force at supply pressure
# Effects that state the same as a factor: beside one the value is the model file's.
REPLACED: Mapping[str, str] = {"valve_lag": "valve.bandwidth"}
_VALVE = {  # of all valves, which are of one type
    "curvature": 0.01,  # 1/V: the gain changes by 3 % at 3 V
    "small": 0.05,  # of the slope below 2 V
    "exponent": 0.1,  # of the flow over the pressure drop: 0.4 to 0.6, an orifice has 0.5
    "hose": to_si("0.05 bar min/l", "bar min/l"),  # of the line between valve and transducer
    "leak": 0.03,  # V, of 10 V: through both ports 0.6 % of the flow of a fully open valve
    "null_leak": 0.03,
}
_EACH_VALVE = {"gain": 0.1, "null": 0.2}  # of the gain; V, 2 % of 10 V
# k of u (1 + k sign u): 6 % between the flows of both directions; data sheets allow 10 %.
_UNEVEN = 0.03
_LAP_V = 0.03  # over- or underlap of spools that are called zero-lapped: 0.3 % of 10 V
_TRANSDUCERS = ("p_tp", "p_tr", "p_lp", "p_lr", "p_s")
ASSUMED_TOLERANCE = 0.01  # of sensors whose tolerance is not stated: a usual industrial class
# Effects that every bench has: refitted, never named.
BACKGROUND = frozenset({"valve_trim"})


def nuisances(plant: Any) -> dict[str, float]:
    """Return the priors of the factors that a plant, or part of a plant, has, by dotted path.

    A value that is smaller than its absolute accuracy has a wider one. Left out are values of zero,
    sections that a part of a plant does not have, and parameters of other friction laws. Raises
    ``ConfigError`` for a path that no plant has.
    """
    given = {path: nuisance_value(plant, path) for path in FACTORS}
    least = absolute_accuracies(plant)
    return {
        path: max(prior, log1p(least.get(path, 0.0) / given[path]))
        for path, prior in FACTORS.items()
        if given[path]
    }


def absolute_accuracies(plant: Any) -> dict[str, float]:
    """Return the assumed absolute accuracies [SI] of values that may be small, by dotted path.

    A return line has a back pressure, and hoses contain oil, here a tenth of the swept volume. No
    seal is without friction: 0.2 % of the force at supply pressure. Viscous friction at 1 m/s may
    be as large as static friction.
    """
    accuracies = {"supply.tank": 0.5e5}
    for side in ("test", "load"):
        cylinder: Any = getattr(plant, f"{side}_cylinder", None)
        if stroke := getattr(cylinder, "stroke", 0.0):
            areas_m2 = {"piston": cylinder.area_piston_m2, "rod": cylinder.area_rod_m2}
            for chamber, area_m2 in areas_m2.items():
                accuracies[f"{side}_cylinder.dead_volume_{chamber}"] = 0.1 * area_m2 * stroke
        area_m2 = getattr(cylinder, "area_piston_m2", 0.0)
        least_n = _LEAST_FRICTION * area_m2 * nuisance_value(plant, _SUPPLY)
        static_n = nuisance_value(plant, f"friction.{side}.stiction")
        accuracies |= {
            f"friction.{side}.coulomb": least_n,
            f"friction.{side}.stiction": least_n,
            f"friction.{side}.viscous": max(static_n, least_n),
        }
    return accuracies


def zero_values(plant: Any) -> dict[str, float]:
    """Return the values [SI] from which a refit starts where a plant file has 0, by dotted path.

    No factor changes 0. From a quarter of the accuracy the bounds are a factor of 125.
    """
    return {
        path: 0.25 * value
        for path, value in absolute_accuracies(plant).items()
        if value and _value(plant, path) == 0.0
    }


def nuisance_value(plant: Any, path: str) -> float:
    """Return the value at a nuisance's path; 0 where this plant has none.

    Raises ``ConfigError`` for a path that no plant has.
    """
    return _value(plant, path) or 0.0


def _value(plant: Any, path: str) -> float | None:
    """Return the value at a nuisance's path; None where this plant has none."""
    if path not in value_paths(Plant):
        raise ConfigError(f"nuisance {path}: no plant file has this key", "Correct the path.")
    value: Any = plant
    for name in path.split("."):
        value = getattr(value, name, None)
    return value


def tolerances(
    plant: Any, instruments: Instruments | None, largest_pa: float, largest_n: float
) -> dict[CoefficientKey, float]:
    """Return the limits [SI] of coefficients that no bench is free of.

    Those of a valve's gain and null are shares of its size, which the plant's effects may state.

    ``largest_pa`` and ``largest_n`` are the largest readings: where a tolerance is of the reading,
    an offset may be as large as there. Without instruments 1 % of the largest reading is assumed.
    """
    stated = read_effects(plant.effects).get("valve_trim", {})
    limits = {
        ("valve_trim", f"{kind}_{valve}"): limit * (1.0 + stated.get(f"gain_{valve}", 0.0))
        for valve in ("test", "load_1", "load_2")
        for kind, limit in _EACH_VALVE.items()
    } | {("valve_trim", kind): limit for kind, limit in _VALVE.items()}
    limits |= {("valve_trim", key): _UNEVEN for key in ("ports", "inlets")}
    limits |= {("valve_deadband", key): _LAP_V for key in ("test", "load")}
    limits |= {("valve_asymmetry", key): _UNEVEN for key in ("test", "load", "load_apart")}
    return limits | sensor_tolerances(instruments, largest_pa, largest_n)


def sensor_tolerances(
    instruments: Instruments | None, largest_pa: float, largest_n: float
) -> dict[CoefficientKey, float]:
    """Return those limits of ``tolerances`` that are of sensors."""
    pressure, force = _stated(instruments, largest_pa, largest_n)
    limits = {}
    for name in _TRANSDUCERS:
        limits["pressure_offset", name] = _offset(pressure, largest_pa)
        limits["pressure_gain", name] = pressure.tolerance
    limits["load_cell_gain", "error"] = force.tolerance
    limits["load_cell_offset", "force"] = _offset(force, largest_n)
    return limits


def zero_tolerances(limits: Mapping[CoefficientKey, float]) -> dict[str, float]:
    """Return the largest offset of each sensor within its tolerance, in bar and N by reading."""
    offsets = {name: limits.get(("pressure_offset", name)) for name in _TRANSDUCERS}
    in_bar = {name: from_si(limit, "bar") for name, limit in offsets.items() if limit is not None}
    force = limits.get(("load_cell_offset", "force"))
    return in_bar | ({} if force is None else {"f_applied": force})


def drift_deviations(limits: Mapping[CoefficientKey, float]) -> dict[str, float]:
    """Return the standard deviations [SI] of the sensors' drifts, by channel.

    A class is stated for months; half of an offset's limit within one campaign. The supply's
    transducer is left out: its drift is not distinguishable from that of the supply.
    """
    offsets = {name: limits["pressure_offset", name] for name in _TRANSDUCERS if name != "p_s"}
    offsets["f_applied"] = limits["load_cell_offset", "force"]
    return {channel: standard_deviation(0.5 * limit) for channel, limit in offsets.items()}


def _stated(
    instruments: Instruments | None, largest_pa: float, largest_n: float
) -> tuple[Instrument, Instrument]:
    """Return the tolerances of pressure transducers and load cell, assumed where not stated."""
    if instruments is not None:
        return instruments.pressure, instruments.force
    assumed = {"tolerance": ASSUMED_TOLERANCE, "of": "reading"}
    return (
        Instrument.model_validate({**assumed, "full_scale": largest_pa}),
        Instrument.model_validate({**assumed, "full_scale": largest_n}),
    )


def _offset(instrument: Instrument, largest: float) -> float:
    """Return the largest offset within a tolerance."""
    at = largest if instrument.of == "reading" else instrument.full_scale
    return instrument.tolerance * at


def standard_deviation(limit: float) -> float:
    """Return that of a value anywhere within +-``limit``."""
    return limit / sqrt(3)
