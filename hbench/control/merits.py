"""Figures of merit: bandwidth, margins, overshoot, settling, ramp error."""

from typing import NamedTuple

import numpy as np
from scipy.signal import lti

from hbench.control.transfer import TransferFunction

DB_3 = 1 / np.sqrt(2)
DIVERGED = 1e60  # of a unit step's response: far below the largest float


class Margins(NamedTuple):
    """Distance of an open loop from -1. Infinite where there is no crossing."""

    gain: float  # factor that the gain may grow by
    gain_rad_s: float  # where the phase is -180 degrees
    phase_deg: float
    phase_rad_s: float  # where the gain is 1

    @property
    def gain_db(self) -> float:
        """Gain margin in dB."""
        return float(20 * np.log10(self.gain))


def margins(omega: np.ndarray, response: np.ndarray) -> Margins:
    """Return the worst margins of an open loop's ``response`` over ``omega`` [rad/s], rising.

    Crossings are interpolated in log magnitude and phase over log frequency, so that the grid
    need not be very fine. Margins of a loop that is unstable when closed mean nothing.
    """
    log_w, log_gain = np.log(omega), np.log(np.abs(response))
    phase = np.unwrap(np.angle(response))
    at_gain = _crossings(log_gain)
    phases = np.angle(-np.exp(1j * _at(phase, at_gain)))  # above -180 degrees, of any turn
    phase_margin, phase_at = _least(phases, _at(log_w, at_gain))
    turns = np.arange(np.ceil(phase.min() / (2 * np.pi) - 0.5), phase.max() / (2 * np.pi) + 0.5)
    crossings = [_crossings(phase + np.pi - 2 * np.pi * n) for n in turns]
    at_phase = np.concatenate([np.zeros(0), *crossings])
    gain_margin, gain_at = _least(-_at(log_gain, at_phase), _at(log_w, at_phase))
    return Margins(
        float(np.exp(gain_margin)),
        float(np.exp(gain_at)),
        float(np.degrees(phase_margin)),
        float(np.exp(phase_at)),
    )


def _crossings(y: np.ndarray) -> np.ndarray:
    """Return the fractional indices where ``y`` passes zero."""
    i = np.flatnonzero((y[:-1] > 0) != (y[1:] > 0))
    return i + y[i] / (y[i] - y[i + 1])


def _at(y: np.ndarray, index: np.ndarray) -> np.ndarray:
    return np.interp(index, np.arange(len(y)), y)


def _least(values: np.ndarray, at: np.ndarray) -> tuple[float, float]:
    if not len(values):
        return np.inf, np.inf
    least = int(np.argmin(values))
    return values[least], at[least]


def bandwidth(omega: np.ndarray, closed: np.ndarray) -> float:
    """Return where a closed loop's gain first falls 3 dB below 1 [rad/s]; inf if it does not.

    Its static gain is 1, as every loop here integrates.
    """
    crossings = _crossings(np.log(np.abs(closed) / DB_3))
    return float(np.exp(_at(np.log(omega), crossings[:1])[0])) if len(crossings) else np.inf


class StepMerits(NamedTuple):
    """Overshoot of a unit step response, and the time until it stays within 2 %."""

    overshoot: float  # inf: the response diverges
    settling_s: float  # inf: not within the time given


def step_merits(t_s: np.ndarray, y: np.ndarray) -> StepMerits:
    """Return the merits of a step response towards 1, NaN once it has diverged."""
    if not np.isfinite(y).all():
        return StepMerits(np.inf, np.inf)
    outside = np.flatnonzero(np.abs(y - 1.0) > 0.02)
    last = int(outside[-1]) + 1 if len(outside) else 0
    settling = float(t_s[last]) if last < len(t_s) else np.inf
    return StepMerits(max(0.0, float(y.max()) - 1.0), settling)


def step_response(closed: TransferFunction, t_s: np.ndarray) -> np.ndarray:
    """Return the unit step response of a closed loop at the even times ``t_s``.

    It is NaN where an unstable pole has grown beyond ``DIVERGED``.
    """
    y = np.full(len(t_s), np.nan)
    kept = t_s * closed.poles.real.max() < np.log(DIVERGED)
    if kept.sum() > 1:
        _, y[kept] = lti(closed.numerator, closed.denominator).step(T=t_s[kept])
    return y


def velocity_constant(open_loop: TransferFunction) -> float:
    """Return K_v = lim s G(s) for s to 0 [1/s], equation 4.38: of a loop with one integrator."""
    *rest, last = open_loop.denominator
    if last != 0.0:
        return 0.0  # type 0
    return open_loop.numerator[-1] / rest[-1]


def ramp_error(open_loop: TransferFunction, slope: float) -> float:
    """Return the steady error at a ramp, slope / K_v, equation 4.37 with its subscript."""
    constant = velocity_constant(open_loop)
    return slope / constant if constant else np.inf
