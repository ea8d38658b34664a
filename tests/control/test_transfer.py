"""Transfer functions against the state space, and what integral action means."""

import numpy as np
import pytest
from scipy import signal

from hbench.control.linearisation import P_LP, P_LR, P_TR, SPOOL_L1, SPOOL_L2, SPOOL_T, state_space
from hbench.control.loops import backward_euler, loop_plants, root_locus
from hbench.control.merits import ramp_error, step_response, velocity_constant
from hbench.control.transfer import pi, valve
from hbench.studies.source_design import SOURCE_LOOPS

S = 1j * np.geomspace(0.1, 1e4, 50)


def response(par, c, states, spool, output):
    """C (s - A)^-1 B of some states alone, the spool as input."""
    a, _ = state_space(c, par)
    inner, inputs = a[np.ix_(states, states)], a[states, spool]
    return np.array([np.linalg.solve(s * np.eye(len(states)) - inner, inputs)[output] for s in S])


def test_velocity_plant_is_the_test_cylinder_with_a_constant_load(par, source):
    found = response(par, source, list(range(P_TR + 1)), SPOOL_T, 0)
    assert loop_plants(source)[0](S) == pytest.approx(found, rel=1e-9)


@pytest.mark.parametrize(("loop", "pressure", "spool"), [(1, P_LR, SPOOL_L1), (2, P_LP, SPOOL_L2)])
def test_pressure_plants_are_a_chamber_at_constant_velocity(par, source, loop, pressure, spool):
    assert loop_plants(source)[loop](S) == pytest.approx(
        response(par, source, [pressure], spool, 0), rel=1e-9
    )


def test_static_gain_of_the_velocity_plant(source):
    """1/K_v of table 4.1's gain and the printed ramp error: 0.1 / 1.67e-3 / 800."""
    assert loop_plants(source)[0](0.0) == pytest.approx(0.1 / 1.67e-3 / 800, rel=1e-3)


@pytest.mark.parametrize("loop", range(3))
def test_plants_are_of_type_0_and_with_their_pi_of_type_1(source, loop):
    plant = loop_plants(source)[loop]
    assert velocity_constant(plant) == 0.0 and ramp_error(plant, 1.0) == np.inf
    opened = plant * pi(*SOURCE_LOOPS[loop])
    assert velocity_constant(opened) == pytest.approx(SOURCE_LOOPS[loop][0] * plant(0.0))


@pytest.mark.parametrize("loop", range(3))
@pytest.mark.parametrize("with_valve", [False, True])
def test_a_closed_loop_has_the_static_gain_1(par, source, loop, with_valve):
    opened = loop_plants(source)[loop] * pi(*SOURCE_LOOPS[loop])
    if with_valve:
        opened = opened * valve(par.valve.natural_frequency_rad_s, par.valve.damping)
    assert opened.closed(0.0) == pytest.approx(1.0, abs=1e-12)
    assert step_response(opened.closed, np.arange(0, 5, 1e-3))[-1] == pytest.approx(1.0, abs=1e-4)


def test_the_ramp_error_is_what_a_ramp_leaves(source):
    opened = loop_plants(source)[0] * pi(*SOURCE_LOOPS[0])
    t = np.linspace(0, 3, 30001)
    _, y, _ = signal.lsim((opened.closed.numerator, opened.closed.denominator), 0.1 * t, t)
    assert (0.1 * t - y)[-1] == pytest.approx(ramp_error(opened, 0.1), rel=1e-3)


def test_the_valve_is_6_db_down_at_its_corner_when_critically_damped():
    spool = valve(2 * np.pi * 90, 1.0)
    assert abs(spool(2j * np.pi * 90)) == pytest.approx(0.5)
    assert np.angle(spool(2j * np.pi * 90), deg=True) == pytest.approx(-90)


def test_a_root_locus_starts_at_the_open_poles_and_holds_the_design(source):
    opened = loop_plants(source)[1] * pi(*SOURCE_LOOPS[1])
    found = root_locus(opened)
    design = found.poles_rad_s[found.gain_factor == 1.0][0]
    assert np.sort_complex(design) == pytest.approx(np.sort_complex(opened.closed.poles))
    for factor, poles in zip(found.gain_factor, found.poles_rad_s, strict=True):
        assert factor * opened(poles) == pytest.approx(-1.0, rel=1e-6)


def test_backward_euler_keeps_a_stable_pole_inside_the_unit_circle(source):
    closed = (loop_plants(source)[0] * pi(*SOURCE_LOOPS[0])).closed
    z = backward_euler(closed.poles)
    assert np.abs(z).max() < 1
    # s = (z - 1) / (T z) must lead back to the roots of the polynomial.
    assert closed.denominator[0] == 1.0
    assert np.polyval(closed.denominator, (z - 1) / (1e-4 * z)) / closed.denominator[
        -1
    ] == pytest.approx(0.0, abs=1e-9)
