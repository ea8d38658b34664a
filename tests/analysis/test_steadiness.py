"""Speed, ripple and drift, against exact signals and against their own scatter."""

import numpy as np
import pytest

from hbench.analysis.screening.steadiness import drift, speed_ripple
from hbench.report.conformity.certificate.english import ENGLISH
from hbench.report.conformity.certificate.german import GERMAN

T = np.arange(150) / 100


@pytest.mark.parametrize("n", [30, 60, 150, 400])
def test_noise_alone_passes_a_ripple_limit_of_zero_in_all_but_some_in_a_thousand(n):
    rng = np.random.default_rng(n)
    t = np.arange(n) / 100
    runs = [speed_ripple(t, 3e-5 * rng.standard_normal(n)) for _ in range(2000)]
    over = np.mean([run.total_m_s > run.noise_m_s for run in runs])
    assert over < 0.005


def test_ripple_of_a_slow_oscillation_is_its_standard_deviation():
    t = np.arange(300) / 100
    x = 0.05 * t + 0.004 / (2 * np.pi) * np.sin(2 * np.pi * t)
    # Speeds between neighbouring block means are 0.1 s means twice: sinc(0.1)^2 at 1 Hz.
    expected = 0.004 / np.sqrt(2) * np.sinc(0.1) ** 2
    assert speed_ripple(t, x).total_m_s == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize(("hz", "share"), [(1.0, 0.97), (5.0, 0.41), (10.0, 0.0)])
def test_documents_state_the_share_of_a_ripple_that_is_contained(hz, share):
    """In logs of any rate, and whatever the phase of the ripple."""
    for texts in (ENGLISH, GERMAN):
        assert share == 0.0 or f"{100 * share:.0f} %" in texts["method_speed_ripple"]
    for rate, phase in ((200, 0.3), (1000, 1.7), (500, 4.0)):
        t = np.arange(12 * rate) / rate
        x = 0.02 * t + 0.001 / (2 * np.pi * hz) * np.sin(2 * np.pi * hz * t + phase)
        found = [speed_ripple(t[i:], x[i:]).total_m_s for i in range(0, rate // 5, 7)]
        measured = np.sqrt(np.mean(np.square(found))) / (0.001 / np.sqrt(2))
        assert measured == pytest.approx(share, abs=0.03)


def test_drift_of_a_straight_line_is_its_rise():
    found = drift(T, 300 + 20 * T)
    assert found.value == pytest.approx(20 * (T[-1] - T[0]), rel=1e-12)
    assert found.se == pytest.approx(0, abs=1e-9)


def test_standard_error_of_the_drift_is_its_scatter():
    rng = np.random.default_rng(5)
    found = [drift(T, 20 * rng.standard_normal(len(T))) for _ in range(2000)]
    scatter = np.std([one.value for one in found])
    assert np.mean([one.se for one in found]) == pytest.approx(scatter, rel=0.08)
    assert abs(np.mean([one.value for one in found])) < 4 * scatter / np.sqrt(2000)


def test_drift_is_not_moved_by_a_spike_at_the_end():
    rng = np.random.default_rng(6)
    y = 300 + rng.standard_normal(len(T))
    spiked = y.copy()
    spiked[-3:] += 2000
    assert abs(drift(T, spiked).value - drift(T, y).value) < 1
    assert abs(np.polyfit(T, spiked, 1)[0]) > 100  # least squares is moved
