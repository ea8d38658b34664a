"""Runs that an identification uses, by kind of experiment, and runs that it leaves out."""

from collections.abc import Mapping, Sequence

from hbench.analysis.screening.sample_friction import LoggedMotion, logged_motion
from hbench.errors import DataError
from hbench.records import KINDS, Curve, Run, RunPlan, ScreenedRun
from hbench.records.kinds import IdentificationUse

# Use of a kind's runs, and why accepted ones are left out; empty where that needs no remark.
USES: Mapping[IdentificationUse, str] = {
    "steady_curve": "",  # through their curves
    "motion": "",  # sample by sample, for laws with a memory
    "verification": "",  # for the verification alone
    "too_fast": "its velocity jumps, faster than a log can follow",
    "unused": "",
}


def identification_use(one: RunPlan | Curve) -> IdentificationUse:
    """Return the use of a run or curve in the identification."""
    return KINDS[one.kind].identification


def usable_runs(
    screened: Sequence[ScreenedRun], mass_kg: float
) -> tuple[list[tuple[Run, LoggedMotion]], tuple[str, ...]]:
    """Return the accepted non-steady runs with their motions, and the runs left out, with reasons.

    ``mass_kg`` is the test side's.
    """
    usable, left_out = [], []
    for one in screened:
        plan, use = one.run.plan, identification_use(one.run.plan)
        reason = USES[use] if one.accepted else "; ".join(one.reasons)
        if one.accepted and use in ("motion", "verification"):
            try:
                usable.append((one.run, logged_motion(one.run, mass_kg)))
            except DataError as error:
                reason = error.message.partition(": ")[2]
        if reason:
            left_out.append(f"{plan.run} ({plan.kind}): {reason}")
    return usable, tuple(left_out)
