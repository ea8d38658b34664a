"""The Tustin fit, against scipy's curve_fit, lmfit, a grid search and exact data."""

import json
import re

import numpy as np
import pytest
from scipy.optimize import curve_fit

from hbench.analysis.fitting.fit import fit_law, fits, unfitted_curves
from hbench.analysis.fitting.tustin import PARAMETER_NAMES, TUSTIN_LAW, tustin_friction
from hbench.config.fitting import TABLE_6_1, Fitting
from tests.support.analysis.chance import binomial_limits
from tests.support.analysis.fits import fit_tustin, stribeck

SPEEDS = np.linspace(0.005, 0.2, 15)
SOURCES_BOUNDS = dict(TABLE_6_1)
LAWS_OF_A_CURVE = ["tustin", "marton_lantos"]
TRUTH = np.array([250.0, 500.0, 0.07, 1500.0])


def noisy(seed, sigma=3.0, truth=TRUTH):
    return stribeck(SPEEDS, *truth) + sigma * np.random.default_rng(seed).standard_normal(
        len(SPEEDS)
    )


def values(fit):
    return np.array([fit.parameters[name].value for name in PARAMETER_NAMES])


def errors(fit):
    return np.array([fit.parameters[name].se for name in PARAMETER_NAMES])


@pytest.mark.parametrize("direction", ["extend", "retract"])
def test_exact_data_gives_its_parameters_in_both_directions(make_curve, direction):
    fit = fit_tustin(make_curve(SPEEDS, stribeck(SPEEDS, *TRUTH), direction))
    np.testing.assert_allclose(values(fit), TRUTH, rtol=1e-6)
    assert fit.rmse_n < 1e-6 and fit.converged and fit.message == ""
    assert [fit.parameters[name].unit for name in PARAMETER_NAMES] == ["N", "N", "m/s", "N s/m"]


@pytest.mark.parametrize("seed", range(10))
def test_values_and_standard_errors_are_those_of_curve_fit(make_curve, seed):
    friction = noisy(seed)
    wide = dict.fromkeys(PARAMETER_NAMES, (-1e6, 1e6)) | {"v_stribeck_m_s": (1e-3, 10.0)}
    fit = fit_tustin(make_curve(SPEEDS, friction), wide)
    expected, covariance = curve_fit(stribeck, SPEEDS, friction, p0=TRUTH, xtol=1e-12, ftol=1e-12)
    np.testing.assert_allclose(values(fit), expected, rtol=2e-4)
    np.testing.assert_allclose(errors(fit), np.sqrt(np.diag(covariance)), rtol=2e-3)
    ends = [fit.parameters[name].intervals["linearised"] for name in PARAMETER_NAMES]
    lower, upper = np.array(ends).T
    np.testing.assert_allclose((upper - lower) / 2, 2.20099 * errors(fit), rtol=1e-5)  # 11 dof


@pytest.mark.parametrize("seed", range(5))
def test_within_the_bounds_of_table_6_1_it_agrees_with_lmfit(make_curve, seed):
    lmfit = pytest.importorskip("lmfit")
    friction = noisy(seed, sigma=1.0)
    model = lmfit.Model(stribeck)
    parameters = model.make_params(**dict(zip(("f_c", "f_s", "v_s", "b"), TRUTH, strict=True)))
    for name, key in zip(("f_c", "f_s", "v_s", "b"), PARAMETER_NAMES, strict=True):
        parameters[name].set(min=SOURCES_BOUNDS[key][0], max=SOURCES_BOUNDS[key][1])
    found = model.fit(friction, parameters, v=SPEEDS, fit_kws={"xtol": 1e-12, "ftol": 1e-12})
    fit = fit_tustin(make_curve(SPEEDS, friction))
    np.testing.assert_allclose(values(fit), list(found.best_values.values()), rtol=1e-3)
    np.testing.assert_allclose(errors(fit), [p.stderr for p in found.params.values()], rtol=2e-2)


def grid_cost(friction):
    """Least sum of squares over table 6.1: bounded linear problem at each of 301 v_s."""
    from scipy.optimize import lsq_linear

    def cost(v_s):
        e = np.exp(-SPEEDS / v_s)
        return 2 * lsq_linear(np.column_stack([1 - e, e, SPEEDS]), friction, (0, 1e5)).cost

    return min(cost(v_s) for v_s in np.linspace(0.05, 0.2, 301))


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 4))]
)
@pytest.mark.parametrize(
    "truth",
    [
        (255, 430, 0.06, 1400),
        (0, 616, 0.10, 1341),  # table 6.2, steady
        (67, 566, 0.20, 0),  # table 6.5, ramp
        (300, 535, 0.033, 2250),  # v_s below its bound
        (500, 400, 0.10, 500),  # rising, no Stribeck minimum
    ],
)
def test_no_point_of_the_bounds_fits_better(make_curve, truth, seed):
    friction = noisy(seed, sigma=8.0, truth=truth)
    fit = fit_tustin(make_curve(SPEEDS, friction))
    assert fit.converged
    assert len(SPEEDS) * fit.rmse_n**2 <= grid_cost(friction) * (1 + 1e-9)
    for name, p in fit.parameters.items():
        assert SOURCES_BOUNDS[name][0] <= p.value <= SOURCES_BOUNDS[name][1]


@pytest.mark.parametrize("v_stribeck", [0.015, 0.03, 0.07, 0.12])
def test_by_default_the_bounds_of_the_stribeck_velocity_are_the_measured_speeds(
    make_curve, v_stribeck
):
    """Table 6.1 would put a velocity of 30 mm/s on its bound of 50, with F_s 9 % too low."""
    truth = np.array([80.0, 450.0, v_stribeck, 2500.0])
    found = [
        fit_law(TUSTIN_LAW, [make_curve(SPEEDS, noisy(seed, 0.1, truth))], Fitting())
        for seed in range(10)
    ]
    assert np.median([values(fit) for fit in found], axis=0) == pytest.approx(truth, rel=0.1)
    assert not any(fit.parameters["v_stribeck_m_s"].at_bound for fit in found)
    steep = stribeck(SPEEDS, 300, 535, 0.002, 2250)  # below the lowest speed
    fit = fit_law(TUSTIN_LAW, [make_curve(SPEEDS, steep)], Fitting())
    assert fit.parameters["v_stribeck_m_s"].value == SPEEDS[0]
    assert fit.parameters["v_stribeck_m_s"].at_bound == "lower"


def test_a_stribeck_speed_below_its_bound_is_flagged_in_plain_words(make_curve):
    truth = (300, 535, 0.02, 2250)
    fit = fit_tustin(make_curve(SPEEDS, noisy(1, sigma=2.0, truth=truth)))
    stribeck = fit.parameters["v_stribeck_m_s"]
    assert stribeck.at_bound == "lower" and stribeck.value == 0.05
    assert stribeck.se is None and stribeck.intervals["linearised"] is None
    assert stribeck.ci95[0] == 0.05 and 0.05 < stribeck.ci95[1] < 0.07
    assert f"{1e3 * stribeck.ci95[1]:.3g} mm/s" in fit.message
    assert re.search(r"\bv_stribeck_m_s\b.* lower .*\b50 mm/s", fit.message)


def test_other_parameters_at_a_bound_are_those_of_the_reduced_fit(make_curve):
    friction = noisy(2, sigma=2.0, truth=(300, 535, 0.02, 2250))
    fit = fit_tustin(make_curve(SPEEDS, friction))
    e = np.exp(-SPEEDS / 0.05)
    matrix = np.column_stack([1 - e, e, SPEEDS])
    expected, rss, *_ = np.linalg.lstsq(matrix, friction, rcond=None)
    np.testing.assert_allclose(values(fit)[[0, 1, 3]], expected, rtol=1e-6)
    covariance = np.linalg.inv(matrix.T @ matrix) * rss[0] / (15 - 3)
    free = ["f_coulomb_n", "f_stiction_n", "b_viscous_n_s_m"]
    found = [fit.parameters[name].se for name in free]
    np.testing.assert_allclose(found, np.sqrt(np.diag(covariance)), rtol=1e-5)


@pytest.mark.parametrize(
    ("truth", "name", "side"),
    [
        ((-200, 600, 0.1, 3000), "f_coulomb_n", "lower"),
        ((200, 600, 0.5, 500), "v_stribeck_m_s", "upper"),
        ((400, 600, 0.08, -400), "b_viscous_n_s_m", "lower"),
    ],
)
def test_each_bound_is_found_active(make_curve, truth, name, side):
    fit = fit_tustin(make_curve(SPEEDS, noisy(3, sigma=0.1, truth=truth)))
    assert fit.parameters[name].at_bound == side
    assert fit.parameters[name].value == SOURCES_BOUNDS[name][0 if side == "lower" else 1]
    assert re.search(rf"\b{name}\b.* {side} ", fit.message)


def test_a_parameter_near_its_bound_but_not_drawn_to_it_is_free(make_curve):
    truth = np.array([0.2, 600.0, 0.1, 1300.0])
    fit = fit_tustin(make_curve(SPEEDS, stribeck(SPEEDS, *truth)))
    assert fit.parameters["f_coulomb_n"].at_bound is None
    np.testing.assert_allclose(values(fit), truth, rtol=1e-4)


@pytest.mark.parametrize("count", [60, pytest.param(150, marks=pytest.mark.slow)])
def test_intervals_of_the_parameters_cover_the_truth(make_curve, count):
    inside = np.zeros(4)
    for seed in range(count):
        fit = fit_tustin(make_curve(SPEEDS, noisy(seed, sigma=1.0)))
        for i, name in enumerate(PARAMETER_NAMES):
            low, high = fit.parameters[name].ci95
            inside[i] += low <= TRUTH[i] <= high
    least, most = binomial_limits(count, 0.95, 0.99)
    assert np.all(least <= inside) and np.all(inside <= most)


def test_no_standard_error_stands_beside_an_interval_that_lies_inside_it(make_curve):
    """The bound at zero force keeps Coulomb friction's interval; the linearised one ignores it."""
    fit = fit_tustin(make_curve(SPEEDS, noisy(2, sigma=5.0, truth=(50, 400, 0.18, 1000))))
    p = fit.parameters["f_coulomb_n"]
    low, high = p.intervals["linearised"]
    se = (high - low) / 2 / 2.20099  # 11 degrees of freedom
    assert p.at_bound is None and p.value - se < p.ci95[0] < p.ci95[1] < p.value + se
    assert p.se is None and p.disagree and "f_coulomb_n" in fit.message


def test_a_curve_of_another_form_converges_and_its_rmse_is_the_distance_to_its_line(make_curve):
    friction = 300 + 250 * np.exp(-((SPEEDS / 0.06) ** 1.5)) + 1200 * SPEEDS
    fit = fit_tustin(make_curve(SPEEDS, friction))
    line = dict(fit.line)
    rest = friction - np.array([line[v] for v in SPEEDS])
    assert fit.converged
    assert fit.rmse_n == pytest.approx(np.sqrt(np.mean(rest**2)), rel=1e-9)
    assert fit.rmse_n > 2  # it can't follow that form, and says so


@pytest.mark.parametrize("sign", [1, -1])
def test_the_line_is_the_law_at_the_points_and_between_them_only(make_curve, sign):
    curve = make_curve(SPEEDS, noisy(0), "extend" if sign > 0 else "retract")
    fit = fit_tustin(curve)
    v, friction = np.array(fit.line).T
    assert {point.v_m_s for point in curve.points} <= set(v.tolist())
    assert np.abs(v).min() == SPEEDS.min() and np.abs(v).max() == SPEEDS.max()
    np.testing.assert_allclose(friction, sign * stribeck(np.abs(v), *values(fit)))
    np.testing.assert_allclose(
        tustin_friction(np.abs(v), values(fit)), stribeck(np.abs(v), *values(fit))
    )


def test_without_a_stribeck_part_its_speed_is_not_determined(make_curve):
    fit = fit_tustin(make_curve(SPEEDS, 300 + 1000 * SPEEDS))
    assert fit.parameters["v_stribeck_m_s"].se is None
    assert re.search(r"\bnot\b.*\bv_stribeck_m_s\b", fit.message)


def test_low_speeds_alone_do_not_determine_the_viscous_part(make_curve):
    slow = SPEEDS / 10
    rest = np.random.default_rng(0).standard_normal(len(slow))
    fit = fit_tustin(make_curve(slow, stribeck(slow, *TRUTH) + rest))
    assert re.search(r"\bb_viscous_n_s_m\b.* needs? \w+ above 20 mm/s\b", fit.message)


def test_a_parameter_whose_interval_a_bound_cuts_off_is_not_determined(make_curve):
    """The data does not set that end: it agrees with a Coulomb force of zero, the bound."""
    cut_off = inside = 0
    for seed in range(12):
        fit = fit_tustin(make_curve(SPEEDS, noisy(seed, 25.0 if seed % 2 else 8.0)))
        coulomb = fit.parameters["f_coulomb_n"]
        if coulomb.at_bound or coulomb.ci95[1] - coulomb.ci95[0] > 2 * coulomb.value:
            continue  # not determined for another reason
        cut_off += coulomb.ci95[0] == 0.0
        inside += coulomb.ci95[0] > 0.0
        assert (coulomb.determination == "not determined") == (coulomb.ci95[0] == 0.0)
        assert ("f_coulomb_n" in fit.undetermined) == (coulomb.ci95[0] == 0.0)
    assert cut_off and inside


def test_as_many_points_as_parameters_leave_no_standard_error(make_curve):
    speeds = SPEEDS[[0, 3, 7, 14]]
    fit = fit_tustin(make_curve(speeds, stribeck(speeds, *TRUTH)))
    assert fit.converged and "standard errors" in fit.message
    assert all(p.se is None and p.ci95 is None for p in fit.parameters.values())


def test_fewer_points_than_parameters_do_not_converge_and_raise_nothing(make_curve):
    fit = fit_tustin(make_curve(SPEEDS[:3], stribeck(SPEEDS[:3], *TRUTH)))
    assert not fit.converged and "3 points" in fit.message and not fit.parameters


def test_curves_with_few_speeds_are_left_out_with_a_note(make_curve):
    few, enough = make_curve(SPEEDS[:3], [1, 2, 3]), make_curve(SPEEDS, noisy(0))
    assert fits(few) == () and [fit.law for fit in fits(enough)] == LAWS_OF_A_CURVE
    (note,) = unfitted_curves([few, enough])
    assert re.findall(r"\d+", note) == ["1", "2", "3", "4"]  # curves, all, their speeds, needed
    assert unfitted_curves([enough]) == ()


def test_friction_of_zero_is_no_error(make_curve):
    fit = fit_tustin(make_curve(SPEEDS, np.zeros(15)))
    assert fit.converged and fit.rmse_n < 1e-6


def test_a_fit_is_made_of_plain_numbers(make_curve):
    fit = fit_tustin(make_curve(SPEEDS, noisy(0)))
    json.dumps([vars(p) for p in fit.parameters.values()] + [fit.converged, fit.rmse_n, fit.line])


@pytest.mark.parametrize("count", [80, pytest.param(200, marks=pytest.mark.slow)])
def test_the_bias_is_the_mean_error_of_many_fits(make_curve, count):
    """F_C too small, v_s and B too large, from curves of 15 speeds."""
    found = [
        fit_law(TUSTIN_LAW, [make_curve(SPEEDS, noisy(seed, 3.5))], Fitting(weights="equal"))
        for seed in range(count)
    ]
    known = [fit for fit in found if all(p.bias is not None for p in fit.parameters.values())]
    assert len(known) > 0.95 * count
    errors = np.array([values(fit) - TRUTH for fit in known])
    bias = np.array([[p.bias for p in fit.parameters.values()] for fit in known]).mean(axis=0)
    uncertain = errors.std(axis=0) / np.sqrt(len(known))
    assert np.all(np.abs(errors.mean(axis=0) - bias) < 3 * uncertain)
    f_c, _, v_s, b = PARAMETER_NAMES
    assert bias[0] < 0 < bias[2] and bias[3] > 0, (f_c, v_s, b)


def test_without_a_stribeck_part_there_is_no_bias_and_no_overflow(make_curve):
    """Its velocity is not determined: a tenth of its standard error makes it negative."""
    for seed in range(10):
        fit = fit_law(TUSTIN_LAW, [make_curve(SPEEDS, noisy(seed, 3.0, (0, 0, 1, 0)))], Fitting())
        for parameter in fit.parameters.values():
            assert parameter.bias is None or np.isfinite(parameter.bias)
