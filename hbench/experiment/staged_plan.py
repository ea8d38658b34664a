"""Parts of a campaign: the decided runs are made, then the rest is planned again.

Without adaptive velocities all runs are decided beforehand, and there is one part. With them a
part ends where the next speed needs friction; the board then waits with its valves in neutral.
Friction is read from the campaign's own logs, so a resumed campaign continues in the same way.
"""

from collections.abc import Iterator, Sequence, Set
from dataclasses import replace
from pathlib import Path

from hbench.analysis.screening.calibrate import calibrate
from hbench.analysis.screening.screen import screen
from hbench.analysis.summary.completeness import PlannedRuns
from hbench.config.bench import Bench
from hbench.config.schedule import Schedule
from hbench.errors import HbenchError
from hbench.experiment.plan import Plan, plan_runs
from hbench.records import RunPlan, ScreenedRun
from hbench.store.campaign.folder import StoredCampaign, load_campaign


def plan_parts(
    plan: Plan, schedule: Schedule, bench: Bench, folder: Path, done: Set[RunPlan]
) -> Iterator[Plan]:
    """Yield the runs to make next, with the most that can follow.

    ``plan`` is the plan of ``schedule`` before any run, ``done`` are the runs in ``folder``. The
    runs of a part must have been made before the next part is requested.
    """
    friction: dict[RunPlan, float | None] = {}
    adaptive = bool(plan.undecided)
    while True:
        if adaptive:
            friction |= _friction(schedule, bench, folder, done - friction.keys())
            plan = plan_runs(schedule, bench, schedule.name, friction)
        runs = tuple(run for run in plan.runs if run not in done)
        if not runs:
            return
        yield Plan(runs, plan.undecided)
        done = done | set(runs)


def planned_runs(
    campaign: StoredCampaign, screened: Sequence[ScreenedRun]
) -> tuple[PlannedRuns | None, tuple[str, ...]]:
    """Return all runs of a campaign's plan, and a note where they are not known.

    Adaptive speeds follow from the friction of the runs made so far. Imported campaigns have no
    plan.
    """
    if campaign.imported:
        return None, ()
    friction = {run.run.plan: _mean_friction_n(run) for run in screened}
    try:
        schedule, bench = campaign.schedule(), campaign.bench()
        if schedule is None or bench is None:
            return None, ("the campaign contains no schedule: its planned runs are not known",)
        plan = plan_runs(schedule, bench, schedule.name, friction)
    except HbenchError as error:
        return None, (f"the planned runs are not known: {error.message}",)
    return PlannedRuns(plan.runs, campaign.done, plan.undecided), ()


def _friction(
    schedule: Schedule, bench: Bench, folder: Path, plans: Set[RunPlan]
) -> dict[RunPlan, float | None]:
    """Return the mean friction [N] of the runs ``plans``; None for a rejected one."""
    campaign = load_campaign(folder)
    entries = tuple(entry for entry in campaign.entries if entry.plan in plans)
    found = {}
    for raw in replace(campaign, entries=entries).raw_runs():
        found[raw.plan] = _mean_friction_n(screen(calibrate(raw, bench), schedule.screening))
    return found


def _mean_friction_n(run: ScreenedRun) -> float | None:
    return run.means.friction_n if run.accepted and run.means else None
