"""Covariances against their definitions: curve_fit, and runs left out one by one."""

import re

import numpy as np
import pytest
from scipy import stats
from scipy.optimize import curve_fit

from hbench.analysis.statistics.intervals import (
    covariance,
    covariance_over_runs,
    fit_parameters,
    parameter_messages,
)


def problem(seed=0, runs=6, each=20):
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((runs * each, 3)) * [1.0, 1e5, 1e-5]
    run = np.repeat(np.arange(runs), each)
    y = matrix @ [2.0, 3e-5, 4e5] + np.repeat(rng.standard_normal(runs), each)
    return matrix, y, run


def solved(matrix, y):
    return np.linalg.lstsq(matrix, y, rcond=None)[0]


def test_the_covariance_of_independent_residuals_is_that_of_curve_fit():
    matrix, y, _ = problem()
    _, expected = curve_fit(lambda _, a, b, c: matrix @ [a, 1e-5 * b, 1e5 * c], 0 * y, y)
    scale = np.array([1.0, 1e-5, 1e5])
    found = covariance(matrix, matrix @ solved(matrix, y) - y)
    np.testing.assert_allclose(found / np.outer(scale, scale), expected, rtol=1e-4, atol=1e-8)


def test_the_covariance_over_runs_is_the_spread_of_fits_that_leave_a_run_out():
    matrix, y, run = problem()
    whole = solved(matrix, y)
    left_out = np.array([solved(matrix[run != g], y[run != g]) for g in range(6)])
    expected = 5 / 6 * (left_out - whole).T @ (left_out - whole)
    found, _ = covariance_over_runs(matrix, matrix @ whole - y, run)
    np.testing.assert_allclose(found, expected, rtol=1e-8)


def test_copies_of_a_sample_do_not_narrow_the_intervals_over_runs():
    matrix, y, run = problem()
    residual = matrix @ solved(matrix, y) - y
    once = covariance_over_runs(matrix, residual, run)
    thrice = covariance_over_runs(*(np.repeat(a, 3, axis=0) for a in (matrix, residual, run)))
    np.testing.assert_allclose(thrice.covariance, once.covariance, rtol=1e-9)
    np.testing.assert_allclose(thrice.dof, once.dof, rtol=1e-9)


@pytest.mark.parametrize(
    "runs, strong", [(8, 2), (12, 3), pytest.param(51, 5, marks=pytest.mark.slow)]
)
def test_intervals_over_runs_contain_the_truth_where_few_runs_determine_a_parameter(runs, strong):
    """With G - 1 degrees of freedom 91 to 93 % of those of the second parameter would."""
    rng, run, inside = np.random.default_rng(0), np.repeat(np.arange(runs), 20), []
    for _ in range(1000):
        acts = (np.arange(runs) < strong) + 0.05 * rng.standard_normal(runs)
        matrix = np.column_stack([np.ones(len(run)), acts[run]])
        matrix *= 1 + [0.3, 0.1] * rng.standard_normal(matrix.shape)
        y = rng.standard_normal(runs)[run] + rng.standard_normal(len(run))
        x = solved(matrix, y)
        found, dof = covariance_over_runs(matrix, y - matrix @ x, run)
        inside.append(np.abs(x) < stats.t.ppf(0.975, dof) * np.sqrt(np.diag(found)))
    share = np.mean(inside, axis=0)
    assert np.all(share > 0.935) and np.all(share < 0.995), share


def test_runs_that_say_the_same_have_one_degree_of_freedom_fewer_than_runs():
    matrix = np.ones((6, 1))
    _, dof = covariance_over_runs(matrix, np.arange(6.0), np.arange(6))
    np.testing.assert_allclose(dof, 5.0)


def test_what_is_not_determined_has_no_interval_and_the_rest_has():
    matrix, y, run = problem()
    matrix[:, 1] = 2 * matrix[:, 2]
    for found in (covariance(matrix, y), covariance_over_runs(matrix, y, run).covariance):
        assert np.isfinite(found[0, 0]) and np.isnan(found[1:, 1:]).all()
    units = {"a": "N", "b": "m", "c": "s"}
    size = np.ones(3)
    parameters = fit_parameters(
        units, np.arange(3.0), covariance(matrix, y), np.full(3, 117), [None] * 3, size
    )
    assert parameters["b"].ci95 is None and parameters["a"].se > 0
    (message,) = parameter_messages(parameters)
    assert message.endswith("b and c")


def test_one_run_says_nothing_about_the_scatter_of_runs():
    matrix, y, run = problem(runs=1)
    assert all(np.isnan(each).all() for each in covariance_over_runs(matrix, y, run))


def test_an_interval_takes_students_factor_and_a_bound_has_none():
    units = {"a": "N", "b": "m"}
    values, size = np.array([5.0, 1.0]), np.ones(2)
    found = fit_parameters(units, values, np.array([[4.0]]), np.array([2]), [None, "upper"], size)
    assert found["a"].ci95 == pytest.approx((5 - 2 * 4.3027, 5 + 2 * 4.3027), abs=1e-3)
    assert found["b"].se is None and found["b"].at_bound == "upper"
    assert re.match(r"b\b.* upper .*\b1 m\b", parameter_messages(found)[0])


def test_an_interval_wider_than_its_value_and_than_a_tenth_of_its_size_determines_nothing():
    """Half-widths are 12.7 times the errors 0.1, 0.1 and 1: one degree of freedom."""
    units = {"exact": "N", "small": "N", "wide": "N"}
    spread, size = np.diag([0.01, 0.01, 1.0]), np.array([10.0, 20.0, 20.0])
    found = fit_parameters(units, np.array([5.0, 0.0, 5.0]), spread, np.ones(3), [None] * 3, size)
    grades = ["determined", "hardly determined", "not determined"]
    assert [p.determination for p in found.values()] == grades
    assert found["wide"].ci95 is not None
    assert parameter_messages(found) == ["the data does not determine wide"]
