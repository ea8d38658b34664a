"""What no choice of numbers may break: oil is conserved, energy balances, steady motion is steady.

The flows and losses are written out here from the states alone.
"""

import numpy as np
import pytest
from scipy.integrate import simpson

from hbench.model.friction.laws import steady_friction
from hbench.model.plant import (
    P_LP,
    P_LR,
    P_TP,
    P_TR,
    SPOOL_L1,
    SPOOL_L2,
    SPOOL_T,
    TICK_S,
    Z_L,
    Z_T,
    V,
    X,
    derivatives,
    forces,
    initial_state,
    n_states,
    new_work,
)
from hbench.model.plant import P_S as SUPPLY
from hbench.model.simulation import simulate

BAR = 1e5
A_P, A_R = np.pi / 4 * 0.04**2, np.pi / 4 * (0.04**2 - 0.025**2)
P_S, P_T, BETA = 150 * BAR, 2 * BAR, 700 * BAR
K_S = 7.43e-7 * np.sqrt(2 / 870)
MASS, MASS_LOAD = 10.0, 5.0


@pytest.fixture(scope="module")
def run(par, there_and_back):
    return simulate(par, initial_state(par, 0.15, 15 * BAR, 20 * BAR), there_and_back)


@pytest.fixture(scope="module")
def chambers(run):
    """For each chamber: pressure, volume, inflow from supply, inflow from tank."""
    y = run.state
    x = y[:, X]
    rows = {
        "tp": (y[:, P_TP], 251.2e-6 + A_P * x, y[:, SPOOL_T]),
        "tr": (y[:, P_TR], 251.2e-6 + A_R * (0.4 - x), -y[:, SPOOL_T]),
        "lp": (y[:, P_LP], 199.3e-6 + A_P * (0.38 - x), y[:, SPOOL_L2]),
        "lr": (y[:, P_LR], 112.7e-6 + A_R * (x + 0.02), y[:, SPOOL_L1]),
    }
    table = {}
    for name, (p, volume, opening) in rows.items():
        supply = K_S * np.maximum(opening, 0) * np.sqrt(P_S - p)
        tank = K_S * np.minimum(opening, 0) * np.sqrt(p - P_T)
        table[name] = (p, volume, supply, tank)
    return table


def over_time(samples):
    """Integral over the run."""
    return simpson(samples, dx=TICK_S)


def test_every_drop_of_oil_is_accounted_for(chambers):
    """Integral of the flow = change of volume + compression, in each chamber."""
    for p, volume, supply, tank in chambers.values():
        compression = np.sum(np.diff(p) * (volume[:-1] + volume[1:]) / 2) / BETA
        stored = volume[-1] - volume[0] + compression
        moved = over_time(np.abs(supply) + np.abs(tank))
        assert over_time(supply + tank) == pytest.approx(stored, abs=2e-6 * moved)


def test_supplied_energy_is_compressed_moved_rubbed_or_throttled(run, chambers):
    """P_s Q_s - P_t Q_t = throttling + compression + kinetic energy + friction."""
    y = run.state
    v = y[:, V]
    given = throttled = compressed = 0.0
    for p, volume, supply, tank in chambers.values():
        given += over_time(P_S * supply + P_T * tank)
        throttled += over_time((P_S - p) * supply + (P_T - p) * tank)
        energy = volume * p**2 / (2 * BETA)
        swept = np.sum((p[:-1] ** 2 + p[1:] ** 2) / 2 * np.diff(volume)) / (2 * BETA)
        compressed += energy[-1] - energy[0] - swept
    kinetic = MASS / 2 * (v[-1] ** 2 - v[0] ** 2)
    rubbed = over_time((run.friction_test_n + run.friction_load_n) * v)
    assert rubbed > 0.01 * given  # else friction would hide in the tolerance
    assert given == pytest.approx(throttled + compressed + kinetic + rubbed, rel=1e-5)


def test_supply_flow_is_what_the_chambers_draw(run, chambers):
    drawn = sum(supply for _, _, supply, _ in chambers.values())
    assert run.q_supply_m3_s == pytest.approx(drawn, abs=1e-6 * drawn.max())


def test_load_cell_separates_the_masses(run):
    """F_applied from the test side, F_T - F_fT - m_T a, is what the load side gives."""
    y = run.state
    f_test = y[:, P_TP] * A_P - y[:, P_TR] * A_R
    acceleration = np.gradient(y[:, V], TICK_S, edge_order=2)
    applied = f_test - run.friction_test_n - (MASS - MASS_LOAD) * acceleration
    smooth = np.abs(np.gradient(np.gradient(acceleration))) < 1e-3
    assert smooth.mean() > 0.9
    assert run.f_applied_n[smooth] == pytest.approx(applied[smooth], abs=0.05)


@pytest.mark.parametrize(
    ("v", "p_lr", "p_lp"), [(0.05, 15 * BAR, 20 * BAR), (-0.12, 110 * BAR, 50 * BAR)]
)
def test_nothing_changes_in_the_closed_form_steady_state(par, v, p_lr, p_lp):
    """Constant speed: flows fill the swept volumes, forces balance.

    The symmetric valve then ties the test pressures: equal openings pass A_p v and A_r v, so
    their pressure drops stand as (A_p / A_r)^2.
    """
    level = np.ones(2)
    p_tp, p_tr, friction_t = 50 * BAR, 50 * BAR, 0.0
    friction_l = steady_friction(v, p_lp, p_lr, par.load.friction)
    f_load = p_lp * A_P - p_lr * A_R
    r2 = (A_R / A_P) ** 2
    for _ in range(50):  # the seals make friction depend on the pressures sought
        force = f_load + friction_l + friction_t
        if v > 0:  # (P_Tr - P_t) = r2 (P_s - P_Tp)
            p_tp = (force + A_R * (P_T + r2 * P_S)) / (A_P + A_R * r2)
            p_tr = P_T + r2 * (P_S - p_tp)
        else:  # (P_s - P_Tr) = r2 (P_Tp - P_t)
            p_tp = (force + A_R * (P_S + r2 * P_T)) / (A_P + A_R * r2)
            p_tr = P_S - r2 * (p_tp - P_T)
        friction_t = steady_friction(v, p_tp, p_tr, par.test.friction)

    def opening(flow, p):
        return flow / (K_S * np.sqrt(P_S - p if flow > 0 else p - P_T))

    state, rate = np.zeros(n_states(par)), np.empty(n_states(par))
    state[[X, V, P_TP, P_TR, P_LP, P_LR]] = 0.2, v, p_tp, p_tr, p_lp, p_lr
    state[SUPPLY] = P_S
    u = np.array([opening(A_P * v, p_tp), opening(A_R * v, p_lr), opening(-A_P * v, p_lp)])
    state[[SPOOL_T, SPOOL_L1, SPOOL_L2]] = u
    for index, force, friction in (
        (Z_T, friction_t, par.test.friction),
        (Z_L, friction_l, par.load.friction),
    ):
        state[index] = (force - friction.viscous * v) / friction.bristle_stiffness
    derivatives(state, u, level, par, rate)
    assert rate[X] == v
    assert np.abs(rate[V]) < 1e-6
    # a volt of the spool changes a pressure by some 1e7 Pa/s
    assert np.abs(rate[[P_TP, P_TR, P_LP, P_LR]]).max() < 20.0
    assert np.abs(rate[[Z_T, Z_L]]).max() < 1e-12
    assert forces(state, level, par, new_work(par)[3]).applied == pytest.approx(
        f_load + friction_l, rel=1e-9
    )
