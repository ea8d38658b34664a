"""The sampled loops: against the continuous ones, against themselves and against the plant."""

import numpy as np
import pytest

from hbench.control import sampled
from hbench.control.jacobian import plant_state
from hbench.control.linearisation import linear_coefficients, state_space, steady_point
from hbench.control.sampled import L1, L2, T
from hbench.control.transfer import pi, rod_pressure_plant, valve
from hbench.model.plant import TICK_S
from hbench.studies.source_design import SOURCE_LOOPS
from hbench.studies.source_nonlinear import coulomb_viscous, run_loops


@pytest.fixture(scope="module")
def point(par):
    return steady_point(par, 0.17, 0.1, 3000.0, 15e5)


@pytest.fixture(scope="module")
def plant(par, point):
    return sampled.sample_plant(*state_space(linear_coefficients(par, point), par), 2e-3, 5e-4)


def test_all_digital_poles_lie_inside_the_unit_circle(plant):
    assert sampled.modulus(plant, SOURCE_LOOPS) < 1
    assert sampled.modulus(plant, [(8000.0, 0.06), *SOURCE_LOOPS[1:]]) > 1  # ten times the gain


def test_without_control_the_poles_are_those_of_the_continuous_bench(par, point, plant):
    """z = exp(s T), but for the way of the last tick, a pole at 0."""
    a, _ = state_space(linear_coefficients(par, point), par)
    found = np.sort(np.abs(np.linalg.eigvals(plant.f)))
    wanted = np.sort(np.append(np.abs(np.exp(np.linalg.eigvals(a) * TICK_S)), 0.0))
    assert found == pytest.approx(wanted, abs=1e-6)


@pytest.mark.parametrize("broken", [T, L1, L2])
def test_a_broken_loop_is_minus_1_at_every_closed_pole(plant, broken):
    """1 + L_i(z) = 0 at the closed loop's poles: two ways to the same poles."""
    poles = np.linalg.eigvals(sampled.closed_loop_matrices(plant, SOURCE_LOOPS)[0])
    swinging = poles[(poles.imag > 1e-3) & (np.abs(poles) > 0.9)]
    omega = np.log(swinging) / (1j * TICK_S)  # complex, so that exp(j omega T) is the pole
    assert len(swinging) >= 3
    opened = sampled.broken_loop(
        sampled.measurement_response(plant, omega), omega, SOURCE_LOOPS, broken
    )
    assert opened == pytest.approx(-1.0, abs=1e-5)


def test_far_above_the_piston_resonance_a_pressure_loop_is_its_chamber_alone(par, point):
    c = linear_coefficients(par, point)
    plant = sampled.sample_plant(*state_space(c, par), 0.0, 0.0)
    omega = np.array([200.0, 400.0, 800.0])
    response = sampled.measurement_response(plant, omega)
    spool = valve(par.valve.natural_frequency_rad_s, par.valve.damping)
    wanted = (rod_pressure_plant(c) * pi(*SOURCE_LOOPS[1]) * spool)(1j * omega)
    found = response[:, L1, L1] * sampled.controller(SOURCE_LOOPS[1], np.exp(1j * omega * TICK_S))
    assert abs(found[-1] / wanted[-1] - 1) < 0.12
    assert abs(found[-1] / wanted[-1] - 1) < abs(found[0] / wanted[0] - 1)


def test_the_references_are_reached(plant):
    for loop in (T, L1, L2):
        _, y = sampled.sampled_step(plant, SOURCE_LOOPS, loop, 3.0)
        assert y[-1] == pytest.approx(1.0, abs=2e-3)


def test_a_small_step_of_the_nonlinear_bench_is_the_linear_one(par):
    """D.18 on the compiled plant, without filters, against the sampled linear model."""
    bench = coulomb_viscous(par, 300.0, 2331.0)
    v, size, count = 0.1, 1e-3, 2000
    point = steady_point(bench, 0.17, v, 3000.0, 15e5)
    references = np.full((count, 3), (v + size, point.p_lr_pa, point.p_lp_pa))
    # The commands at rest stand in the sums: u = K_c (tau_c e + sum).
    gains = np.array(SOURCE_LOOPS)
    start = np.array([point.u_t_v, point.u_l1_v, point.u_l2_v]) / gains[:, 0]
    outputs = run_loops(bench, references, gains, plant_state(bench, point), start)
    plant = sampled.sample_plant(*state_space(linear_coefficients(bench, point), bench), 0.0, 0.0)
    _, y = sampled.sampled_step(plant, SOURCE_LOOPS, T, count * TICK_S)
    found = (outputs[:, 0] - v) / size
    assert y.max() > 1.1  # there is something to compare
    assert np.abs(found - y).max() < 0.03


def test_the_step_response_of_an_unstable_loop_ends_where_it_has_diverged(plant):
    gain, tau = SOURCE_LOOPS[L1]
    loops = [*SOURCE_LOOPS]
    loops[L1] = (1000 * gain, tau)
    assert sampled.modulus(plant, loops) > 1
    _, y = sampled.sampled_step(plant, loops, L1, 1.0)
    grown = np.flatnonzero(np.isfinite(y))[-1]
    assert np.abs(y[:grown]).max() > 1e6 and np.isnan(y[grown + 1 :]).all()
