"""LuGre and Leuven: steady states, the limit in which they meet, memory, passivity."""

import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hbench.model.friction.laws import LAWS, friction, hold_slipped, steady_friction
from hbench.model.parameters import FrictionParameters

P_P, P_R = 50e5, 10e5
LEUVEN = FrictionParameters(
    law=LAWS["leuven"].code,
    coulomb=300.0,
    stiction=500.0,
    stribeck_velocity=0.06,
    viscous=1500.0,
    piston_seal=1.2e-5,
    rod_seal=0.8e-5,
    presliding=1e-3,
    shape=1.0,
    elements=(150.0, 150.0, 150.0, 150.0, 150.0),
)
LUGRE = LEUVEN._replace(law=LAWS["lugre"].code, bristle_stiffness=3e5, elements=(0.0,))


def travel(par, path_m, dt=1e-5):
    """Move along positions, dt apart; return friction at each step and the last states."""
    state = np.zeros(len(par.elements) * 2)
    return follow(np.diff(path_m) / dt, dt, par, state), state


@numba.njit
def follow(speeds, dt, par, state):
    """Return friction at each step, by the midpoint rule; ``state`` goes along."""
    rates, force = np.zeros_like(state), np.empty(len(speeds))
    for k, v in enumerate(speeds):
        friction(v, state, 0, P_P, P_R, 1.0, par, rates)
        middle = state + 0.5 * dt * rates
        force[k] = friction(v, middle, 0, P_P, P_R, 1.0, par, rates)
        state += dt * rates
        hold_slipped(state, 0, par)
    return force


def to_and_fro(*turns_m, speed=1e-3, dt=1e-5):
    """Positions along straight ways between turning points."""
    ways = [
        np.linspace(a, b, max(2, round(abs(b - a) / speed / dt)), endpoint=False)
        for a, b in zip(turns_m[:-1], turns_m[1:], strict=True)
    ]
    return np.concatenate([*ways, turns_m[-1:]])


@pytest.mark.parametrize("v", [-0.15, -0.01, 0.01, 0.15])
@pytest.mark.parametrize("shape", [0.7, 1.0, 2.0])
def test_leuven_settles_on_the_stribeck_curve(v, shape):
    par = LEUVEN._replace(shape=shape)
    force, _ = travel(par, np.arange(0.0, 0.04, abs(v) * 1e-5) * np.sign(v))
    assert force[-1] == pytest.approx(steady_friction(v, P_P, P_R, par), rel=2e-3)


def test_leuven_whose_elements_are_too_weak_ends_at_what_they_carry():
    weak = LEUVEN._replace(elements=(50.0, 50.0), bristle_damping=0.0)
    force, _ = travel(weak, np.arange(0.0, 0.02, 1e-6))
    assert force[-1] == pytest.approx(100.0 + 1500 * 0.1)


def test_leuven_with_one_element_that_never_slips_is_lugre():
    stiff = LEUVEN._replace(elements=(3e5 * 0.1,), presliding=0.1, bristle_damping=100.0)
    lugre = LUGRE._replace(bristle_damping=100.0)
    path = to_and_fro(0.0, 2e-3, 1.2e-3, 3e-3, -1e-3, speed=0.02)
    np.testing.assert_allclose(travel(stiff, path)[0], travel(lugre, path)[0], rtol=1e-9)


# Presliding alone: with a friction level far above what the elements carry, dz/dt = v nearly.
MEMORY = LEUVEN._replace(coulomb=1e7, stiction=1e7, viscous=0.0, shape=2.0)


def test_an_inner_loop_of_leuven_closes_and_is_forgotten():
    """Nonlocal memory: after the loop C-D-C the way to E is as if it had not been."""
    a, b, c, d, e = 0.0, 0.9e-3, 0.3e-3, 0.6e-3, 0.1e-3
    direct, _ = travel(MEMORY, to_and_fro(a, b, c, e))
    looped_path = to_and_fro(a, b, c, d, c, e)
    looped, _ = travel(MEMORY, looped_path)
    first, second = [k for k, x in enumerate(looped_path[:-1]) if abs(x - c) < 1e-9][-2:]
    assert looped[first] == pytest.approx(looped[second], abs=1.0)
    tail = len(to_and_fro(c, e)) - 1
    np.testing.assert_allclose(looped[-tail:], direct[-tail:], atol=1.0)


def test_lugre_forgets_where_it_turned():
    """Its inner loops do not close: under the same cycles of force, LuGre drifts."""
    weak = LUGRE._replace(coulomb=400.0, stiction=400.0, viscous=0.0)
    path = to_and_fro(0.0, 0.9e-3, 0.3e-3, 0.6e-3, 0.3e-3)
    force, _ = travel(weak, path)
    turn = [k for k, x in enumerate(path[:-1]) if abs(x - 0.3e-3) < 1e-9][-1]
    assert abs(force[turn] - force[-1]) > 5.0


def test_the_virgin_curve_of_leuven_is_that_of_springs_that_slip_one_by_one():
    path = np.linspace(0.0, 1.2e-3, 2001)
    force, _ = travel(MEMORY, path)
    x = 0.5 * (path[1:] + path[:-1])
    limits = 1e-3 * np.arange(1, 6) / 5
    expected = sum(150.0 * np.minimum(x / limit, 1.0) for limit in limits)
    np.testing.assert_allclose(force, expected, atol=1.0)


@settings(max_examples=30)
@given(
    turns=st.lists(st.floats(-2e-3, 2e-3), min_size=2, max_size=6),
    shape=st.sampled_from((0.7, 1.0, 2.0)),
)
def test_leuven_dissipates_but_for_what_its_springs_hold(turns, shape):
    par = LEUVEN._replace(shape=shape)
    path = to_and_fro(0.0, *turns, speed=0.01)
    force, state = travel(par, path)
    stored = sum(
        0.5 * theta / (1e-3 * (i + 1) / 5) * state[2 * i] ** 2
        for i, theta in enumerate(par.elements)
    )
    work = np.sum(force * np.diff(path))
    assert work - stored >= -1e-4 * (1e-3 + abs(work))
