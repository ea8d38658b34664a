"""The pump: equilibrium, sag with demand, what an accumulator does (sections 4.5 and 5)."""

import numpy as np
import pytest

from hbench.config.bench import parse_plant
from hbench.config.files.loading import read_yaml
from hbench.model.build import plant_parameters
from hbench.model.plant import P_S, P_TP, PUMP_FLOW, V, derivatives, initial_state
from hbench.model.simulation import simulate
from tests.support.pump import PUMP


@pytest.fixture(scope="module")
def pumped(bench_file):
    """Return parameters of the bench with the pump, some of whose keys may be changed."""

    def make(**changes):
        plant = parse_plant(
            read_yaml(bench_file), {"supply": {"pump": PUMP | changes}}, "pump.yaml"
        )
        return plant_parameters(plant)

    return make


def test_at_rest_the_pump_delivers_what_leaks(pumped):
    par = pumped()
    state = initial_state(par, 0.1, 15e5, 20e5)
    rates = np.empty_like(state)
    derivatives(state, np.zeros(3), np.ones(3), par, rates)
    # Q_max (152 bar - P) / 20 bar = G_l P
    pressure = 152e5 * 2.5e-10 / (2.5e-10 + 1.1e-12)
    assert state[P_S] == pytest.approx(pressure, rel=1e-9)
    assert state[PUMP_FLOW] == pytest.approx(1.1e-12 * pressure, rel=1e-9)
    assert np.abs(rates[[P_S, PUMP_FLOW]]).max() < 1e-3


def test_a_steady_demand_sags_the_pressure_along_the_compensators_line(pumped):
    """At 10 l/min drawn: P = 152 bar - 20 bar (Q + leakage) / 30 l/min, when it has settled."""
    from hbench.model.supply import pump_rates

    par = pumped().supply
    drawn, p, command, flow = 10e-3 / 60, 150e5, 0.0, 0.0
    for _ in range(600_000):
        rates = pump_rates(p, command, flow, drawn, par)
        p, command, flow = (
            value + 1e-4 * rate for value, rate in zip((p, command, flow), rates, strict=True)
        )
    expected = (152e5 - drawn / 2.5e-10) / (1 + 1.1e-12 / 2.5e-10)
    assert p == pytest.approx(expected, rel=1e-5)


def test_what_the_pump_cant_deliver_comes_out_of_the_line(pumped):
    """Oil is conserved: C_s (P_s - P_s0) is the pump's flow less what is drawn, leaks, relieves."""
    par = pumped()
    commands = np.repeat([[0.0, 0.0, 0.0], [6.0, 3.0, -3.0]], (100, 3000), axis=0)
    run = simulate(par, initial_state(par, 0.05, 15e5, 40e5), commands)
    p, flow, dt = run.state[:, P_S], run.state[:, PUMP_FLOW], 1e-4
    supply = par.supply
    net = flow - run.q_supply_m3_s - supply.leakage * p
    net -= supply.relief_gain * np.maximum(p - supply.relief_pa, 0.0)
    stored = supply.capacity * (p - p[0])
    came = np.concatenate([[0.0], np.cumsum(0.5 * dt * (net[1:] + net[:-1]))])
    assert np.ptp(stored) > 0.05 * 6e-12 * 150e5
    np.testing.assert_allclose(stored, came, atol=2e-3 * np.ptp(stored))
    assert p.min() < 135e5, "it must sag"


def test_an_accumulator_keeps_the_pressure_up(pumped):
    commands = np.repeat([[0.0, 0.0, 0.0], [4.0, 2.0, -2.0]], (100, 6000), axis=0)
    lowest = {}
    for capacity in ("0.6 cm^3/bar", "10 cm^3/bar"):  # 2 l of gas at 150 bar
        par = pumped(capacity=capacity)
        run = simulate(par, initial_state(par, 0.05, 15e5, 40e5), commands)
        lowest[capacity] = run.state[:, P_S].min()
        assert run.state[-1, V] > 0.1 and run.state[-1, P_TP] < run.state[-1, P_S]
    assert lowest["10 cm^3/bar"] > lowest["0.6 cm^3/bar"] + 5e5


def test_a_constant_supply_stays(par):
    run = simulate(par, initial_state(par, 0.1, 15e5, 20e5), np.full((500, 3), 2.0))
    assert set(run.state[:, P_S]) == {150e5}
