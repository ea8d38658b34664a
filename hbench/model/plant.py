"""The bench as a system of differential equations, and one control tick of it.

The state is an array of 14 floats, the commands u one of three, both indexed by the names below.
Positive velocity extends the test cylinder; the load cylinder retracts with it.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hbench.errors import ConfigError
from hbench.model import supply
from hbench.model.compiled import compiled
from hbench.model.cylinders import (
    end_stop_force,
    extending_volumes,
    pressure_force,
    pressure_rate,
    retracting_volumes,
)
from hbench.model.friction import friction
from hbench.model.valves import port_flow, spool_acceleration

if TYPE_CHECKING:
    from hbench.model.parameters import PlantParameters

# State: m, m/s; Pa; spools in V and V/s; bristles in m.
N_STATES = 14
X, V, P_TP, P_TR, P_LP, P_LR = 0, 1, 2, 3, 4, 5
SPOOL_T, SPOOL_L1, SPOOL_L2, RATE_T, RATE_L1, RATE_L2 = 6, 7, 8, 9, 10, 11
Z_T, Z_L = 12, 13

# Commands in V: test valve, load valve 1 (rod side), load valve 2 (piston side).
U_T, U_L1, U_L2 = 0, 1, 2

# Levels of friction; 1 is nominal. The array may go on with a state of its owner.
LEVEL_T, LEVEL_L = 0, 1

TICK_S = 1e-4  # one control tick, the step that the friction laws' substeps refer to
WORK_SHAPE = (3, N_STATES)  # scratch of one step, so that it allocates nothing


class Forces(NamedTuple):
    """Forces [N] at one moment, and what follows from them."""

    friction_test: float
    friction_load: float
    applied: float  # what the load cell carries
    acceleration: float  # m/s^2
    z_rate_test: float  # m/s
    z_rate_load: float


@compiled
def forces(state: np.ndarray, levels: np.ndarray, par: "PlantParameters") -> Forces:
    """Newton's law for the moving masses and for the load's part alone (2.10, 2.11).

    (m_T + m_L) a = F_T - F_L - F_fT - F_fL + F_stops
    F_applied = F_L + F_fL + m_L a - F_stop,L

    The load cell sits between the masses, so it carries the load mass's inertia (the erratum of
    2.12) and what the load cylinder's heads take.
    """
    x, v = state[X], state[V]
    p_tp, p_tr, p_lp, p_lr = state[P_TP], state[P_TR], state[P_LP], state[P_LR]
    friction_t, z_rate_t = friction(v, state[Z_T], p_tp, p_tr, levels[LEVEL_T], par.test.friction)
    friction_l, z_rate_l = friction(v, state[Z_L], p_lp, p_lr, levels[LEVEL_L], par.load.friction)
    test = pressure_force(p_tp, p_tr, par.test) + end_stop_force(x, v, par.test, par.end_stop)
    load = pressure_force(p_lp, p_lr, par.load) - end_stop_force(x, v, par.load, par.end_stop)
    mass = par.mass_test_kg + par.mass_load_kg
    acceleration = (test - load - friction_t - friction_l) / mass
    applied = load + friction_l + par.mass_load_kg * acceleration
    return Forces(friction_t, friction_l, applied, acceleration, z_rate_t, z_rate_l)


@compiled
def load_cell_force(state: np.ndarray, levels: np.ndarray, par: "PlantParameters") -> float:
    """F_applied [N] at this moment; positive opposes extension."""
    return forces(state, levels, par).applied


@compiled
def derivatives(
    state: np.ndarray,
    u: np.ndarray,
    levels: np.ndarray,
    par: "PlantParameters",
    out: np.ndarray,
) -> None:
    """Write the time derivative of ``state`` under the commands ``u`` into ``out``."""
    x, v = state[X], state[V]
    p_supply, p_tank = supply.pressures(par)
    moment = forces(state, levels, par)
    out[X] = v
    out[V] = moment.acceleration
    out[Z_T] = moment.z_rate_test
    out[Z_L] = moment.z_rate_load

    test, load, beta, valve = par.test, par.load, par.bulk_modulus_pa, par.valve
    v_tp, v_tr = extending_volumes(x, test)
    v_lp, v_lr = retracting_volumes(x, load)
    q_tp = port_flow(state[SPOOL_T], state[P_TP], p_supply, p_tank, valve)
    q_tr = port_flow(-state[SPOOL_T], state[P_TR], p_supply, p_tank, valve)
    q_lp = port_flow(state[SPOOL_L2], state[P_LP], p_supply, p_tank, valve)
    q_lr = port_flow(state[SPOOL_L1], state[P_LR], p_supply, p_tank, valve)
    out[P_TP] = pressure_rate(state[P_TP], v_tp, q_tp - test.area_piston_m2 * v, beta)
    out[P_TR] = pressure_rate(state[P_TR], v_tr, q_tr + test.area_rod_m2 * v, beta)
    out[P_LP] = pressure_rate(state[P_LP], v_lp, q_lp + load.area_piston_m2 * v, beta)
    out[P_LR] = pressure_rate(state[P_LR], v_lr, q_lr - load.area_rod_m2 * v, beta)

    for i in range(3):
        out[SPOOL_T + i] = state[RATE_T + i]
        out[RATE_T + i] = spool_acceleration(u[i], state[SPOOL_T + i], state[RATE_T + i], valve)


@compiled
def step(
    state: np.ndarray,
    u: np.ndarray,
    levels: np.ndarray,
    par: "PlantParameters",
    dt: float,
    work: np.ndarray,
) -> None:
    """Advance ``state`` in place by ``dt`` [s]: Runge-Kutta 4, in the law's number of substeps.

    ``work`` is scratch of ``WORK_SHAPE``. Commands and levels are held.
    """
    slope, total, trial = work[0], work[1], work[2]
    h = dt / par.substeps
    for _ in range(par.substeps):
        trial[:] = state
        total[:] = 0.0
        for weight, reach in ((1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)):
            derivatives(trial, u, levels, par, slope)
            for i in range(N_STATES):
                total[i] += weight * slope[i]
                trial[i] = state[i] + reach * h * slope[i]
        for i in range(N_STATES):
            state[i] += h / 6.0 * total[i]


def initial_state(par: "PlantParameters", x_m: float, p_lr_pa: float, p_lp_pa: float) -> np.ndarray:
    """Return the bench at rest in equilibrium: closed valves, relaxed bristles, F_T = F_L.

    Of the pressures with F_T = F_L these lie on the line that the symmetric valve keeps in steady
    motion, in the direction that the load opposes (r = A_r / A_p):

        extension   P_Tr - P_t = r^2 (P_s - P_Tp)        for F_L >= 0
        retraction  P_s - P_Tr = r^2 (P_Tp - P_t)        for F_L < 0

    Raises ``ConfigError`` where the test cylinder can't carry the load.
    """
    a_p, a_r = par.test.area_piston_m2, par.test.area_rod_m2
    ratio = (a_r / a_p) ** 2
    f_load = p_lp_pa * par.load.area_piston_m2 - p_lr_pa * par.load.area_rod_m2
    near, far = par.p_supply_pa, par.p_tank_pa  # of the piston side
    if f_load < 0.0:
        near, far = far, near
    p_tp = (f_load + a_r * (far + ratio * near)) / (a_p + a_r * ratio)
    p_tr = far + ratio * (near - p_tp)
    if not par.p_tank_pa <= p_tp <= par.p_supply_pa:
        raise ConfigError(
            f"a load of {f_load:.0f} N would need {p_tp / 1e5:.1f} bar on the test cylinder's "
            f"piston side; it has {par.p_tank_pa / 1e5:g} to {par.p_supply_pa / 1e5:g} bar"
        )
    state = np.zeros(N_STATES)
    state[X] = x_m
    state[[P_TP, P_TR, P_LP, P_LR]] = p_tp, p_tr, p_lp_pa, p_lr_pa
    return state
