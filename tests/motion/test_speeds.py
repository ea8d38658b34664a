"""Speeds over blocks and the noise of a position, against exact signals and their own scatter."""

import numpy as np
import pytest

from hbench.motion.speeds import (
    block_speeds,
    mean_speed,
    noise_over_motion,
    position_noise,
    resolution,
)

T = np.arange(150) / 100


def uneven(rng, n=150):
    return np.cumsum(rng.uniform(0.002, 0.02, n))


def test_mean_speed_is_the_least_squares_slope():
    rng = np.random.default_rng(1)
    t, x = uneven(rng), rng.standard_normal(150)
    assert mean_speed(t, x) == pytest.approx(np.polyfit(t, x, 1)[0], rel=1e-9)


def test_block_speeds_of_a_straight_motion_are_its_speed_for_even_and_uneven_times():
    rng = np.random.default_rng(2)
    for t in (T, uneven(rng), T[np.r_[0:40, 75:150]]):
        np.testing.assert_allclose(block_speeds(t, 0.3 - 0.02 * t, 0.1).v_m_s, -0.02, rtol=1e-9)


def test_block_speeds_count_a_tenth_of_a_second_each():
    assert len(block_speeds(T, T, 0.1).v_m_s) == 14


@pytest.mark.parametrize("even", [True, False])
def test_position_noise_is_found_under_motion(even):
    rng = np.random.default_rng(3)
    t = np.arange(20000) / 100 if even else uneven(rng, 20000)
    x = 0.05 * t + 1e-3 * np.sin(2 * t) + 2e-5 * rng.standard_normal(20000)
    assert position_noise(t, x) == pytest.approx(2e-5, rel=0.03)


def test_noise_of_block_speeds_is_their_scatter():
    rng = np.random.default_rng(4)
    t = np.arange(50000) / 100
    speeds = block_speeds(t, 0.05 * t + 3e-5 * rng.standard_normal(len(t)), 0.1)
    assert speeds.noise_m_s == pytest.approx(np.std(speeds.v_m_s), rel=0.05)


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
