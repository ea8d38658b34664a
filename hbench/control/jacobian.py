"""The plant linearised by differences: a check of the linearisation made by hand."""

import numpy as np

from hbench.control.linearisation import LinearCoefficients, OperatingPoint, state_space
from hbench.model import plant
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters, PlantParameters
from hbench.model.supply import rest_flow

# The linear model's states among the plant's: position, supply and bristles are held.
_STATES = (
    plant.V,
    *(plant.P_TP, plant.P_TR, plant.P_LP, plant.P_LR),
    *(plant.SPOOL_T, plant.SPOOL_L1, plant.SPOOL_L2),
    *(plant.RATE_T, plant.RATE_L1, plant.RATE_L2),
)


def plant_state(par: PlantParameters, point: OperatingPoint) -> np.ndarray:
    """Return the plant's state at ``point``, its bristles relaxed."""
    state = np.zeros(plant.n_states(par))
    state[[plant.X, plant.V]] = point.x_m, point.v_m_s
    pressures = point.p_tp_pa, point.p_tr_pa, point.p_lp_pa, point.p_lr_pa
    state[[plant.P_TP, plant.P_TR, plant.P_LP, plant.P_LR]] = pressures
    spools = point.u_t_v, point.u_l1_v, point.u_l2_v
    state[[plant.SPOOL_T, plant.SPOOL_L1, plant.SPOOL_L2]] = spools
    state[[plant.P_S, plant.PUMP_FLOW]] = rest_flow(par.supply)
    return state


def numerical_jacobian(
    par: PlantParameters, point: OperatingPoint
) -> tuple[np.ndarray, np.ndarray]:
    """Return A (11, 11) and B (11, 3) of the plant's ``derivatives`` by central differences.

    Rows and columns as in ``linearisation.state_space``.
    """
    state, levels = plant_state(par, point), np.ones(2)
    u = np.array([point.u_t_v, point.u_l1_v, point.u_l2_v])
    # Wide enough for the rounding of pressures near 1e7, and small against their own scale.
    steps = np.array([1e-5, *[100.0] * 4, *[1e-4] * 3, *[1e-2] * 3])

    def slopes(change: np.ndarray, command: np.ndarray) -> np.ndarray:
        out = np.zeros(len(state))
        plant.derivatives(state + change, command, levels, par, out)
        return out[list(_STATES)]

    columns = []
    for index, h in zip(_STATES, steps, strict=True):
        change = np.zeros(len(state))
        change[index] = h
        columns.append((slopes(change, u) - slopes(-change, u)) / (2 * h))
    nothing, inputs, h = np.zeros(len(state)), [], 1e-4
    for direction in np.eye(3):
        ahead, back = slopes(nothing, u + h * direction), slopes(nothing, u - h * direction)
        inputs.append((ahead - back) / (2 * h))
    return np.array(columns).T, np.array(inputs).T


def disagreement(par: PlantParameters, point: OperatingPoint, c: LinearCoefficients) -> float:
    """Return the largest relative difference between entries of the two linearisations.

    Where an entry is zero by hand, the other's counts relative to the largest of its row. Both
    take the point's viscous friction, as in 4.1.
    """
    static = FrictionParameters(law=LAWS["tustin"].code)
    same = par._replace(
        test=par.test._replace(friction=static._replace(viscous=point.viscous_n_s_m)),
        load=par.load._replace(friction=static),
    )
    by_hand, by_plant = state_space(c, par), numerical_jacobian(same, point)
    worst = 0.0
    for hand, numeric in zip(by_hand, by_plant, strict=True):
        row = np.abs(hand).max(axis=1, keepdims=True)
        scale = np.where(hand != 0, np.abs(hand), np.where(row > 0, row, 1.0))
        worst = max(worst, float(np.max(np.abs(hand - numeric) / scale)))
    return worst
