"""Eigenvalues of the bench at constant velocity, with its friction law.

``linearisation.py`` has viscous friction alone, as the source's design. Here the
plant's Jacobian by differences includes the slope of the Stribeck curve and a dynamic law's states.
"""

from collections.abc import Sequence
from math import copysign

import numpy as np

from hbench.control.jacobian import plant_state
from hbench.control.linearisation import OperatingPoint
from hbench.control.sampled import Pi
from hbench.model import plant
from hbench.model.friction.laws import settled_deflection, steady_friction
from hbench.model.parameters import PlantParameters

# In the order of the commands.
_OUTPUTS = (plant.V, plant.P_LR, plant.P_LP)
_STEPS = {plant.V: 1e-6, plant.Z_T: 1e-8, plant.Z_L: 1e-8} | dict.fromkeys(
    (plant.P_TP, plant.P_TR, plant.P_LP, plant.P_LR), 100.0
)


def linearised_plant(
    par: PlantParameters, point: OperatingPoint
) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """Return A (n, n) and B (n, 3) of the plant, and its states, as numbered in ``model/plant.py``.

    Position and supply are held. LuGre's deflections are states; they have settled.
    """
    state, levels = plant_state(par, point), np.ones(2)
    u = np.array([point.u_t_v, point.u_l1_v, point.u_l2_v])
    states = list(range(plant.V, plant.RATE_L2 + 1))
    for index, cylinder, p_p, p_r in (
        (plant.Z_T, par.test, point.p_tp_pa, point.p_tr_pa),
        (plant.Z_L, par.load, point.p_lp_pa, point.p_lr_pa),
    ):
        settled = settled_deflection(point.v_m_s, p_p, p_r, cylinder.friction)
        if settled is not None:
            state[index] = settled
            states.append(index)

    def slopes(change: np.ndarray, command: np.ndarray) -> np.ndarray:
        out = np.zeros(len(state))
        plant.derivatives(state + change, command, levels, par, out)
        return out[states]

    columns, nothing = [], np.zeros(len(state))
    for index in states:
        h = _STEPS.get(index, 1e-3)
        change = nothing.copy()
        change[index] = h
        columns.append((slopes(change, u) - slopes(-change, u)) / (2 * h))
    inputs = [
        (slopes(nothing, u + 1e-3 * unit) - slopes(nothing, u - 1e-3 * unit)) / 2e-3
        for unit in np.eye(3)
    ]
    return np.array(columns).T, np.array(inputs).T, states


def plant_eigenvalues(par: PlantParameters, point: OperatingPoint) -> np.ndarray:
    """Return the eigenvalues [1/s] of the plant with its commands held."""
    return np.linalg.eigvals(linearised_plant(par, point)[0])


def loop_eigenvalues(
    par: PlantParameters, point: OperatingPoint, loops: Sequence[Pi]
) -> np.ndarray:
    """Return the eigenvalues [1/s] with the three PI loops closed (4.36), in continuous time.

    ``loops``: K_c and tau_c of u_T, u_L1, u_L2; u = K_c (tau_c e + integral of e). No filters.
    """
    a, b, states = linearised_plant(par, point)
    h = np.zeros((3, len(states)))
    for row, output in enumerate(_OUTPUTS):
        h[row, states.index(output)] = 1.0
    gain, tau = np.array(loops).T
    upper = np.hstack([a - b @ np.diag(gain * tau) @ h, b @ np.diag(gain)])
    return np.linalg.eigvals(np.vstack([upper, np.hstack([-h, np.zeros((3, 3))])]))


def friction_slope(par: PlantParameters, point: OperatingPoint) -> float:
    """Return the slope [N s/m] of the steady friction of both cylinders over velocity."""
    v, h = point.v_m_s, copysign(1e-6, point.v_m_s)
    total = 0.0
    for cylinder, p_p, p_r in (
        (par.test, point.p_tp_pa, point.p_tr_pa),
        (par.load, point.p_lp_pa, point.p_lr_pa),
    ):
        above, below = (steady_friction(w, p_p, p_r, cylinder.friction) for w in (v + h, v - h))
        total += (above - below) / (2 * h)
    return total
