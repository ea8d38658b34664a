"""The plant's parameters as plain numbers that compiled code takes: SI, frozen, replaceable.

Vary one with ``par._replace(...)``. Every field is a float unless it says otherwise: another type
would compile everything anew.
"""

from typing import Any, NamedTuple


class FrictionParameters(NamedTuple):
    """Friction of one cylinder: the keys of the bench file in SI (``records/friction_laws.py``).

    Parameters that the cylinder's law does not have keep their defaults and are not read.
    """

    law: int  # code in friction.laws.LAWS
    scatter: float = 0.0  # standard deviation of the level from stroke to stroke
    viscous: float = 0.0  # B, N s/m
    piston_seal: float = 0.0  # N per Pa of |P_p - P_r|
    rod_seal: float = 0.0  # N per Pa of P_r
    # Stribeck curve: Tustin, LuGre, Leuven
    coulomb: float = 0.0  # F_C, N
    stiction: float = 0.0  # F_s, N
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
    """Cylinder with its piston at ``x + offset_m``, between 0 and its stroke."""

    area_piston_m2: float
    area_rod_m2: float
    stroke_m: float
    dead_volume_piston_m3: float
    dead_volume_rod_m3: float
    offset_m: float
    friction: FrictionParameters


class ValveParameters(NamedTuple):
    """Parameters that the three servo valves share."""

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
    """All parameters of the equations of motion."""

    test: CylinderParameters
    load: CylinderParameters
    mass_test_kg: float
    mass_load_kg: float
    bulk_modulus_pa: float
    supply: SupplyParameters
    valve: ValveParameters
    end_stop: EndStopParameters
    substeps: int  # of one control tick, as the stiffest friction law needs
    effects: tuple[tuple[float, ...], ...] | None = None  # coefficients; see effects/catalogue.py
    oil_k: float = 313.15  # temperature in the tank at the start
    learned: Any = None  # array of effects/learned.py; None where ``effects`` is
