"""Levels of trials against two-way analysis of variance, and the parts of a fit's covariance."""

import numpy as np
import pytest

from hbench.analysis.fitting.fit import fit_law
from hbench.analysis.fitting.parameter_spread import parameter_spread, standard_uncertainty
from hbench.analysis.fitting.tustin import TUSTIN_LAW
from hbench.analysis.statistics.trial_levels import trial_levels
from hbench.config.fitting import Fitting

POINTS, TRIALS = 9, 4
POINT, TRIAL = (each.ravel() for each in np.mgrid[:POINTS, :TRIALS])


def drawn(rng, scatter, level):
    a = np.linspace(300.0, 600.0, POINTS)[:, None]
    return a + scatter * rng.standard_normal((POINTS, TRIALS)) + level * rng.standard_normal(TRIALS)


def test_of_a_full_table_it_is_the_mean_square_between_trials_less_that_of_the_rest():
    y = drawn(np.random.default_rng(4), 1.0, 5.0)
    found = trial_levels(y.ravel(), POINT, TRIAL, np.ones(POINTS))
    column = y.mean(axis=0) - y.mean()
    between = POINTS * column @ column / (TRIALS - 1)
    left = y - y.mean(axis=1)[:, None] - column
    rest = np.sum(left**2) / (POINTS - 1) / (TRIALS - 1)
    np.testing.assert_allclose(found.u_n, np.sqrt((between - rest) / POINTS / TRIALS))
    assert found.p < 1e-6 and 2.5 < found.dof < 3.0


def test_levels_that_are_shares_of_friction_are_shares_at_each_point():
    rng = np.random.default_rng(2)
    a = np.linspace(100.0, 900.0, POINTS)[:, None]
    y = a * (1 + 0.03 * rng.standard_normal(TRIALS)) + rng.standard_normal((POINTS, TRIALS))
    u = trial_levels(y.ravel(), POINT, TRIAL, np.ones(POINTS)).u_n
    np.testing.assert_allclose(u / u[0], y.mean(axis=1) / y[0].mean())


def test_a_table_with_gaps_has_the_variance_of_the_levels_in_the_mean():
    rng, variances = np.random.default_rng(3), []
    kept = ~np.isin(np.arange(len(POINT)), [1, 6, 7, 20, 33])
    counts = np.bincount(POINT[kept])
    for _ in range(400):
        y = drawn(rng, 3.0, 6.0).ravel()[kept]
        levels = trial_levels(y, POINT[kept], TRIAL[kept], np.ones(POINTS))
        u = 0.0 if levels is None else np.mean(levels.u_n**2)
        variances.append(u * counts.mean())
    assert np.mean(variances) == pytest.approx(36.0, abs=3 * np.std(variances) / 20)


@pytest.mark.parametrize("trial", [np.zeros(36, int), np.arange(36)])
def test_trials_that_the_points_do_not_share_have_no_levels(trial):
    y = drawn(np.random.default_rng(1), 1.0, 5.0).ravel()
    assert trial_levels(y, POINT, trial, np.ones(POINTS)) is None


def test_equal_trials_have_no_levels():
    y = np.repeat(np.linspace(1, 2, POINTS), TRIALS)
    assert trial_levels(y, POINT, TRIAL, np.ones(POINTS)) is None


def test_the_part_of_the_weights_is_the_change_of_the_estimators_variance():
    """By a finite change of the slope: weights stay, the scatter of the points is another."""
    rng = np.random.default_rng(6)
    x = rng.standard_normal(10)
    j, step = rng.standard_normal((10, 3)), 1e-6
    inverse = np.linalg.inv(j.T @ j)
    estimator = inverse @ j.T
    maker = np.eye(10) - j @ estimator

    def ratio(c, change):
        variances = np.exp(change * x)
        true = c @ estimator @ np.diag(variances) @ estimator.T @ c
        stated = np.trace(maker @ np.diag(variances)) / 7 * (c @ inverse @ c)
        return true / stated

    spread = parameter_spread(j, 2.0 * inverse, 2.0, np.ones(10), x, None)
    for c in (*np.eye(3), np.array([1.0, -2.0, 0.5])):
        slope = (np.log(ratio(c, step)) - np.log(ratio(c, -step))) / (2 * step)
        assert c @ spread.weights @ c / (c @ spread.residual @ c) == pytest.approx(slope, rel=1e-6)
        u, dof = standard_uncertainty(spread, 7, c[None, :])
        assert u[0] ** 2 == pytest.approx(2.0 * c @ inverse @ c)
        assert dof[0] == pytest.approx(2 / (2 / 7 + slope**2))


def test_a_fit_says_that_its_trials_differ_in_level(trials_curve):
    v = np.linspace(0.005, 0.2, 10)
    friction = 250 + 250 * np.exp(-v / 0.05) + 1500 * v
    rng = np.random.default_rng(7)
    scatter = 2 * rng.standard_normal((10, 3))
    plain = fit_law(TUSTIN_LAW, [trials_curve(v, friction[:, None] + scatter)], Fitting())
    shifted = friction[:, None] + scatter + np.array([-20.0, 0.0, 20.0])
    fit = fit_law(TUSTIN_LAW, [trials_curve(v, shifted)], Fitting())
    assert "level" in fit.message and "level" not in plain.message
    shift = 20 / np.sqrt(3)  # of the mean of three trials with a standard deviation of 20 N
    for name in ("f_coulomb_n", "f_stiction_n"):
        wider, own = fit.parameters[name], plain.parameters[name]
        assert wider.se == pytest.approx(np.hypot(own.se, shift), rel=0.03)
        low, high = wider.ci95  # t: 2.45 of six degrees of freedom and 4.3 of two
        assert min(wider.value - low, high - wider.value) > 2.5 * wider.se
    b = fit.parameters["b_viscous_n_s_m"]
    assert b.se == pytest.approx(plain.parameters["b_viscous_n_s_m"].se, rel=0.05)
