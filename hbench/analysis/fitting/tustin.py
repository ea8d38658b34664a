"""Tustin law (3.2) for magnitudes, so that both directions have positive parameters."""

from collections.abc import Mapping

import numpy as np

from hbench.analysis.fitting.fittable_law import FittableLaw
from hbench.model.friction.formulas import stribeck_curve
from hbench.records.friction_laws import FRICTION_LAWS

PARAMETER_UNITS = FRICTION_LAWS["tustin"].units
PARAMETER_NAMES = tuple(PARAMETER_UNITS)

_WIDE = 10.0  # times the largest friction, over the highest speed


def tustin_friction(v_m_s: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return F_C + (F_s - F_C) exp(-v / v_s) + B v [N] at speeds >= 0 (p: ``PARAMETER_NAMES``)."""
    f_c, f_s, v_s, b = p
    return stribeck_curve(v_m_s, 0.0, f_c, f_s, v_s, 1.0) + b * v_m_s


def tustin_jacobian(v_m_s: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return the derivatives (n, 4) of ``tustin_friction`` by its parameters."""
    f_c, f_s, v_s, _ = p
    e = np.exp(-v_m_s / v_s)
    return np.column_stack([1 - e, e, (f_s - f_c) * e * v_m_s / v_s**2, v_m_s])


def _basis(inputs: np.ndarray, v_s: float) -> np.ndarray:
    e = np.exp(-inputs[0] / v_s)
    return np.column_stack([1 - e, e, inputs[0]])


def tustin_bounds(inputs: np.ndarray, force_n: float) -> Mapping[str, tuple[float, float]]:
    """Return bounds from the points: speeds (``inputs`` (3, n)) and the largest friction.

    v_s lies between the lowest and the highest speed: a decay below the lowest, or one that is
    nearly straight up to the highest, does not show in the points. The others are not negative, and
    at most ten times what the points can show.
    """
    speed, most = inputs[0], _WIDE * force_n
    return {
        "f_coulomb_n": (0.0, most),
        "f_stiction_n": (0.0, most),
        "v_stribeck_m_s": (float(speed.min()), float(speed.max())),
        "b_viscous_n_s_m": (0.0, most / float(speed.max())),
    }


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
