import numpy as np
import pytest

from hbench.model.cylinders import (
    end_stop_force,
    extending_volumes,
    pressure_force,
    pressure_rate,
    retracting_volumes,
)
from hbench.model.plant import P_LP, P_LR, P_TP, P_TR, Z_T, V, X, initial_state
from hbench.model.simulation import simulate

BAR = 1e5


def test_areas_are_those_of_the_source(par):
    assert par.test.area_piston_m2 == pytest.approx(1.25664e-3, rel=1e-5)
    assert par.test.area_rod_m2 == pytest.approx(7.65763e-4, rel=1e-5)


def test_volumes_at_the_operating_point_match_the_reference(par):
    # beta / V of the load cylinder at x = 0.17 m, x_0 = 0.02 m
    v_lp, v_lr = retracting_volumes(0.17, par.load)
    assert par.bulk_modulus_pa / v_lp == pytest.approx(1.5114e11, rel=1e-3)
    assert par.bulk_modulus_pa / v_lr == pytest.approx(2.7113e11, rel=1e-3)
    v_tp, v_tr = extending_volumes(0.17, par.test)
    assert (v_tp, v_tr) == pytest.approx(
        (2.512e-4 + 1.25664e-3 * 0.17, 2.512e-4 + 7.65763e-4 * 0.23), rel=1e-5
    )


def test_extension_fills_the_piston_side_of_the_test_cylinder_and_empties_the_load_s(par):
    test = np.subtract(extending_volumes(0.2, par.test), extending_volumes(0.1, par.test))
    load = np.subtract(retracting_volumes(0.2, par.load), retracting_volumes(0.1, par.load))
    a_p, a_r = 1.25664e-3, 7.65763e-4
    assert test == pytest.approx([0.1 * a_p, -0.1 * a_r], rel=1e-5)
    assert load == pytest.approx([-0.1 * a_p, 0.1 * a_r], rel=1e-5)


def test_load_of_the_source_s_example(par):
    # 10 kN with 15 bar on the rod side needs 88.718 bar on the piston side
    assert pressure_force(88.718 * BAR, 15 * BAR, par.load) == pytest.approx(10e3, rel=1e-4)


def test_a_torn_chamber_tends_to_zero_pressure_and_recovers():
    volume, beta, dt = 2e-4, 7e8, 1e-5
    p = 5 * BAR
    for _ in range(5000):
        p += dt * pressure_rate(p, volume, -1e-4, beta)
        assert p > 0
    assert p < 100.0
    assert pressure_rate(p, volume, 1e-4, beta) == pytest.approx(beta / volume * 1e-4)
    assert pressure_rate(-10.0, volume, -1e-4, beta) == 0.0


def test_heads_push_only_away_and_only_in_contact(par):
    stop = par.end_stop
    assert end_stop_force(0.2, 1.0, par.test, stop) == 0.0
    assert end_stop_force(-1e-4, 0.0, par.test, stop) == pytest.approx(stop.stiffness_n_m * 1e-4)
    assert end_stop_force(0.4001, 0.0, par.test, stop) == pytest.approx(-stop.stiffness_n_m * 1e-4)
    # leaving fast: the damper alone would pull
    assert end_stop_force(-1e-4, 1.0, par.test, stop) == 0.0
    assert end_stop_force(0.4001, -1.0, par.test, stop) == 0.0


def test_heads_hold_the_piston_against_full_pressure(par):
    """Driven hard out: the load cylinder's head is met first, 20 mm before the test cylinder's."""
    state = initial_state(par, 0.35, 15 * BAR, 20 * BAR)
    run = simulate(par, state, np.tile([10.0, 10.0, -10.0], (10_000, 1)))
    end = run.state[-1]
    assert end[[P_TP, P_TR, P_LP, P_LR]] / BAR == pytest.approx([150, 2, 2, 150], abs=1e-3)
    bristles = run.friction_test_n[-1] + run.friction_load_n[-1]
    push = (150 - 2) * BAR * (1.25664e-3 + 7.65763e-4) - bristles
    assert end[X] - 0.38 == pytest.approx(push / par.end_stop.stiffness_n_m, rel=1e-4)
    assert np.abs(run.state[-1000:, V]).max() < 1e-9  # no chatter at the head
    # the head takes the load's share: the cell carries what the test side gives
    f_test = (150 * 1.25664e-3 - 2 * 7.65763e-4) * BAR
    assert run.f_applied_n[-1] == pytest.approx(
        f_test - par.test.friction.bristle_stiffness * end[Z_T], rel=1e-4
    )


def test_inner_head_holds_the_piston(par):
    state = initial_state(par, 0.03, 110 * BAR, 50 * BAR)
    run = simulate(par, state, np.tile([-10.0, -10.0, 10.0], (10_000, 1)))
    assert -2e-3 < run.state[-1, X] < 0
    assert run.state[:, X].min() > -3e-3
    assert np.abs(run.state[-1000:, V]).max() < 1e-9
