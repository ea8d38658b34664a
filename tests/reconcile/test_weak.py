"""Weak derivatives against closed forms: harmonic signals, parabolas, white noise."""

import numpy as np
import pytest
from scipy.special import beta

from hbench.errors import DataError
from hbench.reconcile.measured.session import sessions
from hbench.reconcile.measured.weak import WIDTH_S, sampling, window
from hbench.records import Run, RunPlan, Specimen

DT = 0.01
PLAN = RunPlan("0007", "steady", 1, 0.05, Specimen(1e-3, 8e-4))


def session(n):
    """A log of ``n`` samples."""
    (found,) = sessions([Run(PLAN, t_s=np.arange(n) * DT, x_m=np.zeros(n))])
    return found


def centres(log):
    """Times [s] of the windows' centres, from the edge of the first sample."""
    return log.mean(log.channels["t_s"]) + DT / 2


def means(antiderivative, n=400):
    """Interval means, as the board logs them, of a signal with this antiderivative."""
    edges = np.arange(n + 1) * DT
    return np.diff(antiderivative(edges)) / DT


@pytest.mark.parametrize("hz", [0.3, 1.0, 3.0])
def test_a_signal_that_follows_a_lag_exactly_has_no_residual(hz):
    """x = sin wt and y with y + tau y' = x': the balance holds between interval means too."""
    w, tau = 2 * np.pi * hz, 0.02
    response = 1j * w / (1 + 1j * w * tau)
    x = means(lambda t: np.imag(np.exp(1j * w * t) / (1j * w)))
    y = means(lambda t: np.imag(response * np.exp(1j * w * t) / (1j * w)))
    log = session(len(x))
    residual = log.mean(y) + tau * log.rate(y) - log.rate(x)
    assert np.abs(residual).max() < 1e-4 * w


@pytest.mark.parametrize("hz", [0.5, 2.0])
def test_derivatives_are_those_of_the_windowed_harmonic(hz):
    """The window's own response to exp(iwt), by quadrature, times (iw)^n."""
    w = 2 * np.pi * hz
    s = np.linspace(-1, 1, 20001)
    shape = 315 / 256 * (1 - s**2) ** 4
    gain = np.trapezoid(shape * np.cos(w * WIDTH_S / 2 * s), s) * np.sinc(hz * DT)
    x = means(lambda t: -np.cos(w * t) / w)
    log = session(len(x))
    for order, found in enumerate((log.mean(x), log.rate(x), log.second(x))):
        expected = gain * np.imag((1j * w) ** order * np.exp(1j * w * centres(log)))
        assert np.abs(found - expected).max() < 1e-3 * gain * w**order


def test_parabolas_are_exact():
    x = means(lambda t: 0.3 * t + t**2 / 2 - 2 * t**3 / 3)
    log = session(len(x))
    assert np.allclose(log.rate(x), 1 - 4 * centres(log), atol=1e-11)
    assert np.allclose(log.second(x), -4, atol=1e-9)


def test_noise_of_a_weak_derivative_is_that_of_the_closed_form():
    half = WIDTH_S / 2
    integral = (315 / 256) ** 2 * 64 * beta(1.5, 7) / half**3
    assert integral * half**3 == pytest.approx(630 / 143)
    noise = np.random.default_rng(0).standard_normal(400_000)
    assert session(len(noise)).rate(noise).std() == pytest.approx(np.sqrt(DT * integral), rel=0.01)


def test_windows_overlap_by_half_and_short_logs_have_none():
    one = window(DT)
    assert len(one.value) == 16
    assert one.count(15) == 0
    assert len(session(15).mean(np.zeros(15))) == 0
    assert one.count(16 + 8 * 3) == 4 == len(session(47).mean(np.zeros(16 + 8 * 3 + 7)))


def test_a_gap_in_the_samples_is_told():
    run = Run(PLAN, t_s=np.array([0.0, 0.01, 0.03]), x_m=np.zeros(3))
    with pytest.raises(DataError, match=r"run 0007: .*0\.01 to 0\.02 s"):
        sampling(run)
