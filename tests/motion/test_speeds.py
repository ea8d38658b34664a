"""Speeds over blocks, against exact signals and their own scatter."""

import numpy as np
import pytest

from hbench.motion.speeds import block_speeds, mean_speed

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


def test_noise_of_block_speeds_is_their_scatter():
    rng = np.random.default_rng(4)
    t = np.arange(50000) / 100
    speeds = block_speeds(t, 0.05 * t + 3e-5 * rng.standard_normal(len(t)), 0.1)
    assert speeds.noise_m_s == pytest.approx(np.std(speeds.v_m_s), rel=0.05)
