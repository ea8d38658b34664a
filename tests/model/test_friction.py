import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hbench.model.friction import laws as laws
from hbench.model.friction.laws import LAWS, steady_friction
from hbench.model.parameters import FrictionParameters

PAR = FrictionParameters(
    law=LAWS["lugre"].code,
    coulomb=300.0,
    stiction=500.0,
    stribeck_velocity=0.06,
    stribeck_exponent=1.0,
    viscous=1500.0,
    bristle_stiffness=3e5,
    bristle_damping=0.0,
    piston_seal=1.2e-5,  # 1.2 N/bar
    rod_seal=0.8e-5,
    scatter=0.0,
)
TUSTIN = PAR._replace(law=LAWS["tustin"].code)


def friction(v, z, p_p, p_r, level, par):
    """One state in, its rate out, as plain numbers."""
    state, rates = np.array([z]), np.zeros(1)
    force = laws.friction(v, state, 0, p_p, p_r, level, par, rates)
    return force, rates[0]


def test_steady_curve_is_equation_3_13_with_the_seals_added():
    # 40 bar over the piston: 48 N, 10 bar at the rod: 8 N; at v_s the exponential is 1/e
    assert steady_friction(0.06, 50e5, 10e5, PAR) == pytest.approx(
        300 + 48 + 8 + 200 / np.e + 1500 * 0.06, rel=1e-12
    )
    assert steady_friction(-0.06, 50e5, 10e5, PAR) == -steady_friction(0.06, 50e5, 10e5, PAR)


def test_exponent_shapes_the_stribeck_term():
    squared = PAR._replace(stribeck_exponent=2.0)
    v = 0.03
    assert steady_friction(v, 0.0, 0.0, squared) == pytest.approx(
        300 + 200 * np.exp(-0.25) + 1500 * v, rel=1e-12
    )


@pytest.mark.parametrize("v", [-0.2, -0.05, -0.004, 0.004, 0.05, 0.2])
def test_lugre_settles_on_the_tustin_curve(v):
    z, dt = 0.0, 1e-4
    for _ in range(int(0.06 / abs(v) / dt)):  # 60 mm, 30 bristle lengths and more
        force, z_rate = friction(v, z, 50e5, 10e5, 1.0, PAR)
        z += dt * z_rate
    assert force == pytest.approx(steady_friction(v, 50e5, 10e5, PAR), rel=1e-9)
    # the regularised sign is 0.999 at 4 mm/s
    assert friction(v, 0.0, 50e5, 10e5, 1.0, TUSTIN)[0] == pytest.approx(force, rel=1.1e-3)


def test_presliding_is_a_spring():
    z = 0.0
    for _ in range(100):  # 1 um at 0.1 mm/s
        z += 1e-4 * friction(1e-4, z, 0.0, 0.0, 1.0, PAR)[1]
    force, _ = friction(0.0, z, 0.0, 0.0, 1.0, PAR)
    assert force == pytest.approx(3e5 * 1e-6, rel=1e-3)


def test_level_scales_the_dry_part_alone():
    v = 0.1
    nominal, _ = friction(v, 0.0, 50e5, 10e5, 1.0, TUSTIN)
    higher, _ = friction(v, 0.0, 50e5, 10e5, 1.1, TUSTIN)
    assert higher - nominal == pytest.approx(0.1 * (nominal - 1500 * v), rel=1e-12)


@settings(max_examples=50)
@given(
    speeds=st.lists(st.floats(-0.2, 0.2), min_size=2, max_size=20),
    law=st.sampled_from((PAR, TUSTIN)),
)
def test_friction_dissipates_but_for_what_its_bristles_hold(speeds, law):
    knots = np.arange(len(speeds)) * 0.01
    dt = 1e-5
    work, z = 0.0, 0.0
    for v in np.interp(np.arange(0.0, knots[-1], dt), knots, speeds):  # midpoint rule
        _, z_rate = friction(v, z, 30e5, 10e5, 1.0, law)
        force, z_rate = friction(v, z + 0.5 * dt * z_rate, 30e5, 10e5, 1.0, law)
        work += force * v * dt
        z += z_rate * dt
    stored = 0.5 * law.bristle_stiffness * z**2
    assert work - stored >= -1e-6 * (1 + abs(work))
