"""Differential equations of the bench, and their integration over one control tick.

The state is an array of floats (``states.py``), the commands u an array of three, indexed below.
Positive velocity extends the test cylinder; the load cylinder retracts with it.
"""

from typing import NamedTuple

import numpy as np

from hbench.errors import ConfigError
from hbench.model.compiled import inlined
from hbench.model.cylinders import (
    end_stop_force,
    extending_volumes,
    pressure_force,
    pressure_rate,
    retracting_volumes,
)
from hbench.model.effects.applied import (
    effect_states,
    flow_effects,
    friction_effects,
    oil,
    openings,
    port_effects,
)
from hbench.model.effects.couplings import ChamberFlows, Openings, PortFlows
from hbench.model.friction.laws import friction, hold_slipped
from hbench.model.parameters import PlantParameters
from hbench.model.states import (  # noqa: F401  all indices of the state, for its readers
    P_LP,
    P_LR,
    P_S,
    P_TP,
    P_TR,
    PUMP_COMMAND,
    PUMP_FLOW,
    RATE_L1,
    RATE_L2,
    RATE_T,
    SPOOL_L1,
    SPOOL_L2,
    SPOOL_T,
    Z_L,
    Z_T,
    V,
    X,
    bristles_end,
)
from hbench.model.supply import pump_rates, rest_flow
from hbench.model.valves import port_flow, spool_acceleration

# Commands in V: test valve, load valve 1 (rod side), load valve 2 (piston side).
U_T, U_L1, U_L2 = 0, 1, 2

# Levels of friction; 1 is nominal. The array may go on with a state of its owner.
LEVEL_T, LEVEL_L = 0, 1

TICK_S = 1e-4  # one control tick, the step that the friction laws' substeps refer to

_FADED = 1e-100  # a state below it is 0: resting spools' denormal numbers would halve the speed


@inlined
def n_states(par: PlantParameters) -> int:
    """Return the length of the state; a constant of the parameters' type, so loops unroll."""
    return bristles_end(par) + effect_states(par.effects)


def new_work(par: PlantParameters) -> np.ndarray:
    """Return the scratch of ``step``, so that it allocates nothing."""
    return np.zeros((4, n_states(par)))


class MassForces(NamedTuple):
    """Forces [N] on the moving masses at one moment, and their acceleration."""

    friction_test: float
    friction_load: float
    applied: float  # on the load cell
    acceleration: float  # m/s^2


@inlined
def forces(
    state: np.ndarray, levels: np.ndarray, par: PlantParameters, rates: np.ndarray
) -> MassForces:
    """Newton's law for the moving masses and for the load's part alone (2.10, 2.11).

    (m_T + m_L) a = F_T - F_L - F_fT - F_fL + F_stops
    F_applied = F_L + F_fL + m_L a - F_stop,L

    The load cell sits between the masses, so it carries the load mass's inertia (the erratum of
    2.12) and what the load cylinder's heads take. The rates of the bristles and of the effects on
    friction go into ``rates``, an array like the state.
    """
    x, v = state[X], state[V]
    p_tp, p_tr, p_lp, p_lr = state[P_TP], state[P_TR], state[P_LP], state[P_LR]
    level_t, level_l, more_t, more_l = friction_effects(
        levels[LEVEL_T], levels[LEVEL_L], state, par, par.effects, rates
    )
    friction_t = friction(v, state, Z_T, p_tp, p_tr, level_t, par.test.friction, rates) + more_t
    friction_l = friction(v, state, Z_L, p_lp, p_lr, level_l, par.load.friction, rates) + more_l
    test = pressure_force(p_tp, p_tr, par.test) + end_stop_force(x, v, par.test, par.end_stop)
    load = pressure_force(p_lp, p_lr, par.load) - end_stop_force(x, v, par.load, par.end_stop)
    per_mass = 1.0 / (par.mass_test_kg + par.mass_load_kg)  # once: a product takes less time
    acceleration = (test - load - friction_t - friction_l) * per_mass
    applied = load + friction_l + par.mass_load_kg * acceleration
    return MassForces(friction_t, friction_l, applied, acceleration)


@inlined
def valve_flows(
    state: np.ndarray,
    opened: Openings,
    p_tank: float,
    par: PlantParameters,
    rates: np.ndarray,
) -> ChamberFlows:
    """Return the flows of the valves into the chambers, from the supply and into the tank.

    States that effects have there write their rates into ``rates``.
    """
    p_s, valve = state[P_S], par.valve
    u_t, u_l1, u_l2 = opened
    q_tp = port_flow(u_t, state[P_TP], p_s, p_tank, valve)
    q_tr = port_flow(-u_t, state[P_TR], p_s, p_tank, valve)
    q_lp = port_flow(u_l2, state[P_LP], p_s, p_tank, valve)
    q_lr = port_flow(u_l1, state[P_LR], p_s, p_tank, valve)
    drawn = q_tp if u_t > 0.0 else 0.0
    drawn += q_tr if u_t < 0.0 else 0.0
    drawn += q_lp if u_l2 > 0.0 else 0.0
    drawn += q_lr if u_l1 > 0.0 else 0.0
    returned = drawn - (q_tp + q_tr + q_lp + q_lr)
    q = ChamberFlows(q_tp, q_tr, q_lp, q_lr, drawn, returned, 1.0)
    return port_effects(PortFlows(q, opened, p_tank), state, par, par.effects, rates)


@inlined
def drawn_flow(state: np.ndarray, par: PlantParameters, rates: np.ndarray) -> float:
    """Return the flow [m^3/s] from the supply line into the chambers; ``rates`` is scratch."""
    opened = openings(state, par, par.effects, rates)
    tank = oil(state, par, par.effects, rates).tank_pa
    return valve_flows(state, opened, tank, par, rates).drawn


@inlined
def derivatives(
    state: np.ndarray,
    u: np.ndarray,
    levels: np.ndarray,
    par: PlantParameters,
    out: np.ndarray,
) -> None:
    """Write the time derivative of ``state`` under the commands ``u`` into ``out``."""
    _derivatives(state, u, forces(state, levels, par, out), par, out)


@inlined
def _derivatives(
    state: np.ndarray,
    u: np.ndarray,
    on_masses: MassForces,
    par: PlantParameters,
    out: np.ndarray,
) -> None:
    """Write all of ``derivatives`` that ``forces`` has not written into ``out``."""
    x, v = state[X], state[V]
    out[X] = v
    out[V] = on_masses.acceleration

    test, load = par.test, par.load
    v_tp, v_tr = extending_volumes(x, test)
    v_lp, v_lr = retracting_volumes(x, load)
    opened = openings(state, par, par.effects, out)
    fluid = oil(state, par, par.effects, out)
    q = valve_flows(state, opened, fluid.tank_pa, par, out)
    out[P_S], out[PUMP_COMMAND], out[PUMP_FLOW] = pump_rates(
        state[P_S], state[PUMP_COMMAND], state[PUMP_FLOW], q.drawn, par.supply
    )
    q = flow_effects(q, state, par, par.effects, out)
    out[P_TP] = pressure_rate(state[P_TP], v_tp, q.tp - test.area_piston_m2 * v, fluid.beta_tp)
    out[P_TR] = pressure_rate(state[P_TR], v_tr, q.tr + test.area_rod_m2 * v, fluid.beta_tr)
    out[P_LP] = pressure_rate(state[P_LP], v_lp, q.lp + load.area_piston_m2 * v, fluid.beta_lp)
    out[P_LR] = pressure_rate(state[P_LR], v_lr, q.lr - load.area_rod_m2 * v, fluid.beta_lr)

    for i in range(3):
        out[SPOOL_T + i] = state[RATE_T + i]
        out[RATE_T + i] = spool_acceleration(u[i], state[SPOOL_T + i], state[RATE_T + i], par.valve)


@inlined
def step(
    state: np.ndarray,
    u: np.ndarray,
    on_masses: MassForces,
    levels: np.ndarray,
    par: PlantParameters,
    dt: float,
    work: np.ndarray,
) -> None:
    """Advance ``state`` in place by ``dt`` [s]: Runge-Kutta of third order
    (Ralston's), in the law's number of substeps.

    ``on_masses`` is ``forces(state, levels, par, work[0])``, which the sensors need as well;
    ``work`` is from ``new_work``. Commands and levels are held.
    """
    k_1, k_2, k_3, trial = work[0], work[1], work[2], work[3]
    h = dt / par.substeps
    for substep in range(par.substeps):
        if substep > 0:
            on_masses = forces(state, levels, par, k_1)
        _derivatives(state, u, on_masses, par, k_1)
        for reach, before, k in ((0.5, k_1, k_2), (0.75, k_2, k_3)):
            for i in range(n_states(par)):
                trial[i] = state[i] + reach * h * before[i]
            derivatives(trial, u, levels, par, k)
        for i in range(n_states(par)):
            state[i] += h / 9.0 * (2.0 * k_1[i] + 3.0 * k_2[i] + 4.0 * k_3[i])
            if abs(state[i]) < _FADED:
                state[i] = 0.0
        hold_slipped(state, Z_T, par.test.friction)
        hold_slipped(state, Z_L, par.load.friction)


def initial_state(par: PlantParameters, x_m: float, p_lr_pa: float, p_lp_pa: float) -> np.ndarray:
    """Return the bench at rest in equilibrium: closed valves, relaxed bristles, F_T = F_L.

    Of the pressures with F_T = F_L these lie on the line that the symmetric valve keeps in steady
    motion, in the direction that the load opposes (r = A_r / A_p):

        extension   P_Tr - P_t = r^2 (P_s - P_Tp)        for F_L >= 0
        retraction  P_s - P_Tr = r^2 (P_Tp - P_t)        for F_L < 0

    With leaks it is no equilibrium: the pressures drift until a valve makes up for them.
    Raises ``ConfigError`` where the test cylinder can't carry the load.
    """
    a_p, a_r = par.test.area_piston_m2, par.test.area_rod_m2
    ratio = (a_r / a_p) ** 2
    f_load = p_lp_pa * par.load.area_piston_m2 - p_lr_pa * par.load.area_rod_m2
    p_supply, pump_flow = rest_flow(par.supply)
    p_tank = par.supply.tank_pa
    near, far = p_supply, p_tank  # of the piston side
    if f_load < 0.0:
        near, far = far, near
    p_tp = (f_load + a_r * (far + ratio * near)) / (a_p + a_r * ratio)
    p_tr = far + ratio * (near - p_tp)
    if not p_tank <= p_tp <= p_supply:
        raise ConfigError(
            f"a load of {f_load:.0f} N would need {p_tp / 1e5:.1f} bar on the test cylinder's "
            f"piston side; it has {p_tank / 1e5:g} to {p_supply / 1e5:g} bar"
        )
    state = np.zeros(n_states(par))
    state[X] = x_m
    state[[P_S, PUMP_COMMAND, PUMP_FLOW]] = p_supply, pump_flow, pump_flow
    state[[P_TP, P_TR, P_LP, P_LR]] = p_tp, p_tr, p_lp_pa, p_lr_pa
    return state
