"""Lag of the velocity on analytic motions: none offline, that of filter D.11 in the firmware."""

import numpy as np
import pytest

from hbench.analysis.screening.sample_friction import logged_motion
from hbench.errors import DataError
from hbench.motion.speeds import mean_speed
from hbench.records import Run, RunPlan, Specimen
from hbench.store.importing.resampling import interval_means, whole_intervals

TICK_S, RATE_HZ = 1e-4, 100.0
FREQUENCIES_HZ = np.array([0.4, 1.1, 2.7])
SWINGS_M = np.array([0.08, 0.02, 0.004])  # +-0.2, 0.14 and 0.07 m/s
PHASES = np.array([0.3, 1.9, 4.0])
NOISE_M = 2e-5  # of each position in the log


def position(t_s, frequencies=FREQUENCIES_HZ, swings=SWINGS_M):
    angles = 2 * np.pi * np.multiply.outer(t_s, frequencies) + PHASES[: len(frequencies)]
    return 0.2 + np.sin(angles) @ swings


def velocity(t_s, frequencies=FREQUENCIES_HZ, swings=SWINGS_M):
    omega = 2 * np.pi * frequencies
    angles = np.multiply.outer(t_s, omega) + PHASES[: len(frequencies)]
    return np.cos(angles) @ (omega * swings)


def log_of(ticks):
    """Records: means over their ticks, at the middle of their time."""
    return ticks.reshape(-1, round(1 / RATE_HZ / TICK_S)).mean(axis=1)


def logged(t_s, x_m):
    force = np.zeros(len(t_s))
    plan = RunPlan("0001", "triangle", 1, 0.2, Specimen(1e-3, 5e-4))
    return Run(plan, t_s, x_m, p_tp_pa=force, p_tr_pa=force, f_applied_n=force)


def lag_s(t_s, v_m_s):
    """Delay of the maximum correlation with the true velocity, to 1 us, without the ends.

    Normalised by the true velocity's size: else the peak goes where more of it lies in the window.
    """
    inner = slice(10, -10)
    best, width = 0.0, 0.03
    for _ in range(12):
        delays = best + np.linspace(-width, width, 41)
        shifted = [velocity(t_s[inner] - delay) for delay in delays]
        fits = [v_m_s[inner] @ true / np.linalg.norm(true) for true in shifted]
        best, width = delays[int(np.argmax(fits))], width / 4
    return best


@pytest.fixture
def ticks():
    t = TICK_S * np.arange(200_000)
    return t, position(t)


def test_velocity_of_a_log_has_no_lag_and_the_firmwares_has_its_filters(ticks, probes):
    t, x = ticks
    rng = np.random.default_rng(4)
    t_log, x_log = log_of(t), log_of(x)
    ours = logged_motion(logged(t_log, x_log + NOISE_M * rng.standard_normal(len(t_log))), 0.0)
    ours_s = lag_s(t_log, ours.v_m_s)
    print(f"\nlag of the velocity offline: {1e6 * ours_s:.1f} us of a sample of 10 ms")
    assert abs(ours_s) < 0.01 / RATE_HZ
    for tau in (2e-3, 10e-3):
        board = probes.velocity(tau, TICK_S, x.astype(np.float32)).astype(float)
        board[:1000] = velocity(t[:1000])  # starts at x = 0
        # the filter's own tau, and half a tick of the difference
        board_s = lag_s(t_log, log_of(board))
        print(f"of the firmware's filter with tau = {1e3 * tau:g} ms: {1e3 * board_s:.3f} ms")
        assert board_s == pytest.approx(tau + TICK_S / 2, rel=0.02)


@pytest.mark.parametrize("frequency_hz", [0.5, 2.0, 5.0, 10.0, 15.0])
def test_gain_is_that_of_the_published_coefficients_times_the_records_mean(frequency_hz):
    # Savitzky and Golay, first derivative, 7 points, third and fourth order
    weights = np.array([58, 67, -22]) / 252
    angles = 2 * np.pi * frequency_hz / RATE_HZ * np.arange(1, 4)
    of_polynomial = 2 * weights @ np.sin(angles) / angles[0]
    of_mean = np.sinc(frequency_hz / RATE_HZ)
    t = TICK_S * np.arange(100_000)
    sine = np.array([frequency_hz]), np.array([0.01])
    t_log = log_of(t)
    measured = logged_motion(logged(t_log, log_of(position(t, *sine))), 0.0).v_m_s[10:-10]
    truth = velocity(t_log[10:-10], *sine)
    quarter = velocity(t_log[10:-10] + 0.25 / frequency_hz, *sine)
    basis = np.column_stack([truth, quarter])
    gain, shifted = np.linalg.lstsq(basis, measured, rcond=None)[0]
    assert gain == pytest.approx(of_polynomial * of_mean, abs=2e-4)
    assert shifted == pytest.approx(0, abs=2e-4)
    if frequency_hz <= 5:
        assert 1 - gain < 0.01


def test_an_uneven_log_has_no_lag_once_it_is_resampled():
    rng = np.random.default_rng(9)
    t = np.cumsum(rng.uniform(0.3, 1.7, 10_000)) / 500
    x = position(t) + NOISE_M * rng.standard_normal(len(t))
    with pytest.raises(DataError):
        logged_motion(logged(t, x), 0.0)
    starts = whole_intervals(t, RATE_HZ, 0.1)
    even = logged(starts + 0.5 / RATE_HZ, interval_means(t, x, starts, RATE_HZ))
    assert abs(lag_s(even.t_s, logged_motion(even, 0.0).v_m_s)) < 0.01 / RATE_HZ


def test_mean_speed_of_an_uneven_log_with_gaps_is_unbiased_with_the_variance_of_least_squares():
    rng = np.random.default_rng(2)
    t = np.cumsum(rng.uniform(0.1, 1.9, 300)) / 100
    t = t + 0.4 * (t > 1) + 0.15 * (t > 2.2)  # two gaps
    v, spread = 0.0123, NOISE_M / np.sqrt(np.sum((t - t.mean()) ** 2))
    noise = NOISE_M * rng.standard_normal((2000, len(t)))
    speeds = np.array([mean_speed(t, 0.1 + v * t + e) for e in noise])
    assert speeds.mean() == pytest.approx(v, abs=4 * spread / np.sqrt(2000))
    assert speeds.std(ddof=1) == pytest.approx(spread, rel=0.06)
