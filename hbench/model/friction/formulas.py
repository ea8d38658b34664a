"""Formulas of the static friction laws, written once for numbers and for arrays.

numpy evaluates them for the fits' arrays; ``static_laws.py`` compiles the same functions for the
plant. So they take scalars or arrays, do not call each other, and need no numba. Forces in N,
speeds |v| in m/s, pressures in Pa. ``records/friction_laws.py`` is the table of the laws.
"""

from typing import TypeVar

import numpy as np

Value = TypeVar("Value", float, np.ndarray)


def seal_force(p_p: Value, p_r: Value, k_piston: float, k_rod: float) -> Value:
    """F_seal = k_piston |P_p - P_r| + k_rod P_r: terms of 3.7."""
    return k_piston * np.abs(p_p - p_r) + k_rod * p_r


def stribeck_curve(
    speed: Value,
    seal: Value | float,
    coulomb: float,
    stiction: float,
    stribeck_velocity: float,
    exponent: float,
) -> Value:
    """F_dry = F_C + F_seal + (F_s - F_C) exp(-(|v| / v_s)^delta): 3.2, delta of 3.9."""
    ratio = speed / stribeck_velocity
    if exponent != 1.0:
        ratio = ratio**exponent
    return coulomb + seal + (stiction - coulomb) * np.exp(-ratio)


def pressure_curve(speed: Value, seal: Value, force: float, rate: float) -> Value:
    """F_dry = k_1 exp(k_2 |v|) + F_seal: 3.7 with k_3 and k_4 as the seals' coefficients."""
    return force * np.exp(rate * speed) + seal


def two_lines(
    speed: Value, low_force: float, low_slope: float, high_force: float, high_slope: float
) -> Value:
    """F = max(a_1 + b_1 |v|, a_2 + b_2 |v|): 3.3, the low line being the steeper to fall.

    Below v_SW = (a_1 - a_2) / (b_2 - b_1) (3.6) the low line is the larger of the two.
    """
    return np.maximum(low_force + low_slope * speed, high_force + high_slope * speed)


def joined_lines(
    speed: Value, low_force: float, low_slope: float, high_slope: float, v_switch: float
) -> Value:
    """F = a_1 + b_1 min(|v|, v_SW) + b_2 max(|v| - v_SW, 0): ``two_lines`` by its switch velocity.

    a_2 = a_1 + (b_1 - b_2) v_SW. A fit needs v_SW as a parameter.
    """
    low = np.minimum(speed, v_switch)
    return low_force + low_slope * low + high_slope * (speed - low)
