"""Recursive least squares against the closed form and what forgetting is for."""

import numpy as np
import pytest

from hbench.analysis.identification.recursive import Estimate, update

TRUTH = np.array([120.0, 80.0, 400.0])


def data(n=300, seed=0, truth=TRUTH, noise=2.0):
    rng = np.random.default_rng(seed)
    phi = rng.uniform(-1, 1, (n, 3))
    return phi, phi @ truth + noise * rng.standard_normal(n)


def run(phi, force, forgetting=1.0, p0=100.0, theta0=(50.0, 60.0, 70.0)):
    estimate = Estimate(np.array(theta0), p0 * np.eye(3))
    for row, f in zip(phi, force, strict=True):
        estimate = update(estimate, row, f, forgetting)
    return estimate


def test_without_forgetting_it_is_the_batch_solution():
    phi, force = data()
    found = run(phi, force)
    p = np.linalg.inv(np.eye(3) / 100.0 + phi.T @ phi)
    np.testing.assert_allclose(found.p, p, rtol=1e-9)
    expected = p @ (np.array([50.0, 60.0, 70.0]) / 100.0 + phi.T @ force)
    np.testing.assert_allclose(found.theta, expected, rtol=1e-10)


def test_with_forgetting_it_is_the_batch_solution_with_falling_weights():
    phi, force = data(n=200)
    found = run(phi, force, forgetting=0.95, p0=1e8)
    weight = np.sqrt(0.95 ** np.arange(199, -1, -1))
    expected = np.linalg.lstsq(phi * weight[:, None], force * weight, rcond=None)[0]
    np.testing.assert_allclose(found.theta, expected, rtol=1e-4)


def test_forgetting_follows_elements_that_change_and_without_it_their_mean_remains():
    before, after = data(truth=TRUTH), data(seed=1, truth=0.5 * TRUTH)
    phi, force = (np.concatenate(pair) for pair in zip(before, after, strict=True))
    np.testing.assert_allclose(run(phi, force, 0.95).theta, 0.5 * TRUTH, rtol=0.05)
    np.testing.assert_allclose(run(phi, force, 1.0).theta, 0.75 * TRUTH, rtol=0.1)


def test_the_error_is_the_mean_square_before_each_update():
    phi, force = data(n=3)
    theta, errors = np.array([50.0, 60.0, 70.0]), []
    for k in range(3):
        errors.append(force[k] - phi[k] @ theta)
        theta = run(phi[: k + 1], force[: k + 1]).theta
    assert run(phi, force).error == pytest.approx(np.mean(np.square(errors)))
    assert np.isnan(Estimate(theta, np.eye(3)).error)
