"""The pressure-based law against curve_fit, and against the truth of the virtual rig."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import curve_fit

from hbench import workflow
from hbench.analysis.fitting.fit import fit_law, fit_pressure_based
from hbench.analysis.fitting.pressure_based import PARAMETER_UNITS, PRESSURE_BASED
from hbench.config.fitting import Fitting
from tests.support.analysis.other_plant import PRESSURE_FRICTION, STEADY

SPEEDS = np.linspace(0.005, 0.2, 10)
TRUTH = np.array([300.0, -15.0, 1.5e-5, 0.8e-5, 2000.0])


def law(inputs, k1, k2, k3, k4, k5):
    """Equation 3.7, written out for the other library."""
    v, p_p, p_r = inputs
    return k1 * np.exp(k2 * v) + k3 * np.abs(p_p - p_r) + k4 * p_r + k5 * v


def with_pressures(curve, p_p, p_r):
    points = [replace(point, p_tp_pa=p_p, p_tr_pa=p_r) for point in curve.points]
    return replace(curve, points=tuple(points))


@pytest.fixture
def make_curves(make_curve):
    """Return a function that makes four curves: two loads, both directions."""
    pressures = [(40e5, 30e5), (80e5, 20e5), (30e5, 60e5), (60e5, 110e5)]

    def make(truth, sigma=0.0, seed=0):
        rng = np.random.default_rng(seed)
        curves = []
        for i, (p_p, p_r) in enumerate(pressures):
            friction = law((SPEEDS, p_p, p_r), *truth) + sigma * rng.standard_normal(len(SPEEDS))
            direction = "extend" if i < 2 else "retract"
            curves.append(with_pressures(make_curve(SPEEDS, friction, direction), p_p, p_r))
        return curves

    return make


def as_arrays(curves):
    points = [point for curve in curves for point in curve.points]
    inputs = np.array([(abs(p.v_m_s), p.p_tp_pa, p.p_tr_pa) for p in points]).T
    return inputs, np.array([abs(p.friction_n) for p in points])


def test_exact_data_of_both_directions_gives_its_constants(make_curves):
    fit = fit_pressure_based(make_curves(TRUTH))
    values = [p.value for p in fit.parameters.values()]
    np.testing.assert_allclose(values, TRUTH, rtol=1e-5)
    assert fit.converged and fit.message == "" and fit.rmse_n < 1e-4
    assert list(fit.parameters) == list(PARAMETER_UNITS)


@pytest.mark.parametrize("seed", range(5))
def test_values_and_standard_errors_are_those_of_curve_fit(make_curves, seed):
    curves = make_curves(TRUTH, sigma=5.0, seed=seed)
    fit = fit_pressure_based(curves)
    inputs, friction = as_arrays(curves)
    scale = np.abs(TRUTH)
    expected, spread = curve_fit(
        lambda x, *k: law(x, *(k * scale)),
        inputs,
        friction,
        p0=np.sign(TRUTH),
        xtol=1e-12,
        ftol=1e-12,
    )
    values = [p.value for p in fit.parameters.values()]
    errors = [p.se for p in fit.parameters.values()]
    np.testing.assert_allclose(values, expected * scale, rtol=1e-4)
    np.testing.assert_allclose(errors, np.sqrt(np.diag(spread)) * scale, rtol=1e-2)


def test_friction_without_a_stribeck_fall_ends_at_the_bound_and_says_so(make_curves):
    """Friction that bends upwards at low speed would have a positive k2."""
    curves = make_curves(TRUTH * [-1, 1, 30, 30, 1])
    fit = fit_law(PRESSURE_BASED, curves, Fitting(), {"k2_s_m": (-10.0, 0.0)})
    assert fit.parameters["k2_s_m"].at_bound == "lower"
    assert re.search(r"\bk2_s_m\b.* lower .* -10 s/m", fit.message)


def test_one_load_and_direction_does_not_determine_the_pressure_terms(make_curves):
    fit = fit_pressure_based(make_curves(TRUTH, sigma=1.0)[:1])
    assert fit.parameters["k3_n_pa"].se is None and fit.parameters["k4_n_pa"].ci95 is None
    for name in ("k3_n_pa", "k4_n_pa"):
        assert re.search(rf"{name}[^;]*-side pressures", fit.message)


def test_points_without_a_rod_side_pressure_give_no_fit(make_curve):
    curve = make_curve(SPEEDS, 400 + 0 * SPEEDS)
    points = tuple(replace(point, p_tr_pa=None) for point in curve.points)
    fit = fit_pressure_based([replace(curve, points=points)])
    assert not fit.converged and fit.parameters == {}
    assert "0 points" in fit.message


RIG_TRUTH = {
    "k1_n": 300.0,
    "k2_s_m": -1 / 0.08,
    "k3_n_pa": 2.5e-5,
    "k4_n_pa": 1e-5,
    "k5_n_s_m": 2350.0,
}


def rig_fit(rig_campaign, seed):
    results = workflow.analyze(rig_campaign(STEADY, seed, PRESSURE_FRICTION))
    fit = fit_pressure_based(results.curves)
    assert fit.converged, fit.message
    return fit


def test_the_rigs_constants_are_found_within_four_standard_errors(rig_campaign):
    fit = rig_fit(rig_campaign, 0)
    for name, p in fit.parameters.items():
        assert abs(p.value - RIG_TRUTH[name]) < 4 * p.se < 0.6 * abs(RIG_TRUTH[name]), name


@pytest.mark.slow
def test_the_rigs_constants_lie_in_the_95_percent_intervals_over_many_seeds(rig_campaign):
    """40 campaigns, 5 constants that go together: two standard deviations are 4 %."""
    inside = [
        p.ci95[0] <= RIG_TRUTH[name] <= p.ci95[1]
        for seed in range(100, 140)
        for name, p in rig_fit(rig_campaign, seed).parameters.items()
    ]
    print(f"pressure-based: coverage {sum(inside)} of {len(inside)}")
    assert 0.90 <= np.mean(inside) <= 0.99
