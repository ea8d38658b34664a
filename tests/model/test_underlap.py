"""A spool with underlap leaves both edges of a port open: it opens early and leaks at null.

The clearance of a spool leaks at both edges too, however far it is open, and most at null.

The expected flows are those of a bridge of two orifices at each port (Eryilmaz and Wilson, Unified
modelling of servo valves, 2006): x open on one side, w + x and w^2 / (w + x).
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hbench.model.effects.catalogue import with_effects
from hbench.model.effects.couplings import Openings
from hbench.model.effects.openings import overlapped
from hbench.model.plant import P_LR, P_S, P_TP, initial_state, n_states, valve_flows
from hbench.model.simulation import simulate

BAR = 1e5
WIDTH_V = 0.1


@pytest.fixture(scope="module")
def underlapped(par):
    widths = {"test": -WIDTH_V, "load": -WIDTH_V}
    return with_effects(par, {"valve_deadband": widths})


@pytest.fixture(scope="module")
def start(par):
    return initial_state(par, 0.15, 15 * BAR, 20 * BAR)


def test_an_underlap_opens_further_and_has_twice_the_slope_in_the_middle():
    """Far from the middle the opening is larger by the underlap; the law is odd and has no jump."""
    assert overlapped(1e-6, -0.03, 0.0) == pytest.approx(2e-6, rel=1e-3)
    assert overlapped(5.0, -0.03, 0.0) == pytest.approx(5.03, abs=3e-4)
    assert overlapped(-5.0, -0.03, 0.0) == -overlapped(5.0, -0.03, 0.0)
    assert overlapped(0.0, -0.03, 0.0) == 0.0
    for u in (0.5, 5.0):  # both sides of zero overlap have the same slope by the width
        wider, narrower = (overlapped(u, width, 0.0) for width in (1e-6, -1e-6))
        assert u - wider == pytest.approx(narrower - u, rel=1e-4)


@pytest.mark.parametrize("u", [-2.0, -0.15, 0.0, 0.02, 0.6])
def test_flows_are_those_of_a_bridge_of_two_orifices_at_each_port(underlapped, start, u):
    """The test valve drives its two ports in opposite directions, load valves one port each."""
    p_s, p_t, gain = start[P_S], underlapped.supply.tank_pa, underlapped.valve.flow_gain

    def bridge(x, p):
        wide, narrow = WIDTH_V + abs(x), WIDTH_V**2 / (WIDTH_V + abs(x))
        to_supply, to_tank = (wide, narrow) if x > 0 else (narrow, wide)
        return gain * to_supply * np.sqrt(p_s - p), gain * to_tank * np.sqrt(p - p_t)

    spools = (u, -u, -0.5 * u, 0.3 * u)  # at the ports Tp, Tr, Lp, Lr
    opened = Openings(*(overlapped(spools[i], -WIDTH_V, 0.0) for i in (0, 3, 2)))
    ports = [bridge(x, p) for x, p in zip(spools, start[P_TP : P_LR + 1], strict=True)]
    q = valve_flows(start, opened, p_t, underlapped, np.zeros(n_states(underlapped)))
    assert q[:4] == pytest.approx([drawn - returned for drawn, returned in ports], rel=1e-6)
    assert q.drawn == pytest.approx(sum(drawn for drawn, _ in ports), rel=1e-6)
    assert q.returned == pytest.approx(sum(returned for _, returned in ports), rel=1e-6)


@pytest.mark.parametrize("leaks", [{"leak": 0.05}, {"null_leak": 0.05}])
@pytest.mark.parametrize("u", [-1.0, 0.0, 0.02, 0.3])
def test_the_clearance_of_a_spool_leaks_beside_the_flow_of_the_open_edge(par, start, u, leaks):
    p_s, p_t = start[P_S], par.supply.tank_pa
    spools = np.array([u, u, 0.3 * u, -0.5 * u])  # at the ports Tp, Tr, Lp, Lr
    closing = 1 + (spools / 0.3) ** 2 if "null_leak" in leaks else 1.0
    gain = 0.05 * par.valve.flow_gain / closing
    opened, none = Openings(u, -0.5 * u, 0.3 * u), np.zeros(n_states(par))
    without = valve_flows(start, opened, p_t, par, none)
    found = valve_flows(start, opened, p_t, with_effects(par, {"valve_trim": leaks}), none)
    ports = start[P_TP : P_LR + 1]
    drawn, returned = gain * np.sqrt(p_s - ports), gain * np.sqrt(ports - p_t)
    assert np.subtract(found[:4], without[:4]) == pytest.approx(drawn - returned, rel=1e-6)
    assert found.drawn - without.drawn == pytest.approx(drawn.sum(), rel=1e-6)
    assert found.returned - without.returned == pytest.approx(returned.sum(), rel=1e-6)


def test_closed_valves_bring_blocked_chambers_to_half_the_supply_pressure(underlapped, start):
    """The pistons can't move; the decay is that of another solver."""
    fixed = underlapped._replace(mass_test_kg=1e15)
    p_s, p_t, gain = start[P_S], fixed.supply.tank_pa, fixed.valve.flow_gain
    state = np.zeros(n_states(fixed))
    state[: len(start)] = start
    held = simulate(fixed, state, np.zeros((150_000, 3)))
    volume = 251.2e-6 + np.pi / 4 * 0.04**2 * 0.15  # of Tp at 150 mm

    def rate(_, p):
        leak = gain * WIDTH_V * (np.sqrt(p_s - p) - np.sqrt(p - p_t))
        return 700 * BAR / volume * leak

    own = solve_ivp(rate, (0, held.t_s[-1]), [start[P_TP]], t_eval=held.t_s, rtol=1e-9)
    assert held.state[:, P_TP] == pytest.approx(own.y[0], rel=1e-5)
    assert held.state[-1, P_TP : P_LR + 1] == pytest.approx((p_s + p_t) / 2, rel=0.05)
    through = 4 * gain * WIDTH_V * np.sqrt((p_s - p_t) / 2)
    assert held.q_supply_m3_s[-1] == pytest.approx(through, rel=0.02)
