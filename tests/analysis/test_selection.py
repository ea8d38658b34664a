"""Held-out errors against fits made here without the speed, and laws that can't be told apart."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import curve_fit

from hbench.analysis.fitting.joint import fitted, joint_fits
from hbench.config.fitting import Fitting
from tests.support.analysis.chance import binomial_limits
from tests.support.analysis.fits import stribeck

SPEEDS = np.linspace(0.005, 0.2, 15)
EQUAL = Fitting(weights="equal")


def lines(v, a_1, b_1, b_2, v_switch):
    return a_1 + b_1 * np.minimum(v, v_switch) + b_2 * np.maximum(v - v_switch, 0)


def noise(seed, sigma=3.0):
    return sigma * np.random.default_rng(seed).standard_normal(15)


def test_the_error_of_a_law_is_that_of_fits_without_each_speed(make_curve):
    friction = stribeck(SPEEDS, 250, 500, 0.07, 1500) + noise(0)
    found = fitted(make_curve(SPEEDS, friction), EQUAL).selection
    errors = []
    for i in range(1, 14):
        rest = np.arange(15) != i
        start = (250, 500, 0.07, 1500)
        best, _ = curve_fit(stribeck, SPEEDS[rest], friction[rest], p0=start, xtol=1e-12)
        errors.append(stribeck(SPEEDS[i], *best) - friction[i])
    tustin = next(one for one in found.laws if one.law == "tustin")
    assert tustin.rmse_n == pytest.approx(np.sqrt(np.mean(np.square(errors))), rel=1e-3)
    assert found.speeds == 13


def test_the_law_that_made_the_data_is_distinguished(make_curve):
    curved = fitted(
        make_curve(SPEEDS, stribeck(SPEEDS, 100, 600, 0.06, 2500) + noise(1, 1.0)), EQUAL
    )
    assert curved.selection.laws[0].law == "tustin" and curved.selection.distinguishable
    bent = fitted(make_curve(SPEEDS, lines(SPEEDS, 500, -3000, 1500, 0.08) + noise(2, 1.0)), EQUAL)
    assert bent.selection.laws[0].law == "marton_lantos" and bent.selection.distinguishable


@pytest.mark.parametrize("count", [6, pytest.param(15, marks=pytest.mark.slow)])
def test_laws_that_are_equally_good_are_distinguished_by_chance_alone(make_curve, count):
    """A straight line is in both laws, and 5 % of the curves distinguish them."""
    apart = [
        fitted(
            make_curve(SPEEDS, 300 + 1500 * SPEEDS + noise(seed)), EQUAL
        ).selection.distinguishable
        for seed in range(count)
    ]
    assert sum(apart) <= binomial_limits(count, 0.05, 0.99)[1]


def test_few_speeds_or_one_law_leave_nothing_to_select(make_curve):
    few = SPEEDS[::3]
    assert fitted(make_curve(few, stribeck(few, 250, 500, 0.07, 1500)), EQUAL).selection is None
    alone = Fitting(laws=("tustin",))
    curve = make_curve(SPEEDS, stribeck(SPEEDS, 250, 500, 0.07, 1500) + noise(0))
    assert fitted(curve, alone).selection is None


def test_friction_of_pressure_is_predicted_best_by_the_law_of_all_loads(make_curve):
    """Five parameters for four curves predict better than four for each, of the same form."""
    curves = []
    for i, (p_p, p_r) in enumerate([(40e5, 30e5), (80e5, 20e5), (30e5, 60e5), (60e5, 110e5)]):
        friction = 300 * np.exp(-15 * SPEEDS) + 2000 * SPEEDS + noise(i, 5.0)
        friction = friction + 1.5e-5 * abs(p_p - p_r) + 0.8e-5 * p_r
        curve = make_curve(SPEEDS, friction, "extend" if i < 2 else "retract")
        points = tuple(replace(point, p_tp_pa=p_p, p_tr_pa=p_r) for point in curve.points)
        curves.append(fitted(replace(curve, points=points), EQUAL))
    (joint,) = joint_fits(curves, EQUAL)
    assert (joint.curves, joint.points) == (4, 60) and joint.fits[0].law == "pressure_based"
    assert [one.law for one in joint.selection.laws][0] == "pressure_based"
    assert len(joint.selection.laws) == 3
    assert joint_fits(curves[:1], EQUAL) == ()
