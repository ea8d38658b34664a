"""Pressure-based law (3.7), for the points of all loads and directions jointly.

k4 needs both directions or different rod-side pressures: within one of them P_r is nearly constant
over speed.
"""

import numpy as np

from hbench.analysis.fitting.fittable_law import FittableLaw
from hbench.config.fitting import FitBounds
from hbench.model.friction.formulas import pressure_curve, seal_force
from hbench.records.friction_laws import FRICTION_LAWS

PARAMETER_UNITS = FRICTION_LAWS["pressure_based"].units


def pressure_based_friction(
    speed_m_s: np.ndarray, p_p_pa: np.ndarray, p_r_pa: np.ndarray, k: np.ndarray
) -> np.ndarray:
    """Return the magnitude of friction [N] at speeds >= 0, k in ``PARAMETER_UNITS`` order."""
    k1, k2, k3, k4, k5 = k
    seal = seal_force(p_p_pa, p_r_pa, k3, k4)
    return pressure_curve(speed_m_s, seal, k1, k2) + k5 * speed_m_s


def _basis(inputs: np.ndarray, k2: float) -> np.ndarray:
    speed, p_p, p_r = inputs
    return np.column_stack([np.exp(k2 * speed), np.abs(p_p - p_r), p_r, speed])


def _jacobian(inputs: np.ndarray, k: np.ndarray) -> np.ndarray:
    speed = inputs[0]
    return np.insert(_basis(inputs, k[1]), 1, k[0] * speed * np.exp(k[1] * speed), axis=1)


def _scale(inputs: np.ndarray, force: float) -> np.ndarray:
    speed, p_p, p_r = (float(np.abs(row).max()) for row in inputs)
    pressure = max(p_p, p_r, 1.0)
    return np.array([force, 1 / speed, force / pressure, force / pressure, force / speed])


PRESSURE_BASED = FittableLaw(
    name="pressure_based",
    units=PARAMETER_UNITS,
    model=lambda inputs, k: pressure_based_friction(inputs[0], inputs[1], inputs[2], k),
    jacobian=_jacobian,
    basis=_basis,
    nonlinear="k2_s_m",
    bounds=lambda inputs, force_n: {"k2_s_m": FitBounds().k2_s_m},
    scale=_scale,
    pressures=True,
)
