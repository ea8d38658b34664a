"""Rests of a position with noise, also at the ends of a log."""

import numpy as np
import pytest

from hbench.motion.standstill import standstill

DT = 0.01


def position(rest_s, noise_m, seed=0):
    """The piston rests, then moves at 50 mm/s for 1 s."""
    t = DT * np.arange(round((rest_s + 1.0) / DT))
    noise = noise_m * np.random.default_rng(seed).standard_normal(len(t))
    return t, 0.1 + 0.05 * np.maximum(t - rest_s, 0.0) + noise


@pytest.mark.parametrize("noise_m", [1e-9, 2e-6])
def test_a_rest_at_the_ends_of_a_log_that_is_too_short_has_no_velocity_of_the_motion(noise_m):
    _, x = position(0.2, noise_m)
    for own in (x, x[::-1]):
        at_rest, _ = standstill(own, DT)
        assert not at_rest.any()


@pytest.mark.parametrize("noise_m", [1e-9, 2e-6])
def test_a_longer_one_ends_with_the_motion(noise_m):
    t, x = position(0.6, noise_m)
    at_rest, v = standstill(x, DT)
    assert at_rest[t < 0.55].all() and not at_rest[t > 0.65].any()
    assert np.abs(v[at_rest & (t < 0.5)]).max() < 30 * noise_m
    backwards, _ = standstill(x[::-1], DT)
    assert backwards[::-1][t < 0.55].all()


def test_a_log_that_is_shorter_than_a_rest_has_none():
    at_rest, v = standstill(np.full(20, 0.1), DT)
    assert not at_rest.any() and len(v) == 20
