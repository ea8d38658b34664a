"""A campaign in parts: what is decided is made, then the plan is looked at again.

Without adaptive velocities all is decided beforehand, and there is one part. With them a part
ends where the next speed waits for friction; the board is then done, with its valves in neutral,
until the next part comes. Friction is read from the campaign's own logs, so a campaign that is
resumed goes on as it would have.
"""

from collections.abc import Iterator, Set
from dataclasses import replace
from pathlib import Path

from hbench.analysis.screening.calibrate import calibrate
from hbench.analysis.screening.screen import screen
from hbench.config.bench import Bench
from hbench.config.schedule import Schedule
from hbench.experiment.plan import Plan, plan_runs
from hbench.records import RunPlan
from hbench.store.campaign.folder import load_campaign


def parts(
    plan: Plan, schedule: Schedule, bench: Bench, folder: Path, done: Set[RunPlan]
) -> Iterator[Plan]:
    """Yield what to make next, and the most that can follow it.

    ``plan`` is that of ``schedule`` before anything was measured, ``done`` what the campaign in
    ``folder`` holds already. The runs of a part must have been made when the next is asked for.
    """
    friction: dict[RunPlan, float | None] = {}
    adaptive = bool(plan.rest)
    while True:
        if adaptive:
            friction |= _friction(schedule, bench, folder, done - friction.keys())
            plan = plan_runs(schedule, bench, schedule.name, friction)
        runs = tuple(run for run in plan.runs if run not in done)
        if not runs:
            return
        yield Plan(runs, plan.rest)
        done = done | set(runs)


def _friction(
    schedule: Schedule, bench: Bench, folder: Path, plans: Set[RunPlan]
) -> dict[RunPlan, float | None]:
    """Return the mean friction [N] of runs that were made; None for a rejected one."""
    campaign = load_campaign(folder)
    entries = tuple(entry for entry in campaign.entries if entry.plan in plans)
    found = {}
    for raw in replace(campaign, entries=entries).raw_runs():
        run = screen(calibrate(raw, bench), schedule.screening)
        found[raw.plan] = run.means.friction_n if run.accepted and run.means else None
    return found
