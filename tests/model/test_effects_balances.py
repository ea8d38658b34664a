"""With all effects on together, oil and energy are still accounted for.

Flows and losses are written out here from the states alone, as in test_plant_balances.py.
"""

import numpy as np
import pytest
from scipy.integrate import simpson

from hbench.model.effects.catalogue import EFFECTS, with_effects
from hbench.model.plant import (
    P_LP,
    P_LR,
    P_S,
    P_TP,
    P_TR,
    TICK_S,
    Z_L,
    V,
    X,
    initial_state,
    n_states,
)
from hbench.model.simulation import simulate

BAR, K_S = 1e5, 7.43e-7 * np.sqrt(2 / 870)
A_P, A_R = np.pi / 4 * 0.04**2, np.pi / 4 * (0.04**2 - 0.025**2)
MASSES = 10 + 20 + 20  # those of the bench and the added ones
BETA, AIR, P_0 = 700 * BAR, 0.02, 1.013e5
LEAK = 3e-3 / 60e3 / BAR


def first_state(name):
    rows = list(EFFECTS.items())
    return Z_L + 1 + sum(row.states for key, row in rows[: [k for k, _ in rows].index(name)])


@pytest.fixture(scope="module")
def run(par, there_and_back):
    """All effects at their typical sizes."""
    values = {
        name: {key: one.to_si(one.typical or one.default) for key, one in row.coefficients.items()}
        for name, row in EFFECTS.items()
    }
    par = with_effects(par, values)
    start = initial_state(par, 0.15, 15 * BAR, 20 * BAR)
    assert len(start) == n_states(par)
    return simulate(par, start, there_and_back)


@pytest.fixture(scope="module")
def chambers(run):
    """For each chamber: pressure, volume, flow from its valve, all flow, and that of the supply.

    The valves' gains, nulls and curvature are in the openings that lag, play and overlap behind.
    """
    y = run.state
    x, supply, at = y[:, X], y[:, P_S], first_state("valve_lag")
    lagged, at = y[:, at : at + 3], first_state("valve_hysteresis")
    loose = lagged - np.clip(lagged - y[:, at : at + 3], -0.05, 0.05)
    dead = np.sign(loose) * np.maximum(np.abs(loose) - 0.05, 0)
    uneven = np.array([0.05, 0.05 + 0.05, 0.05 - 0.05])  # the load valves about their mean
    u_t, u_l1, u_l2 = (dead + uneven * np.abs(dead)).T
    tank = 2 * BAR + y[:, first_state("tank_back_pressure")]
    thin = np.exp(0.03 * y[:, first_state("oil_warming")])
    p = {name: y[:, place] for name, place in zip(
        ("tp", "tr", "lp", "lr"), (P_TP, P_TR, P_LP, P_LR), strict=True)}  # fmt: skip
    across = {"tp": p["tr"], "tr": p["tp"], "lp": p["lr"], "lr": p["lp"]}
    rows = {
        "tp": (251.2e-6 + A_P * x, u_t),
        "tr": (251.2e-6 + A_R * (0.4 - x), -u_t),
        "lp": (199.3e-6 + A_P * (0.38 - x), u_l2),
        "lr": (112.7e-6 + A_R * (x + 0.02), u_l1),
    }
    table = {}
    for name, (volume, opening) in rows.items():
        drop = np.where(opening > 0, supply - p[name], p[name] - tank)
        sharp = K_S * opening * np.sign(drop) * np.sqrt(np.abs(drop))
        port = np.abs(np.where(sharp > 0, supply - p[name], p[name] - tank))
        valve = sharp * (np.maximum(port, 1e3) / (50 * BAR)) ** 0.02
        side = {"tp": 0.05, "tr": -0.05}.get(name)
        if side is not None:  # the test valve's ports, and its inlets
            valve *= 1 + side + np.where(sharp > 0, 0.05, -0.05)
        lost = 0.02 * BAR * 60e3 * np.abs(valve) / (2 * np.maximum(port, 1e3))  # in a hose
        valve *= np.sqrt(1 + lost**2) - lost
        leaking = 0.005 + 0.005 / (1 + (opening / 0.3) ** 2)  # V, both edges
        inlet, outlet = (
            K_S * leaking * np.sign(each) * np.sqrt(np.abs(each))
            for each in (supply - p[name], p[name] - tank)
        )
        drawn = np.maximum(valve, 0) + inlet
        valve += inlet - outlet
        leak = LEAK * thin * (2 * p[name] - across[name])  # out of the chamber, both ways
        table[name] = (p[name], volume, valve, valve - leak, drawn)
    return table


def over_time(samples):
    return simpson(samples, dx=TICK_S)


def compliance(p):
    return 1 / BETA + AIR * P_0 / (P_0 + p) ** 2


def test_every_drop_of_oil_is_accounted_for(chambers):
    """Integral of valve flow and leaks = change of volume + compression of oil and air."""
    for p, volume, valve, flow, _ in chambers.values():
        gas = AIR * P_0 * (1 / (P_0 + p[:-1]) - 1 / (P_0 + p[1:]))
        compression = np.sum((np.diff(p) / BETA + gas) * (volume[:-1] + volume[1:]) / 2)
        stored = volume[-1] - volume[0] + compression
        moved = over_time(np.abs(valve))
        assert over_time(flow) == pytest.approx(stored, abs=2e-5 * moved)
        assert over_time(np.abs(valve - flow)) > 1e-3 * moved  # the leaks would be missed


def test_the_energy_that_enters_is_compressed_moved_or_rubbed(run, chambers):
    """Sum of P Q = compression + kinetic energy of all masses + friction."""
    y = run.state
    v = y[:, V]
    given = compressed = 0.0
    for p, volume, _, flow, _ in chambers.values():
        given += over_time(p * flow)
        compressed += np.sum(np.diff(p) * ((p * volume * compliance(p))[:-1]
                                           + (p * volume * compliance(p))[1:]) / 2)  # fmt: skip
    kinetic = MASSES / 2 * (v[-1] ** 2 - v[0] ** 2)
    rubbed = over_time((run.friction_test_n + run.friction_load_n) * v)
    throughput = sum(over_time(np.abs(p * flow)) for p, _, _, flow, _ in chambers.values())
    assert given == pytest.approx(compressed + kinetic + rubbed, abs=2e-5 * throughput)
    assert rubbed > 0.01 * throughput


def test_what_the_supply_gives_is_what_enters_the_chambers_through_their_ports(run, chambers):
    """Their exponent, inequality, hoses and closed edges included; a leak is behind them."""
    drawn = sum(drawn for *_, drawn in chambers.values())
    assert run.q_supply_m3_s == pytest.approx(drawn, abs=1e-6 * drawn.max())
