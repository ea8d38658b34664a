"""Change of the middle of both directions within a stroke, which most effects can't cause.

At constant pressure the error of a sensor, or of the piston's area, is the same along the whole
stroke. Friction that differs between the directions changes the middle in proportion to the half
band. A middle that changes in another way has another cause, such as a side load or a stroke out
of line, whatever explains its mean.
"""

import numpy as np

from hbench.model.effects.catalogue import EFFECTS
from hbench.records import Run, SteadyMeans

_FEWEST = 10  # samples of a line
_LARGEST_SHARE = 0.5  # of the middle: a larger change within a stroke contradicts an effect


def change_over_window(run: Run, means: SteadyMeans) -> float:
    """Return the change of F_T - F_applied [N] over a steady window, in the sense of extension.

    The slope of a straight line over position, times the range; 0 without samples.
    """
    inside = (run.t_s >= means.t_start_s) & (run.t_s <= means.t_stop_s)
    if run.p_tp_pa is None or run.f_applied_n is None:
        return 0.0
    areas = run.plan.specimen
    force = run.p_tp_pa * areas.area_piston_m2 - run.f_applied_n
    if run.p_tr_pa is not None:
        force = force - run.p_tr_pa * areas.area_rod_m2
    usable = inside & np.isfinite(force) & np.isfinite(run.x_m)
    x, force = run.x_m[usable], force[usable]
    if len(x) < _FEWEST or not np.ptp(x) > 0:
        return 0.0
    x = (x - x.mean()) / np.ptp(x)
    return float(x @ force / (x @ x))


def contradiction(name: str, extend: np.ndarray, retract: np.ndarray) -> str:
    """Return why an effect can't explain the middle; empty if it can.

    ``extend`` and ``retract`` (w, 2) are F_T - F_applied [N] of each load: its mean, and its change
    within a stroke.
    """
    middle, middle_change = (extend + retract).T / 2
    if "sensors" in EFFECTS[name].laws:
        expected = np.zeros_like(middle)
    else:
        half_band, band_change = (extend - retract).T / 2
        expected = middle * band_change / half_band
    change, mean = (
        float(np.sqrt(np.mean(values**2))) for values in (middle_change - expected, middle)
    )
    if change <= _LARGEST_SHARE * mean:
        return ""
    return (
        f"the mean of both directions changes by {change:.2g} N within a stroke beyond what this "
        f"effect can cause; its mean is {mean:.2g} N (limit: {_LARGEST_SHARE:.0%})"
    )
