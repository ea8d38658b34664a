"""Stopping distance after the valves close, which the bench file's stopping_time bounds."""

from itertools import product

import numpy as np
import pytest

from hbench.model.build import plant_parameters
from hbench.model.friction.laws import LAWS
from hbench.model.plant import P_LP, P_LR, P_TP, P_TR, V, X, initial_state
from hbench.model.simulation import simulate
from tests.support.board.moving_rig import BENCH, MovingRig

STOPPING_TIME_S = BENCH.limits.stopping_time
LOADS = ((500.0, 15e5), (5000.0, 15e5), (-500.0, 110e5), (-5000.0, 110e5))  # of both experiments


def stopped(v, load, x_at=None, vary=None, **settings):
    x_at = (0.25 if v > 0 else 0.15) if x_at is None else x_at
    rig = MovingRig(v, *load, x_at, vary, **settings)
    rig.overrun()
    stop = rig.stop()
    rig.close()
    return stop


def masses(factor):
    return lambda par: par._replace(
        mass_test_kg=factor * par.mass_test_kg, mass_load_kg=factor * par.mass_load_kg
    )


def stiffness(factor):
    return lambda par: par._replace(bulk_modulus_pa=factor * par.bulk_modulus_pa)


def with_friction(par, change):
    """Return the plant with both cylinders' friction changed by a function."""
    sides = (side._replace(friction=change(side.friction)) for side in (par.test, par.load))
    return par._replace(**dict(zip(("test", "load"), sides, strict=True)))


def viscous_alone(friction):
    dry = ("coulomb", "stiction", "piston_seal", "rod_seal")
    return friction._replace(law=LAWS["tustin"].code, **dict.fromkeys(dry, 0.0))


def viscosity(factor):
    return lambda par: with_friction(
        par, lambda friction: friction._replace(viscous=factor * friction.viscous)
    )


def spring(par, x):
    """Stiffness of the oil in the four chambers: total [N/m], and per area of each [Pa/m]."""
    test, load = par.test, par.load
    at = x + load.offset_m
    areas = np.array([test.area_piston_m2, test.area_rod_m2, load.area_piston_m2, load.area_rod_m2])
    volumes = np.array(
        [
            test.dead_volume_piston_m3 + test.area_piston_m2 * x,
            test.dead_volume_rod_m3 + test.area_rod_m2 * (test.stroke_m - x),
            load.dead_volume_piston_m3 + load.area_piston_m2 * (load.stroke_m - at),
            load.dead_volume_rod_m3 + load.area_rod_m2 * at,
        ]
    )
    gradients = par.bulk_modulus_pa * areas / volumes
    return float(np.sum(gradients * areas)), gradients


def test_stopping_distance_with_viscous_friction_follows_from_valve_closing_and_oil_stiffness():
    """x = v (2 zeta / w + B / k): flow while the spool closes (the integral of its step
    response), and the oil stiffness k that takes over the force B v."""
    par = with_friction(plant_parameters(BENCH), viscous_alone)._replace(substeps=8)
    b = par.test.friction.viscous + par.load.friction.viscous
    closing = 2 * par.valve.damping / par.valve.natural_frequency_rad_s
    for v in (0.2, -0.2):
        stop = stopped(v, LOADS[1], vary=lambda _: par)
        k, gradients = spring(par, stop.x_m)
        assert stop.distance_m == pytest.approx(stop.v_m_s * (closing + b / k), rel=0.04)
        # Compressed: test cylinder's far side, load cylinder's near side.
        distance = stop.v_m_s * b / k * np.sign(v)
        rise = np.maximum(gradients * np.array([-1, 1, 1, -1]) * distance, 0.0)
        measured = stop.p_highest_pa - stop.p_before_pa
        np.testing.assert_allclose(measured, rise, rtol=0.08, atol=0.2e5)


def test_without_friction_and_with_instant_valves_pressure_rises_by_v_root_km():
    """The highest pressure peak: m v^2 = k x^2, so k x = v sqrt(k m) in newtons."""
    par = with_friction(plant_parameters(BENCH), viscous_alone)
    par = with_friction(par, lambda friction: friction._replace(viscous=0.0))
    state = initial_state(par, 0.25, 15e5, 49e5)
    state[V] = v = 0.2
    path = simulate(par, state, np.zeros((200, 3))).state
    k, gradients = spring(par, 0.25)
    m = par.mass_test_kg + par.mass_load_kg
    rise = (path.max(axis=0) - path[0])[[P_TP, P_TR, P_LP, P_LR]]
    amplitude = v * np.sqrt(m / k)
    assert path[:, X].max() - 0.25 == pytest.approx(amplitude, rel=0.01)
    # Test cylinder's rod side, load cylinder's piston side first; the others half a period later.
    np.testing.assert_allclose(rise, gradients * amplitude, rtol=0.02)
    print(
        f"\nv sqrt(k m) = {v * np.sqrt(k * m):.0f} N; at most {rise.max() / 1e5:.1f} bar at "
        f"{1e3 * v:.0f} mm/s, k = {k:.3g} N/m"
    )


def worst(cases):
    """Assert that the distance is bounded in all cases; returns its maximum / speed [s]."""
    times = [stop.distance_m / stop.v_m_s for stop in (stopped(**case) for case in cases)]
    print(f"\n{len(times)} stops: {1e3 * min(times):.1f} to {1e3 * max(times):.1f} ms")
    assert max(times) < STOPPING_TIME_S
    return max(times)


def test_stopping_time_bounds_the_distance_over_loads_directions_speeds_and_masses():
    cases = [{"v": v, "load": load} for v, load in product((0.2, -0.2), LOADS)]
    cases += [{"v": v, "load": LOADS[1]} for v in (0.02, -0.02, 0.35, -0.35)]
    cases += [
        {"v": 0.2 * side, "load": load, "vary": masses(factor)}
        for side, load, factor in ((1, LOADS[1], 0.5), (-1, LOADS[3], 0.5), (1, LOADS[3], 2.0))
    ]
    # A limit much larger than necessary would cause unnecessary stops.
    assert worst(cases) > 0.6 * STOPPING_TIME_S


@pytest.mark.slow
def test_stopping_time_bounds_the_distance_over_the_whole_range():
    plants = (masses(0.5), masses(2.0), viscosity(1.2), stiffness(0.8), stiffness(1.2))
    speeds = (0.02, 0.1, 0.2, 0.3, 0.36)
    worst(
        {"v": side * v, "load": load, "x_at": x_at, "vary": vary}
        for side, v, load, vary in product((1, -1), speeds, LOADS, (None, *plants))
        for x_at in ((0.2, 0.25) if side > 0 else (0.2, 0.15))
    )


@pytest.mark.parametrize("v", [0.05, -0.05, 0.2, -0.2, 0.35, -0.35])
def test_the_piston_stays_within_its_travel_at_any_speed(v):
    limits = BENCH.limits
    travel = (limits.travel_min, limits.travel_max)
    load = LOADS[1] if v > 0 else LOADS[3]
    low, high = (travel[1] - 0.33, travel[1]) if v > 0 else (travel[0], travel[0] + 0.33)
    end = high if v > 0 else low
    rig = MovingRig(v, *load, end - np.sign(v) * 0.02, travel=(low, high))
    stop = rig.stop()
    rig.close()
    assert stop.fault == "travel"
    left = rig.along(end - stop.x_m)
    assert 0.0 <= left <= abs(v) * STOPPING_TIME_S + 1e-4
