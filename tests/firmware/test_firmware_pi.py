"""The PI of equation D.18: linear against scipy, clamped against double precision."""

import numpy as np
import pytest
from scipy.signal import lfilter

T = 1e-4
LOOPS = {  # K_c, tau_c (table 4.1; rod side repaired), size of the error
    "velocity": (800.0, 0.06, 0.02),
    "rod": (1.25e-5, 0.33, 2e5),
    "piston": (6.5e-5, 0.25, 1e5),
}


def reference(gain, tau, e, limit):
    """D.18 in double precision, the clamped value stored."""
    u, before, out = 0.0, 0.0, []
    for now in e.astype(float):
        u = np.clip(gain * tau * now - gain * tau * before + gain * T * now + u, -limit, limit)
        before = now
        out.append(u)
    return np.array(out)


def errors(size, n=20_000):
    t = T * np.arange(n)
    slow, fast = np.sin(9 * t), 0.3 * np.sin(140 * t + 1)
    return (size * (slow + fast)).astype(np.float32)


@pytest.mark.parametrize("loop", LOOPS)
def test_unclamped_pi_is_equation_d18(loop, probes):
    gain, tau, size = LOOPS[loop]
    e = errors(size)
    expected = lfilter([gain * (tau + T), -gain * tau], [1, -1], e.astype(float))
    u = probes.pi(gain, tau, T, 1e9)(e)
    np.testing.assert_allclose(u, expected, atol=2e-5 * np.ptp(expected))


@pytest.mark.parametrize("loop", LOOPS)
def test_clamped_pi_agrees_with_double_precision(loop, probes):
    gain, tau, size = LOOPS[loop]
    e = errors(30 * size)
    u = probes.pi(gain, tau, T, 10.0)(e)
    expected = reference(gain, tau, e, 10.0)
    assert np.mean(np.abs(expected) == 10.0) > 0.1, "the case must reach the clamp"
    np.testing.assert_allclose(u, expected, atol=1e-3)


@pytest.mark.parametrize("loop", LOOPS)
def test_pi_leaves_the_limit_when_the_error_changes_sign(loop, probes):
    gain, tau, size = LOOPS[loop]
    e = np.full(50_000, 30 * size, np.float32)
    e[40_000:] = -0.01 * size
    u = probes.pi(gain, tau, T, 10.0)(e)
    assert np.all(u[30_000:40_000] == 10.0)
    assert u[40_000] < 10.0
    assert np.all(np.diff(u[40_000:]) <= 0.0)
