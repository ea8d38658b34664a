"""What a logged run tells about friction from sample to sample.

    F_fT = F_T - F_applied - m_T a        (2.12, with the inertia of the test side alone)

Velocity and acceleration come from the position: a polynomial of fourth order through seven samples
(Savitzky and Golay), which has no lag. At 100 Hz it reaches over 60 ms, so it is made for reversals
and ramps, not for jumps of the reference.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from hbench.analysis.screening.screen import missing_channels, test_force
from hbench.errors import DataError
from hbench.records import Run

_WINDOW, _ORDER = 7, 4  # samples; of the polynomial
_MEMORY_M = 0.02  # about ten lengths of presliding: then friction has forgotten how it began


@dataclass(frozen=True)
class LoggedMotion:
    """One run's samples, evenly spaced by ``dt_s``; each is a mean over its interval."""

    run: str
    dt_s: float
    v_m_s: np.ndarray  # (n,)
    p_p_pa: np.ndarray  # (n,) test cylinder, piston side
    p_r_pa: np.ndarray  # (n,) rod side; 0 for a plunger, which has none
    friction_n: np.ndarray  # (n,)
    compared: np.ndarray  # (n,) bool; the first 20 mm depend on the unknown beginning
    f_applied_n: np.ndarray  # (n,) as the load cell has it, the load side's inertia and all


def logged_motion(run: Run, mass_kg: float) -> LoggedMotion:
    """Return friction and motion of a whole run; ``mass_kg`` is the test side's.

    Raises ``DataError`` where a channel or a record is missing.
    """
    from scipy.signal import savgol_filter  # half a second, for who has runs that move alone

    missing = missing_channels(run)
    if missing:
        raise DataError(f"run {run.plan.run}: friction needs {' and '.join(missing)}")
    if len(run.t_s) < _WINDOW:
        raise DataError(f"run {run.plan.run}: {len(run.t_s)} samples; at least {_WINDOW} needed")
    steps = np.diff(run.t_s)
    dt = float(np.median(steps))
    if np.abs(steps - dt).max() > 0.01 * dt:
        raise DataError(
            f"run {run.plan.run}: its samples are not evenly spaced ({steps.min():.4g} to "
            f"{steps.max():.4g} s)",
            "Nothing with a memory can be followed over a gap. For uneven sampling, an import map "
            "may say 'resample: 100 Hz'.",
        )
    v = savgol_filter(run.x_m, _WINDOW, _ORDER, deriv=1, delta=dt)
    a = savgol_filter(run.x_m, _WINDOW, _ORDER, deriv=2, delta=dt)
    return LoggedMotion(
        run=run.plan.run,
        dt_s=dt,
        v_m_s=v,
        p_p_pa=run.p_tp_pa,
        p_r_pa=run.p_tr_pa if run.plan.specimen.area_rod_m2 > 0 else np.zeros(len(v)),
        friction_n=test_force(run, slice(None)) - run.f_applied_n - mass_kg * a,
        compared=np.cumsum(np.abs(v)) * dt > _MEMORY_M,
        f_applied_n=run.f_applied_n,
    )


def logged_motions(runs: Iterable[Run], mass_kg: float) -> tuple[LoggedMotion, ...]:
    """Return the motions of ``runs``. Raises ``DataError``."""
    return tuple(logged_motion(run, mass_kg) for run in runs)
