"""Figures of merit against closed forms."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hbench.control.merits import bandwidth, margins, step_merits, step_response
from hbench.control.transfer import TransferFunction

OMEGA = np.geomspace(1e-3, 1e4, 6000)


@given(k=st.floats(0.05, 20.0))
def test_margins_of_an_integrator_with_two_lags(k):
    """k / (s (s+1) (s+2)): gain margin 6/k at sqrt(2) rad/s; phase margin where |L| = 1."""
    loop = TransferFunction((k,), (1.0, 3.0, 2.0, 0.0))
    found = margins(OMEGA, loop(1j * OMEGA))
    assert found.gain == pytest.approx(6 / k, rel=1e-4)
    assert found.gain_rad_s == pytest.approx(np.sqrt(2), rel=1e-4)
    # omega^2 (omega^2 + 1) (omega^2 + 4) = k^2
    squares = np.roots([1.0, 5.0, 4.0, -(k**2)])
    crossing = np.sqrt(squares[(abs(squares.imag) < 1e-9) & (squares.real > 0)].real[0])
    assert found.phase_rad_s == pytest.approx(crossing, rel=1e-4)
    phase = 180 - 90 - np.degrees(np.arctan(crossing) + np.arctan(crossing / 2))
    assert found.phase_deg == pytest.approx(phase, abs=0.05)


def test_the_worst_of_several_crossings_counts():
    """A resonance lifts the gain over 0 dB twice more; the phase is worse there."""
    loop = TransferFunction((0.2 * 400.0,), np.polymul([1.0, 0.0], [1.0, 0.4, 400.0]))
    found = margins(OMEGA, loop(1j * OMEGA))
    assert found.gain == pytest.approx(0.4 / 0.2, rel=1e-3)  # 2 zeta omega / k
    slow = margins(OMEGA[OMEGA < 5], loop(1j * OMEGA[OMEGA < 5]))
    assert slow.phase_deg == pytest.approx(90.0, abs=0.1)


def test_a_first_order_loop_has_no_gain_margin_and_its_pole_as_bandwidth():
    loop = TransferFunction((37.0,), (1.0, 0.0))
    found = margins(OMEGA, loop(1j * OMEGA))
    assert found.gain == np.inf and found.phase_deg == pytest.approx(90.0)
    assert bandwidth(OMEGA, loop.closed(1j * OMEGA)) == pytest.approx(37.0, rel=1e-4)


@pytest.mark.parametrize("zeta", [0.3, 0.5, 0.8])
def test_overshoot_and_settling_of_a_second_order_loop(zeta):
    omega = 20.0
    closed = TransferFunction((omega**2,), (1.0, 2 * zeta * omega, omega**2))
    t = np.arange(0, 3, 1e-4)
    found = step_merits(t, step_response(closed, t))
    assert found.overshoot == pytest.approx(np.exp(-np.pi * zeta / np.sqrt(1 - zeta**2)), rel=1e-3)
    envelope = -np.log(0.02 * np.sqrt(1 - zeta**2)) / (zeta * omega)
    assert 0.6 * envelope < found.settling_s <= envelope


def test_a_loop_that_does_not_settle_says_so():
    t = np.arange(0, 1, 1e-3)
    assert step_merits(t, 1 + np.sin(50 * t)).settling_s == np.inf


@pytest.mark.parametrize("pole", [40.0, 1e4, 1e9])
def test_a_response_that_diverges_has_no_finite_merits(pole):
    """1 / (s - pole - 1) closed is 1 / (s - pole): e^(pole t) would exceed the largest float."""
    t = np.linspace(0, 20, 2001)
    y = step_response(TransferFunction([1.0], [1.0, -pole - 1]).closed, t)
    assert np.isnan(y[-1]) and not np.isinf(y).any()
    assert step_merits(t, y) == (np.inf, np.inf)
