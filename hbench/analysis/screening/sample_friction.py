"""Friction of a logged run at each sample.

    F_fT = F_T - F_applied - m_T a        (2.12, with the inertia of the test side alone)

Velocity and acceleration come from the position: a polynomial of fourth order through seven samples
(Savitzky and Golay), which has no lag. At 100 Hz it covers 60 ms, so it suits reversals and ramps,
but not steps of the reference.
"""

from dataclasses import dataclass

import numpy as np

from hbench.analysis.screening.friction_channels import (
    friction_channels,
    missing_friction_channels,
    required,
    test_force,
)
from hbench.errors import DataError
from hbench.records import Run

_WINDOW, _ORDER = 7, 4  # samples; of the polynomial
CENTRED = slice(_WINDOW // 2, -(_WINDOW // 2))  # samples whose derivatives are not one-sided
_MEMORY_M = 0.02  # about ten presliding lengths, after which the initial state has no effect


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


def logged_motion(run: Run, mass_kg: float) -> LoggedMotion:
    """Return friction and motion of a whole run; ``mass_kg`` is the test side's.

    Raises ``DataError`` if a channel or a record is missing.
    """
    from scipy.signal import savgol_filter  # slow import

    missing = missing_friction_channels(run)
    if missing:
        raise DataError(f"run {run.plan.run}: friction needs {' and '.join(missing)}")
    if len(run.t_s) < _WINDOW:
        raise DataError(f"run {run.plan.run}: has {len(run.t_s)} samples; limit {_WINDOW}")
    steps = np.diff(run.t_s)
    dt = float(np.median(steps))
    if np.abs(steps - dt).max() > 0.01 * dt:
        raise DataError(
            f"run {run.plan.run}: its samples are not evenly spaced ({steps.min():.4g} to "
            f"{steps.max():.4g} s)",
            f"Without gaps, write 'resample: {0.5 / dt:.2g} Hz' in the import map.",
        )
    v = savgol_filter(run.x_m, _WINDOW, _ORDER, deriv=1, delta=dt)
    a = savgol_filter(run.x_m, _WINDOW, _ORDER, deriv=2, delta=dt)
    return LoggedMotion(
        run=run.plan.run,
        dt_s=dt,
        v_m_s=v,
        p_p_pa=_pressure(run, "p_tp_pa"),
        p_r_pa=_pressure(run, "p_tr_pa"),
        friction_n=test_force(run, slice(None)) - required(run, "f_applied_n") - mass_kg * a,
        compared=np.cumsum(np.abs(v)) * dt > _MEMORY_M,
        f_applied_n=required(run, "f_applied_n"),
    )


def _pressure(run: Run, name: str) -> np.ndarray:
    """Return a chamber's pressure (n,), 0 where friction does not need it."""
    return required(run, name) if name in friction_channels(run) else np.zeros(len(run.t_s))
