"""The linearisation by hand against the compiled plant."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.control.grid import operating_point
from hbench.control.jacobian import disagreement, plant_state
from hbench.control.linearisation import linear_coefficients, state_space, steady_point
from hbench.errors import ConfigError
from hbench.model import plant
from hbench.model.build import plant_parameters
from hbench.model.friction.laws import steady_parts

POINTS = [
    (0.17, 0.05, 5000.0, 15e5),
    (0.01, -0.05, -2000.0, 110e5),
    (0.37, 0.2, 500.0, 15e5),
    (0.20, -0.2, 3000.0, 40e5),  # a load that helps
]


@pytest.mark.parametrize("at", POINTS)
def test_a_steady_point_is_an_equilibrium_of_the_plant(par, at):
    point = steady_point(par, *at)
    state = plant_state(par, point)
    rates = np.zeros(len(state))
    pairs = (par.test, point.p_tp_pa, point.p_tr_pa), (par.load, point.p_lp_pa, point.p_lr_pa)
    for place, (cylinder, p_p, p_r) in zip((plant.Z_T, plant.Z_L), pairs, strict=True):
        dry, _ = steady_parts(point.v_m_s, p_p, p_r, 1.0, cylinder.friction)
        state[place] = dry / cylinder.friction.bristle_stiffness  # LuGre in steady sliding
    u = np.array([point.u_t_v, point.u_l1_v, point.u_l2_v])
    plant.derivatives(state, u, np.ones(2), par, rates)
    assert rates[plant.X] == point.v_m_s
    assert abs(rates[plant.V]) < 1e-6
    assert np.abs(rates[plant.P_TP : plant.P_LR + 1]).max() < 20.0  # Pa/s; the orifice's rounding


@pytest.mark.parametrize("at", POINTS)
def test_both_linearisations_agree(par, at):
    point = steady_point(par, *at)
    assert disagreement(par, point, linear_coefficients(par, point)) < 1e-6


def test_both_linearisations_agree_on_another_bench_with_another_law(make_bench):
    tustin = {"law": "tustin", "coulomb": "300 N", "stiction": "400 N"}
    tustin |= {"stribeck_velocity": "50 mm/s", "viscous": "3000 N s/m"}
    bench = make_bench(
        test_cylinder={"piston_diameter": "63 mm", "rod_diameter": "45 mm"},
        moving_mass={"test": "12 kg"},
        oil={"bulk_modulus": "3000 bar"},
        valve={"bandwidth": "60 Hz", "damping": 0.7},
        friction={"test": tustin, "load": tustin},
    )
    par = plant_parameters(bench)
    point = operating_point(bench, par, {"v_m_s": 0.08})
    assert disagreement(par, point, linear_coefficients(par, point)) < 1e-6


def test_viscous_friction_is_that_of_the_law_at_high_speed(make_bench):
    lines = {"low_force": "400 N", "low_slope": "-900 N s/m", "high_force": "200 N"}
    law = {
        "law": "marton_lantos",
        "extend": lines | {"high_slope": "2500 N s/m"},
        "retract": lines | {"high_slope": "1500 N s/m"},
    }
    bench = make_bench(friction={"test": law, "load": {"viscous": "3000 N s/m"}})
    par = plant_parameters(bench)
    for v, viscous in ((0.05, 5500.0), (-0.05, 4500.0)):
        assert operating_point(bench, par, {"v_m_s": v}).viscous_n_s_m == pytest.approx(viscous)


def test_a_wrong_coefficient_shows_in_the_disagreement(par):
    point = steady_point(par, *POINTS[0])
    right = linear_coefficients(par, point)
    for name in ("kp_tr", "ku_lp", "v_tp", "viscous"):
        wrong = replace(right, **{name: 1.01 * getattr(right, name)})
        assert disagreement(par, point, wrong) > 5e-3


def test_flow_follows_pressure_and_voltage_as_the_signs_say(source):
    """From the supply flow falls with the chamber's pressure, to the tank it grows."""
    assert source.kp_tp < 0 < source.kp_tr and source.kp_lr < 0 and source.kp_lp < 0
    assert min(source.ku_tp, source.ku_tr, source.ku_lp, source.ku_lr) > 0


def test_without_viscous_friction_and_leakage_the_bench_swings_freely(par):
    """At no flow the four chambers are springs: omega^2 = beta/m sum(A^2/V), undamped."""
    point = steady_point(par, 0.17, 1e-9, 3000.0, 15e5)
    c = linear_coefficients(par, point)
    a, _ = state_space(c, par)
    a = a[:5, :5].copy()
    a[0, 0] = 0.0
    springs = c.a_tp**2 / c.v_tp + c.a_tr**2 / c.v_tr + c.a_lp**2 / c.v_lp + c.a_lr**2 / c.v_lr
    omega = np.sqrt(c.beta / c.mass * springs)
    roots = np.linalg.eigvals(a)
    fast = roots[np.abs(roots) > 1.0]
    assert np.abs(fast) == pytest.approx([omega] * 2, rel=1e-6)
    assert np.abs(fast.real).max() < 1e-3
    assert omega == pytest.approx(270, rel=0.01)  # as computed for the reference bench


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"f_load_n": 2e4}, r"load cylinder .* bar"),
        ({"f_load_n": 1.9e4, "p_lr_pa": 1e6}, r"load cylinder .* bar"),
        ({"v_m_s": 1.5}, r"valve .* V"),
        ({"v_m_s": 0.0}, r"valve .*rest"),
        ({"x_m": 0.5}, r"limits\.travel"),
        ({"f_load_n": 1.83e4, "p_lr_pa": 5e5}, r"balance"),
    ],
)
def test_a_point_that_the_bench_can_not_hold_is_refused(bench, par, given, words):
    with pytest.raises(ConfigError, match=words):
        operating_point(bench, par, given)
