"""The robust loss against scipy's, against closed forms, and with an outlier."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from hbench.analysis.fitting.fit import fit_law
from hbench.analysis.fitting.tustin import PARAMETER_NAMES, TUSTIN_LAW, tustin_friction
from hbench.analysis.statistics.bounded import Problem, descend
from hbench.analysis.statistics.robust import minimise_robust
from hbench.config.fitting import Fitting

SPEEDS = np.linspace(0.005, 0.2, 15)
TRUTH = np.array([250.0, 500.0, 0.07, 1500.0])


def noisy(seed=0, sigma=3.0, outlier=0.0):
    friction = tustin_friction(SPEEDS, TRUTH)
    friction = friction + sigma * np.random.default_rng(seed).standard_normal(15)
    friction[9] += outlier
    return friction


def values(fit):
    return np.array([fit.parameters[name].value for name in PARAMETER_NAMES])


@pytest.mark.parametrize("loss", ["huber", "soft_l1"])
def test_the_solution_is_scipys_at_the_same_scale(loss):
    rng = np.random.default_rng(4)
    x = np.linspace(0, 1, 40)
    y = 2 + 3 * x + rng.standard_t(2, 40)
    matrix = np.column_stack([np.ones(40), x])
    free = np.full(2, np.inf)
    problem = Problem(lambda p: matrix @ p - y, -free, free, np.ones(2), lambda p: matrix)
    found = minimise_robust(problem, descend(problem, np.zeros(2)), loss)
    residual = matrix @ found.solution.x - y
    size = np.median(np.abs(residual)) / 0.6745 * np.sqrt(40 / 38)
    peer = least_squares(problem.residual, np.zeros(2), loss=loss, f_scale=1.345 * size, xtol=1e-12)
    np.testing.assert_allclose(found.solution.x, peer.x, rtol=1e-5)
    again = descend(found.problem, np.zeros(2))
    np.testing.assert_allclose(again.x, found.solution.x, rtol=1e-6)  # of the pseudo-values too


@pytest.mark.parametrize("loss", ["huber", "soft_l1"])
def test_an_outlier_moves_a_robust_fit_less_than_its_error(make_curve, loss):
    how = Fitting(loss=loss)
    clean = fit_law(TUSTIN_LAW, [make_curve(SPEEDS, noisy())], how)
    spoilt = fit_law(TUSTIN_LAW, [make_curve(SPEEDS, noisy(outlier=150.0))], how)
    linear = fit_law(TUSTIN_LAW, [make_curve(SPEEDS, noisy(outlier=150.0))], Fitting())
    se = np.array([clean.parameters[name].se for name in PARAMETER_NAMES])
    assert spoilt.converged
    assert np.all(np.abs(values(spoilt) - values(clean)) < 2 * se)
    line, expected = dict(linear.line), tustin_friction(SPEEDS, TRUTH)
    away = max(abs(line[v] - f) for v, f in zip(SPEEDS, expected, strict=True))
    assert away > 10.0  # which least squares does not withstand


@pytest.mark.parametrize("loss", ["huber", "soft_l1"])
def test_on_normal_errors_the_standard_error_is_the_scatter_of_repeated_fits(loss):
    """To 95 % efficiency: over 150 draws a standard deviation is known to 6 %."""
    rng = np.random.default_rng(6)
    x = np.linspace(-1, 1, 30)
    matrix = np.column_stack([np.ones(30), x])
    free = np.full(2, np.inf)
    found, stated = [], []
    for _ in range(150):
        y = rng.standard_normal(30)
        problem = Problem(lambda p, y=y: matrix @ p - y, -free, free, np.ones(2), lambda p: matrix)
        one = minimise_robust(problem, descend(problem, np.zeros(2)), loss)
        pseudo = one.problem.residual(one.solution.x)
        spread = np.linalg.inv(matrix.T @ matrix) * (pseudo @ pseudo) / 28
        found.append(one.solution.x)
        stated.append(np.diag(spread))
    drawn = np.std(found, axis=0)
    np.testing.assert_allclose(np.sqrt(np.mean(stated, axis=0)), drawn, rtol=0.15)
    least = np.sqrt(np.diag(np.linalg.inv(matrix.T @ matrix)))
    assert np.all(drawn < 1.2 * least)


def test_exact_data_stays_exact(make_curve):
    fit = fit_law(
        TUSTIN_LAW, [make_curve(SPEEDS, tustin_friction(SPEEDS, TRUTH))], Fitting(loss="huber")
    )
    np.testing.assert_allclose(values(fit), TRUTH, rtol=1e-6)
    assert fit.converged
