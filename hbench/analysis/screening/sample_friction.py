"""Friction of a logged run at each sample.

    F_fT = F_T - F_applied - m_T a        (2.12, with the inertia of the test side alone)

Velocity and acceleration come from the position: a polynomial of fourth order through the samples
of 60 ms (Savitzky and Golay), seven at least, which has no lag. It suits reversals and ramps, but
not steps of the reference. At rest the velocity is that of ``hbench.motion.standstill``.
"""

from dataclasses import dataclass

import numpy as np

from hbench.analysis.screening.friction_channels import (
    friction_channels,
    friction_with_inertia,
    missing_friction_channels,
)
from hbench.errors import DataError
from hbench.motion.local_polynomials import local_polynomials, odd_samples
from hbench.motion.standstill import noise_of_motion, standstill
from hbench.records import Run
from hbench.records.identification import MEMORY_M
from hbench.sentences import listed

_WINDOW_S, _FEWEST, _ORDER = 0.06, 7, 4  # samples at least; of the polynomial


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
    noise_m: float = 0.0  # standard deviation of the noise of the position

    @property
    def centred(self) -> slice:
        """The samples whose derivatives are not one-sided."""
        return slice(self.one_sided, len(self.v_m_s) - self.one_sided)


def logged_motion(run: Run, mass_kg: float) -> LoggedMotion:
    """Return friction and motion of a whole run; ``mass_kg`` is the test side's.

    Raises ``DataError`` if a channel or a record is missing.
    """
    missing = missing_friction_channels(run)
    if missing:
        raise DataError(f"run {run.plan.run}: friction needs {listed(missing)}")
    steps = np.diff(run.t_s)
    dt = float(np.median(steps)) if len(steps) else np.inf
    window = odd_samples(_WINDOW_S, dt, _FEWEST)
    if len(run.t_s) < window:
        raise DataError(f"run {run.plan.run}: has {len(run.t_s)} samples; limit {window}")
    if np.abs(steps - dt).max() > 0.01 * dt:
        raise DataError(
            f"run {run.plan.run}: its samples are not evenly spaced ({steps.min():.4g} to "
            f"{steps.max():.4g} s)",
            f"Without gaps, write 'resample: {0.5 / dt:.2g} Hz' in the import map.",
        )
    whole = np.array([0, len(run.x_m)])
    v, a = (local_polynomials(run.x_m, whole, window, _ORDER, order, dt) for order in (1, 2))
    at_rest, resting = standstill(run.x_m, dt)
    v, a = np.where(at_rest, resting, v), np.where(at_rest, 0.0, a)
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
        noise_m=noise_of_motion(run.x_m, dt),
    )


def _pressure(run: Run, name: str) -> np.ndarray:
    """Return a chamber's pressure (n,), 0 where friction does not need it."""
    return run.channel(name) if name in friction_channels(run) else np.zeros(len(run.t_s))
