"""The channels of a run that friction is computed from."""

import numpy as np

from hbench.records import Run


def friction_channels(run: Run) -> tuple[str, ...]:
    """Return the channels that friction is computed from.

    A plunger has no rod side; a drive without hydraulics has a force in place of the pressures.
    """
    if run.f_drive_n is not None:
        return "f_drive_n", "f_applied_n"
    rod_side = ("p_tr_pa",) if run.plan.specimen.area_rod_m2 > 0 else ()
    return "p_tp_pa", *rod_side, "f_applied_n"


def missing_friction_channels(run: Run) -> list[str]:
    """Return the channels of friction that were not measured."""
    return [name for name in friction_channels(run) if getattr(run, name) is None]


def test_force(run: Run, window: slice) -> np.ndarray:
    """Return F_T = P_Tp A_p - P_Tr A_r, or the drive's force, [N] in a window (n,)."""
    if run.f_drive_n is not None:
        return run.f_drive_n[window]
    specimen = run.plan.specimen
    force = run.channel("p_tp_pa")[window] * specimen.area_piston_m2
    if specimen.area_rod_m2 > 0:
        force = force - run.channel("p_tr_pa")[window] * specimen.area_rod_m2
    return force


def friction_with_inertia(run: Run) -> np.ndarray:
    """Return F_T - F_applied [N] (n,): friction, and the inertia of the test side's mass."""
    return test_force(run, slice(None)) - run.channel("f_applied_n")
