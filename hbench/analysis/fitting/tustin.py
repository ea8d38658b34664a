"""Tustin law (3.2) for magnitudes, so that both directions have positive parameters."""

from collections.abc import Mapping

import numpy as np

from hbench.analysis.fitting.fittable_law import FittableLaw
from hbench.model.friction.formulas import stribeck_curve
from hbench.records.friction_laws import FRICTION_LAWS

PARAMETER_UNITS = FRICTION_LAWS["tustin"].units
PARAMETER_NAMES = tuple(PARAMETER_UNITS)

# The source's bounds, which it set after seeing its data, as it warns.
TABLE_6_1: Mapping[str, tuple[float, float]] = {
    "f_coulomb_n": (0.0, 1e5),
    "f_stiction_n": (0.0, 1e5),
    "v_stribeck_m_s": (0.05, 0.2),
    "b_viscous_n_s_m": (0.0, 1e5),
}


def tustin_friction(v_m_s: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return F_C + (F_s - F_C) exp(-v / v_s) + B v [N] at speeds >= 0 (p: ``PARAMETER_NAMES``)."""
    f_c, f_s, v_s, b = p
    return stribeck_curve(v_m_s, 0.0, f_c, f_s, v_s, 1.0) + b * v_m_s


def tustin_jacobian(v_m_s: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the derivatives (n, 4) of ``tustin`` by its parameters."""
    f_c, f_s, v_s, _ = p
    e = np.exp(-v_m_s / v_s)
    return np.column_stack([1 - e, e, (f_s - f_c) * e * v_m_s / v_s**2, v_m_s])


def _basis(inputs: np.ndarray, v_s: float) -> np.ndarray:
    e = np.exp(-inputs[0] / v_s)
    return np.column_stack([1 - e, e, inputs[0]])


def tustin_bounds(inputs: np.ndarray) -> Mapping[str, tuple[float, float]]:
    """Return the bounds of table 6.1, but v_s between the lowest and the highest measured speed.

    A decay below the lowest speed, or one that is nearly straight up to the highest, does not show
    in the points (``inputs`` (3, n), as of ``FittableLaw``).
    """
    speed = inputs[0]
    return {**TABLE_6_1, "v_stribeck_m_s": (float(speed.min()), float(speed.max()))}


TUSTIN_LAW = FittableLaw(
    name="tustin",
    units=PARAMETER_UNITS,
    model=lambda inputs, p: tustin_friction(inputs[0], p),
    jacobian=lambda inputs, p: tustin_jacobian(inputs[0], p),
    basis=_basis,
    nonlinear="v_stribeck_m_s",
    bounds=tustin_bounds,
    scale=lambda inputs, force: np.array([force, force, 0.2, force / inputs[0].max()]),
)
