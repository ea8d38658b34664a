"""Noise of a signal from its own samples, against noise of known size."""

import numpy as np
import pytest

from hbench.motion.noise import (
    noise_of_differences,
    noise_over_motion,
    position_noise,
    resolution,
    robust_sigma,
)


def test_robust_sigma_is_the_standard_deviation_of_normal_deviations_with_outliers():
    deviations = 3.0 * np.random.default_rng(1).standard_normal(100_000)
    assert robust_sigma(deviations) == pytest.approx(3.0, rel=0.01)
    deviations[:1000] = 1e6
    assert robust_sigma(deviations) == pytest.approx(3.0, rel=0.03)
    assert robust_sigma(np.zeros(0)) == 0.0


@pytest.mark.parametrize("order", [1, 2])
def test_differences_of_white_noise_give_its_standard_deviation(order):
    y = 0.2 * np.random.default_rng(2).standard_normal(100_000)
    assert noise_of_differences(np.diff(y, order), order) == pytest.approx(0.2, rel=0.02)


@pytest.mark.parametrize("even", [True, False])
def test_position_noise_is_found_under_motion(even):
    rng = np.random.default_rng(3)
    t = np.arange(20000) / 100 if even else np.cumsum(rng.uniform(0.002, 0.02, 20000))
    x = 0.05 * t + 1e-3 * np.sin(2 * t) + 2e-5 * rng.standard_normal(20000)
    assert position_noise(t, x) == pytest.approx(2e-5, rel=0.03)


def test_noise_is_found_where_the_piston_also_accelerates():
    rng = np.random.default_rng(8)
    t = np.arange(400) / 20
    x = 0.2 * np.maximum(0, t - 15) + 2e-5 * rng.standard_normal(len(t))
    x[:20] += 0.5 * np.cumsum(np.linspace(0, 0.02, 20))
    assert noise_over_motion(t, x) == pytest.approx(2e-5, rel=0.25)
    assert position_noise(t, x) > 1e-4  # the root mean square counts the acceleration


@pytest.mark.parametrize("step", [1e-5, 1e-4])
def test_a_coarse_sensor_has_the_noise_of_its_resolution(step):
    t = np.arange(3000) / 1000
    x = step * np.rint(0.0017 * t / step)
    assert resolution(x) == pytest.approx(step)
    assert noise_over_motion(t, x) == pytest.approx(step / np.sqrt(12))


def test_a_smooth_motion_has_no_resolution():
    t = np.arange(300) / 100
    assert resolution(0.05 * t + 0.01 * np.sin(t)) < 1e-6 and resolution(0.05 * t) == 0.0
