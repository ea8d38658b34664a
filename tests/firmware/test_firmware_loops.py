"""The firmware's PI in closed loop with the reference's linear plants: bandwidth and overshoot.

Plants and printed figures: sections 4.1 to 4.4 of the source with the parameters that
reproduce them (bulk modulus 700 bar, operating point 0.17 m).
"""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.signal import cont2discrete, tf2ss

T = 1e-4
A_P, A_R = 1.25664e-3, 7.65763e-4
BETA = 7.0e7


def step_response(numerator, denominator, pi, size, seconds):
    """Normalised step response of PI and sampled plant, from zero."""
    a, b, c, _, _ = cont2discrete(tf2ss(numerator, denominator), T, "zoh")
    b, c = b[:, 0], c[0]
    state, y = np.zeros(len(b)), np.empty(round(seconds / T))
    for k in range(y.size):
        y[k] = c @ state
        u = pi(np.array([size - y[k]], np.float32))[0]
        state = a @ state + b * u
    return y / size


def bandwidth(y):
    """Frequency [rad/s] at which the closed loop's gain is -3 dB."""
    impulse, t = np.diff(y), T * np.arange(1, y.size)

    def gain(omega):
        return abs(np.sum(impulse * np.exp(-1j * omega * t)))

    return brentq(lambda omega: gain(omega) - gain(0.0) / np.sqrt(2), 5.0, 2000.0)


@pytest.fixture(scope="module")
def rod(probes):
    flow_gain, pole, stiffness = 1.33863e-4, 1.76, 2.7113e11
    pi = probes.pi(1.25e-5, 0.33, T, 1e9)
    return step_response([flow_gain * stiffness], [1, pole], pi, 1e5, 3.0)


@pytest.fixture(scope="module")
def piston(probes):
    flow_gain, pole, stiffness = 3.68859e-5, 7.32, 1.5114e11
    pi = probes.pi(6.5e-5, 0.25, T, 1e9)
    return step_response([flow_gain * stiffness], [1, pole], pi, 1e5, 3.0)


@pytest.fixture(scope="module")
def velocity_plant():
    """G_Tol of 4.29 to 4.35."""
    ku_p, ku_r, kp_p, kp_r = 9.506e-5, 5.793e-5, -4.415e-12, 7.245e-12
    m, b, x, stroke, dead = 10.0, 4662.0, 0.17, 0.4, 2.512e-4
    v_p, v_r = dead + A_P * x, dead + A_R * (stroke - x)
    mvv = m * v_p * v_r
    n_tc = BETA / mvv
    n_t0 = BETA * ku_p * kp_r * A_P - BETA * ku_r * kp_p * A_R
    n_t1 = ku_r * A_R * v_p + ku_p * A_P * v_r
    d_t0 = BETA**2 * (A_P**2 * kp_r - kp_r * kp_p * b - A_R**2 * kp_p) / mvv
    d_t1 = (
        BETA
        * (A_P**2 * v_r - kp_p * b * v_r - BETA * kp_p * m * kp_r + A_R**2 * v_p + v_p * b * kp_r)
        / mvv
    )
    d_t2 = (v_p * m * BETA * kp_r - BETA * kp_p * v_r * m + b * v_p * v_r) / mvv
    return [n_tc * n_t1, n_tc * n_t0], [1, d_t2, d_t1, d_t0]


@pytest.fixture(scope="module")
def velocity(velocity_plant, probes):
    pi = probes.pi(800.0, 0.06, T, 1e9)
    return step_response(*velocity_plant, pi, 0.01, 2.0)


def test_velocity_plant_has_the_printed_static_gain(velocity_plant):
    numerator, denominator = velocity_plant
    assert numerator[-1] / denominator[-1] == pytest.approx(0.07485, rel=2e-3)


@pytest.mark.parametrize(("loop", "printed"), [("rod", 151.0), ("piston", 87.0), ("velocity", 378)])
def test_closed_loop_has_the_printed_bandwidth(loop, printed, request):
    assert bandwidth(request.getfixturevalue(loop)) == pytest.approx(printed, rel=0.02)


def test_rod_side_pressure_overshoots_by_about_one_percent(rod):
    assert 0.0070 <= rod.max() - 1.0 <= 0.0095


def test_piston_side_pressure_does_not_overshoot(piston):
    assert piston.max() <= 1.0 + 1e-4


def test_velocity_settles_within_the_printed_time_without_overshoot(velocity):
    outside = np.flatnonzero(np.abs(velocity - 1.0) > 0.02)
    assert T * outside[-1] < 0.4
    assert velocity.max() <= 1.0 + 1e-3


@pytest.mark.parametrize("loop", ["rod", "piston", "velocity"])
def test_no_steady_state_error_remains(loop, request):
    assert request.getfixturevalue(loop)[-1] == pytest.approx(1.0, abs=1e-3)
