"""Weights from trials: the law of the variances, and what they do to a curve's points."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.analysis.fitting.fit import fit_law
from hbench.analysis.fitting.fit_data import fit_points
from hbench.analysis.fitting.trial_weights import pooled_sigma
from hbench.analysis.fitting.tustin import PARAMETER_NAMES, TUSTIN_LAW, tustin_friction
from hbench.config.fitting import Fitting

SPEEDS = np.linspace(0.005, 0.2, 15)


def test_exact_variances_of_a_power_of_speed_are_found():
    sigma = 4.0 * SPEEDS**0.7
    found = pooled_sigma(SPEEDS, sigma**2, np.full(15, 2.0)).sigma
    np.testing.assert_allclose(found, sigma, rtol=1e-8)


def test_it_is_the_most_likely_law_of_gamma_distributed_variances():
    """Against a general optimiser on the likelihood as scipy.stats has it."""
    from scipy.optimize import minimize
    from scipy.stats import gamma

    rng = np.random.default_rng(5)
    dof = rng.integers(1, 4, 15).astype(float)
    variance = rng.chisquare(dof) / dof * (3.0 * SPEEDS**0.5) ** 2

    def unlikely(line):
        mean = np.exp(line[0] + line[1] * np.log(SPEEDS))
        return -np.sum(gamma.logpdf(variance, dof / 2, scale=2 * mean / dof))

    best = minimize(unlikely, [2.0, 1.0], method="Nelder-Mead", options={"xatol": 1e-9}).x
    expected = np.exp((best[0] + best[1] * np.log(SPEEDS)) / 2)
    np.testing.assert_allclose(pooled_sigma(SPEEDS, variance, dof).sigma, expected, rtol=1e-4)


def test_without_scatter_or_trials_there_are_no_weights():
    assert pooled_sigma(SPEEDS, np.zeros(15), np.full(15, 2.0)) is None
    assert pooled_sigma(SPEEDS, np.ones(15), np.zeros(15)) is None


@pytest.fixture
def with_trials(make_curve):
    """Return a function that makes a curve of trials (15, n)."""

    def make(trials):
        curve = make_curve(SPEEDS, trials.mean(axis=1))
        points = [
            replace(point, trials_n=tuple(own), n=len(own))
            for point, own in zip(curve.points, trials.tolist(), strict=True)
        ]
        return replace(curve, points=tuple(points))

    return make


def test_a_point_of_two_trials_weighs_two_thirds_of_one_of_three(with_trials):
    rng = np.random.default_rng(2)
    curve = with_trials(500 + rng.standard_normal((15, 3)))
    fewer = replace(curve.points[4], trials_n=curve.points[4].trials_n[:2])
    points = (*curve.points[:4], fewer, *curve.points[5:])
    sigma = fit_points([replace(curve, points=points)], "trials").sigma
    flat = np.exp(np.interp(np.log(SPEEDS[4]), np.log(SPEEDS[[3, 5]]), np.log(sigma[[3, 5]])))
    assert sigma[4] ** 2 / flat**2 == pytest.approx(1.5, rel=1e-6)
    assert np.mean(sigma**2) == pytest.approx(1.0)


def test_weighted_values_and_errors_are_those_of_curve_fit_with_the_same_sigma(with_trials):
    from scipy.optimize import curve_fit

    rng = np.random.default_rng(3)
    truth = np.array([250.0, 500.0, 0.07, 1500.0])
    trials = tustin_friction(SPEEDS, truth)[:, None] + 30 * SPEEDS[:, None] * rng.standard_normal(
        (15, 3)
    )
    curve = with_trials(trials)
    fit = fit_law(TUSTIN_LAW, [curve], Fitting())
    expected, spread = curve_fit(
        lambda v, *p: tustin_friction(v, np.array(p)),
        SPEEDS,
        trials.mean(axis=1),
        p0=truth,
        sigma=fit_points([curve], "trials").sigma,
        xtol=1e-12,
        ftol=1e-12,
    )
    np.testing.assert_allclose(
        [fit.parameters[n].value for n in PARAMETER_NAMES], expected, rtol=1e-4
    )
    errors = [fit.parameters[n].se for n in PARAMETER_NAMES]
    np.testing.assert_allclose(errors, np.sqrt(np.diag(spread)), rtol=2e-3)
    equal = fit_law(TUSTIN_LAW, [curve], Fitting(weights="equal"))
    assert equal.parameters["f_stiction_n"].value != fit.parameters["f_stiction_n"].value
