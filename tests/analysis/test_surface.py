"""Friction over velocity and load."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.curves.surface import friction_surfaces


def law(v, load):
    return 300 + 1500 * v + 0.03 * load


@pytest.mark.parametrize("direction", ["extend", "retract"])
def test_the_surface_is_the_law_at_the_measured_speeds_and_loads(make_curve, direction):
    speeds = np.array([0.01, 0.05, 0.1, 0.2])
    loads = [5000.0, 500.0, 2000.0]
    curves = [make_curve(speeds, law(speeds, load), direction, load) for load in loads]
    (found,) = friction_surfaces(curves)
    assert found.direction == direction and found.f_load_n == (500.0, 2000.0, 5000.0)
    assert found.v_m_s == pytest.approx(speeds)
    expected = [law(speeds, load) for load in sorted(loads)]
    assert np.array(found.friction_n) == pytest.approx(np.array(expected))


def test_speeds_that_not_all_loads_have_are_not_extrapolated(make_curve):
    short, long = np.array([0.02, 0.06, 0.12]), np.linspace(0.005, 0.2, 12)
    curves = [
        make_curve(v, law(v, load), f_applied_n=load)
        for v, load in ((short, 1.0), (long, 2.0), (long, 3.0))
    ]
    (found,) = friction_surfaces(curves)
    assert found.v_m_s == pytest.approx(short)
    assert found.friction_n[1] == pytest.approx(law(short, 2.0))  # the law is straight in v


def test_two_loads_or_ramps_make_no_surface(make_curve):
    v = np.array([0.02, 0.06, 0.12])
    curves = [make_curve(v, law(v, load), f_applied_n=load) for load in (1.0, 2.0, 3.0)]
    assert friction_surfaces(curves[:2]) == ()
    assert friction_surfaces([replace(curve, kind="ramp") for curve in curves]) == ()
