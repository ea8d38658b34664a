"""Eigenvalues with the friction law in: against closed forms, and against a simulated growth."""

import numpy as np
import pytest

from hbench.control.linearisation import steady_point
from hbench.control.stability import (
    friction_slope,
    linearised_plant,
    loop_eigenvalues,
    plant_eigenvalues,
)
from hbench.model import plant as p
from hbench.model.simulation import simulate
from hbench.studies.instability import FITS, with_fit


@pytest.fixture(scope="module")
def at_speed(par):
    def make(fit, law, v):
        changed = with_fit(par, FITS[fit], law)
        return changed, steady_point(changed, 0.17, v, 5000.0, 15e5)

    return make


@pytest.mark.parametrize("fit,printed", [("6.2 steady", 239.0), ("6.5 steady", 107.0)])
def test_a_falling_static_law_drives_the_mass_on_its_oil_spring(at_speed, par, fit, printed):
    """Re = -F' / (2 m), F' = B - (F_s - F_C) / v_s exp(-v / v_s) in each cylinder."""
    changed, point = at_speed(fit, "tustin", 0.05)
    f_c, f_s, v_s, b = FITS[fit]
    slope = 2 * (b - (f_s - f_c) / v_s * np.exp(-0.05 / v_s))
    assert friction_slope(changed, point) == pytest.approx(slope, rel=1e-5)
    found = plant_eigenvalues(changed, point).real.max()
    assert found == pytest.approx(-slope / 20.0, rel=0.01)
    assert found == pytest.approx(printed, abs=1.0)


def test_a_small_disturbance_grows_as_the_eigenvalue_says(at_speed):
    """The nonlinear plant under held commands, for 25 ms."""
    changed, point = at_speed("6.5 steady", "tustin", 0.05)
    a, _, states = linearised_plant(changed, point)
    values, vectors = np.linalg.eig(a)
    fastest = values.real.argmax()
    state = np.zeros(p.n_states(changed))
    from hbench.control.jacobian import plant_state

    state[:] = plant_state(changed, point)
    direction = np.real(vectors[:, fastest])
    u = np.tile([point.u_t_v, point.u_l1_v, point.u_l2_v], (250, 1))
    disturbed = state.copy()
    disturbed[states] += 1e-6 * direction / abs(direction[0])
    off = simulate(changed, disturbed, u).state - simulate(changed, state, u).state
    t = 1e-4 * np.arange(251)
    weights = np.linalg.inv(vectors)[fastest]
    mode = np.abs(off[:, states] @ weights)
    assert np.polyfit(t, np.log(mode), 1)[0] == pytest.approx(values[fastest].real, rel=0.03)


def test_lugres_falling_part_is_a_lag_of_the_static_slope(at_speed):
    """Its eigenvalues are roots of det(sI - A_viscous with F'/(1 + s tau)) = 0."""
    changed, point = at_speed("6.5 steady", "lugre", 0.05)
    f_c, f_s, v_s, b = FITS["6.5 steady"]
    fallen = (f_s - f_c) * np.exp(-0.05 / v_s)
    tau = (f_c + fallen) / (1e5 * 0.05)
    static, _ = at_speed("6.5 steady", "tustin", 0.05)
    a, _, _ = linearised_plant(static, point)
    rest = a.copy()
    rest[0, 0] += 2 * (b - fallen / v_s) / 10.0  # without friction
    for s in plant_eigenvalues(changed, point):
        lagged = rest.astype(complex)
        lagged[0, 0] -= 2 * (b - fallen / v_s / (1 + s * tau)) / 10.0
        smallest = np.linalg.svd(s * np.eye(len(a)) - lagged)[1].min()
        moved = np.linalg.svd((s + 5.0) * np.eye(len(a)) - lagged)[1].min()
        assert smallest < 2e-3 * moved or abs(1 + s * tau) < 1e-4


def test_closed_loops_keep_the_references_and_open_ones_do_not(at_speed, bench):
    """The PI's three integrators are there: with the gains at zero they are eigenvalues at 0."""
    changed, point = at_speed("6.5 steady", "lugre", 0.05)
    open_ = loop_eigenvalues(changed, point, [(1e-20, 1.0)] * 3)
    assert (np.abs(open_) < 1e-6).sum() == 3
    control = bench.controllers
    loops = [
        (loop.gain, loop.time_constant)
        for loop in (control.velocity, control.rod_pressure, control.piston_pressure)
    ]
    assert loop_eigenvalues(changed, point, loops).real.max() < -0.5
