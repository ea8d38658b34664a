import numpy as np
import pytest

from hbench.model.valves import port_flow, signed_root, spool_acceleration

BAR = 1e5
P_S, P_T = 150 * BAR, 2 * BAR


@pytest.fixture(scope="module")
def valve(par):
    return par.valve


def slope(function, at, width):
    return (function(at + width) - function(at - width)) / (2 * width)


def test_flow_gain_is_that_of_the_source(valve):
    # K_T sqrt(2/rho) with the printed K_T = 7.43e-7, rho = 870 kg/m^3
    assert valve.flow_gain == pytest.approx(3.56348e-8, rel=5e-4)


def test_rated_flow_is_40_l_min_at_35_bar_an_edge(valve):
    flow = port_flow(10.0, P_S - 35 * BAR, P_S, P_T, valve)
    assert flow * 60e3 == pytest.approx(40.0, rel=5e-4)
    flow = port_flow(-10.0, P_T + 35 * BAR, P_S, P_T, valve)
    assert flow * 60e3 == pytest.approx(-40.0, rel=5e-4)


@pytest.mark.parametrize(
    ("u", "p_bar", "printed"),
    [
        (1.369, 8.886, 1.33863e-4),  # K_uLr
        (-2.814, 12.715, 3.68859e-5),  # K_uLp
        (0.661, 78.84, 9.506e-5),  # K_uTp
        (-0.661, 28.42, 5.793e-5),  # K_uTr: the rod side's port, whose opening is -u_T
    ],
)
def test_flow_per_volt_matches_the_reference(valve, u, p_bar, printed):
    gain = slope(lambda u: port_flow(u, p_bar * BAR, P_S, P_T, valve), u, 1e-4)
    assert gain == pytest.approx(printed, rel=5e-4)


@pytest.mark.parametrize(
    ("u", "p_bar", "derived"),
    [
        (0.661, 78.84, -4.415e-12),  # K_PTp
        (-0.661, 28.42, -7.245e-12),  # K_PTr = d(-Q)/dP
        (1.369, 8.886, -6.491e-12),  # K_PLr
        (-2.814, 12.715, -4.843e-11),  # K_PLp
    ],
)
def test_flow_per_pascal_matches_the_reference(valve, u, p_bar, derived):
    gain = slope(lambda p: port_flow(u, p, P_S, P_T, valve), p_bar * BAR, 10.0)
    assert gain == pytest.approx(derived, rel=1e-3)


def test_flow_turns_round_with_the_pressure_drop(valve):
    out = port_flow(1.0, P_S + 5 * BAR, P_S, P_T, valve)
    assert out == pytest.approx(-port_flow(1.0, P_S - 5 * BAR, P_S, P_T, valve), rel=1e-12)
    assert port_flow(-1.0, P_T - 1 * BAR, P_S, P_T, valve) > 0


def test_root_is_the_square_root_away_from_zero_and_straight_at_zero():
    assert signed_root(1e5) == pytest.approx(np.sqrt(1e5), rel=1e-4)
    assert signed_root(-1e5) == -signed_root(1e5)
    assert slope(signed_root, 0.0, 1.0) == pytest.approx(1 / np.sqrt(1e3), rel=1e-5)


def test_opening_ends_at_the_limit(valve):
    assert port_flow(12.0, P_T, P_S, P_T, valve) == port_flow(10.0, P_T, P_S, P_T, valve)


def test_spool_follows_the_critically_damped_step_response(valve):
    omega = 2 * np.pi * 90
    spool, rate, dt = 0.0, 0.0, 1e-6
    for _ in range(5000):
        rate += dt * spool_acceleration(3.0, spool, rate, valve)
        spool += dt * rate
    t = 5000 * dt
    assert spool == pytest.approx(3.0 * (1 - (1 + omega * t) * np.exp(-omega * t)), rel=1e-3)


def test_command_is_limited_to_10_v(valve):
    assert spool_acceleration(25.0, 0.0, 0.0, valve) == spool_acceleration(10.0, 0.0, 0.0, valve)
