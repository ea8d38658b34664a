"""The filters of appendix D against scipy's lfilter on the same difference equations."""

import numpy as np
import pytest
from scipy.signal import lfilter

T = 1e-4


@pytest.fixture(scope="module")
def noise():
    return np.random.default_rng(11)


@pytest.mark.parametrize("tau", [0.0, 5e-4, 2e-3, 2e-2])
def test_velocity_filter_is_equation_d11(tau, noise, probes):
    t = T * np.arange(20_000)
    x = (0.2 + 0.1 * np.sin(5 * t) + 1e-5 * noise.standard_normal(t.size)).astype(np.float32)
    x[0] = 0.0
    expected = lfilter([1 / (tau + T), -1 / (tau + T)], [1, -tau / (tau + T)], x.astype(float))
    np.testing.assert_allclose(probes.velocity(tau, T, x), expected, atol=2e-6 * np.ptp(expected))


def test_velocity_of_a_ramp_settles_at_its_slope_with_the_time_constant(probes):
    t = T * np.arange(500)
    v = probes.velocity(5e-3, T, (0.1 * t).astype(np.float32))
    expected = 0.1 * (1 - (5e-3 / (5e-3 + T)) ** np.arange(500))
    np.testing.assert_allclose(v, expected, atol=1e-5)


@pytest.mark.parametrize("tau", [0.0, 5e-4, 5e-3])
def test_pressure_filter_is_equation_d29(tau, noise, probes):
    p = (8e6 + 1e5 * noise.standard_normal(20_000)).astype(np.float32)
    expected = lfilter([T / (tau + T)], [1, -tau / (tau + T)], p.astype(float))
    np.testing.assert_allclose(probes.lowpass(tau, T, p), expected, rtol=1e-6, atol=1.0)


@pytest.mark.parametrize("divider", [1, 2, 7, 100, 65535])
def test_log_means_are_the_fir_filter_d1_sampled_once_a_record(divider, noise, probes):
    words = noise.integers(0, 65521, 2 * 65535, dtype=np.uint16)
    fir = lfilter(np.ones(divider) / divider, 1, words) if divider < 1000 else None
    means = probes.mean(divider, words)
    assert means.size == words.size // divider
    if fir is None:
        fir = np.repeat(words.astype(float).reshape(-1, divider).mean(axis=1), divider)
    sampled = fir[divider - 1 :: divider]
    assert np.max(np.abs(means - sampled)) <= 0.5 + 1e-6


def test_log_means_are_exact_at_full_scale(probes):
    words = np.full(65535, 65535, np.uint16)
    assert probes.mean(65535, words).tolist() == [65535]
