"""Use of runs in the identification, by kind of experiment, and runs left out."""

from collections.abc import Mapping, Sequence

from hbench.analysis.screening.sample_friction import LoggedMotion, logged_motion
from hbench.errors import DataError
from hbench.records import KINDS, Curve, Run, RunPlan, ScreenedRun
from hbench.records.kinds import IdentificationUse

# Use of a kind's runs, and why accepted runs are left out; empty without such a reason.
USES: Mapping[IdentificationUse, str] = {
    "steady_curve": "",  # through their curves
    "motion": "",  # sample by sample, for laws with internal states
    "verification": "",  # for the verification only
    "too_fast": "the velocity steps are too fast for the log",
    "unused": "runs of this kind determine no friction law",
}


def identification_use(item: RunPlan | Curve) -> IdentificationUse:
    """Return the use of a run or curve in the identification."""
    return KINDS[item.kind].identification


def usable_runs(
    screened: Sequence[ScreenedRun], mass_kg: float
) -> tuple[list[tuple[Run, LoggedMotion]], tuple[str, ...]]:
    """Return the accepted non-steady runs with their motions, and the runs left out, with reasons.

    ``mass_kg`` is the test side's.
    """
    usable, left_out = [], []
    for verdict in screened:
        run = verdict.run
        plan, use = run.plan, identification_use(run.plan)
        reason = USES[use] if verdict.accepted else "; ".join(verdict.reasons)
        if verdict.accepted and use in ("motion", "verification"):
            try:
                usable.append((run, logged_motion(run, mass_kg)))
            except DataError as error:
                reason = error.message.partition(": ")[2]
        if reason:
            left_out.append(f"{plan.run} ({plan.kind}): {reason}")
    return usable, tuple(left_out)
