"""Coarse steps of a log are a part of U, unless noise averages them out."""

import numpy as np
import pytest

from hbench.analysis.screening.log_steps import rounding_error


def rounded_means(noise, draws=1000, n=2000, seed=1):
    """Return the errors of means of values rounded to whole numbers, at places in between."""
    rng = np.random.default_rng(seed)
    truth = rng.uniform(0, 1, draws)
    values = np.rint(truth[:, None] + noise * rng.standard_normal((draws, n)))
    return values, values.mean(axis=1) - truth


def test_without_noise_the_error_is_that_of_drawn_samples():
    values, errors = rounded_means(noise=0.0)
    stated = np.sqrt(np.mean([rounding_error(each, 1.0) ** 2 for each in values]))
    assert stated == pytest.approx(np.std(errors), rel=0.03)


@pytest.mark.parametrize("noise", [0.1, 0.2, 0.3, 0.4])
def test_with_little_noise_the_stated_error_is_not_too_small(noise):
    values, errors = rounded_means(noise)
    stated = np.sqrt(np.mean([rounding_error(each, 1.0) ** 2 for each in values]))
    by_scatter = np.mean(values.var(axis=1)) / values.shape[1]
    by_rounding = np.sqrt(max(np.mean(errors**2) - by_scatter, 0.0))
    assert 0.95 * by_rounding < stated < np.sqrt(1 / 12)


def test_noise_of_a_step_averages_the_rounding_out():
    values, errors = rounded_means(noise=1.0)
    assert max(rounding_error(each, 1.0) for each in values) < 1e-4
    assert np.std(errors) == pytest.approx(1 / np.sqrt(values.shape[1]), rel=0.1)


def test_values_without_steps_have_no_such_error():
    assert rounding_error(np.array([1.0, 1.0]), 0.0) == 0.0
