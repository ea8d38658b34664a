"""Friction of a logged run at each sample.

    F_fT = F_T - F_applied - m_T a        (2.12, with the inertia of the test side alone)

Velocity and acceleration come from the position: a polynomial of fourth order through the samples
of 60 ms (Savitzky and Golay), seven at least, which has no lag. It suits reversals and ramps, but
not steps of the reference. At rest the velocity is the slope over 0.3 s: noise would relax the
bristles of a friction law, since the mean of |v| is not 0, and a fit would then find another static
friction and a sigma_1 that does not exist. A rest includes the samples before and after these 0.3 s
whose position is still that of the rest, within its noise.
"""

from dataclasses import dataclass

import numpy as np

from hbench.analysis.screening.friction_channels import (
    friction_channels,
    friction_with_inertia,
    missing_friction_channels,
)
from hbench.errors import DataError
from hbench.motion.noise import noise_over_motion, resolution, robust_sigma
from hbench.records import Run
from hbench.records.identification import MEMORY_M
from hbench.sentences import listed

_WINDOW_S, _FEWEST, _ORDER = 0.06, 7, 4  # samples at least; of the polynomial
REST_S, STILL = 0.3, 8.0  # at rest the position stays within so many deviations for so long
_RESIDUAL = 0.66  # of white noise, what a polynomial of seven samples leaves
_ALIKE = 2.5  # deviations of the smoothed position; twice as many are motion


@dataclass(frozen=True)
class LoggedMotion:
    """Samples of a run, evenly spaced by ``dt_s``; each is a mean over its interval."""

    run: str
    dt_s: float
    v_m_s: np.ndarray  # (n,)
    p_p_pa: np.ndarray  # (n,) test cylinder, piston side; 0 without hydraulics
    p_r_pa: np.ndarray  # (n,) rod side; 0 for a plunger
    friction_n: np.ndarray  # (n,)
    compared: np.ndarray  # (n,) bool; False in the first 20 mm: the initial state is unknown
    f_applied_n: np.ndarray  # (n,) load cell, including the load side's inertia
    one_sided: int = _FEWEST // 2  # samples at each end whose derivatives are not centred

    @property
    def centred(self) -> slice:
        """The samples whose derivatives are not one-sided."""
        return slice(self.one_sided, len(self.v_m_s) - self.one_sided)


def logged_motion(run: Run, mass_kg: float) -> LoggedMotion:
    """Return friction and motion of a whole run; ``mass_kg`` is the test side's.

    Raises ``DataError`` if a channel or a record is missing.
    """
    from scipy.ndimage import maximum_filter1d, minimum_filter1d  # slow import
    from scipy.signal import savgol_coeffs, savgol_filter  # slow import

    missing = missing_friction_channels(run)
    if missing:
        raise DataError(f"run {run.plan.run}: friction needs {listed(missing)}")
    steps = np.diff(run.t_s)
    dt = float(np.median(steps)) if len(steps) else np.inf
    window = max(_FEWEST, _odd(_WINDOW_S / dt))
    if len(run.t_s) < window:
        raise DataError(f"run {run.plan.run}: has {len(run.t_s)} samples; limit {window}")
    if np.abs(steps - dt).max() > 0.01 * dt:
        raise DataError(
            f"run {run.plan.run}: its samples are not evenly spaced ({steps.min():.4g} to "
            f"{steps.max():.4g} s)",
            f"Without gaps, write 'resample: {0.5 / dt:.2g} Hz' in the import map.",
        )
    smooth, v, a = (
        savgol_filter(run.x_m, window, _ORDER, deriv=order, delta=dt) for order in (0, 1, 2)
    )
    long = max(window, _odd(REST_S / dt))
    if len(run.t_s) >= long:
        noise_m = _noise(run, smooth)
        kept = savgol_coeffs(window, _ORDER)[window // 2]  # of white noise's variance, in a value
        level, slope = (savgol_filter(run.x_m, long, 1, deriv=order) for order in (0, 1))
        span = maximum_filter1d(run.x_m, long) - minimum_filter1d(run.x_m, long)
        within = _ALIKE * noise_m * float(np.sqrt(kept))
        at_rest, step = _rests(span <= STILL * noise_m, long // 2, smooth, level, slope, within)
        v, a = np.where(at_rest, step / dt, v), np.where(at_rest, 0.0, a)
    return LoggedMotion(
        run=run.plan.run,
        dt_s=dt,
        v_m_s=v,
        p_p_pa=_pressure(run, "p_tp_pa"),
        p_r_pa=_pressure(run, "p_tr_pa"),
        friction_n=friction_with_inertia(run) - mass_kg * a,
        compared=np.cumsum(np.abs(v)) * dt > MEMORY_M,
        f_applied_n=run.channel("f_applied_n"),
        one_sided=window // 2,
    )


def _odd(samples: float) -> int:
    """Return the odd number of samples next to some intervals and one more."""
    return 2 * round(samples / 2) + 1 if np.isfinite(samples) else 1


def _noise(run: Run, smooth: np.ndarray) -> float:
    """Return the standard deviation of the position's noise [m].

    A fast oscillation also bends between samples, as noise does; the ``smooth`` position (n,)
    follows it, so the smaller of two estimates counts, each at least the sensor's resolution.
    """
    residual = robust_sigma(run.x_m - smooth) / _RESIDUAL
    noise = max(residual, resolution(run.x_m) / np.sqrt(12))
    return min(noise_over_motion(run.t_s, run.x_m), noise)


def _rests(
    still: np.ndarray,
    half: int,
    smooth: np.ndarray,
    level: np.ndarray,
    slope: np.ndarray,
    within_m: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return which samples are at rest (n,), and their change of position per sample (n,) [m].

    ``still`` (n,) is true in the middle of windows without motion, of ``half`` samples to each
    side; ``level`` and ``slope`` (n,) are the lines through the windows. Before and after the
    windows that are all rest, the piston rests as long as the ``smooth`` position is within
    ``within_m`` of the line through the nearest of these. Its distance from the line at the
    outermost sample is the travel of the outermost 60 ms, so that no travel is lost.
    """
    at_rest, step, last = np.zeros(len(still), bool), slope.copy(), len(still) - 1
    edges = np.flatnonzero(np.diff(still, prepend=False, append=False))
    for first, end in zip(edges[::2].tolist(), (edges[1::2] - 1).tolist(), strict=True):
        inner = min(first + half, (first + end) // 2), max(end - half, (first + end + 1) // 2)
        at_rest[inner[0] : inner[1] + 1] = True
        for own, until, way in (
            (inner[0], max(first - half, 0), -1),
            (inner[1], min(end + half, last), 1),
        ):
            samples = np.arange(own, until + way, way)
            off = smooth[samples] - level[own] - slope[own] * (samples - own)
            moves = np.flatnonzero(np.abs(off) > 2 * within_m)
            before = np.abs(off[: moves[0] if len(moves) else None])
            outermost = int(np.flatnonzero(before <= within_m)[-1:].sum())
            resting = samples[: outermost + 1]
            at_rest[resting], step[resting] = True, slope[own]
            ending = resting[-round(2 * half * _WINDOW_S / REST_S) :]
            step[ending] += way * off[outermost] / len(ending)
    return at_rest, step


def _pressure(run: Run, name: str) -> np.ndarray:
    """Return a chamber's pressure (n,), 0 where friction does not need it."""
    return run.channel(name) if name in friction_channels(run) else np.zeros(len(run.t_s))
