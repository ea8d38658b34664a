"""Comparison of a campaign with its plan: runs not made, and points without enough trials."""

from collections.abc import Iterable
from typing import NamedTuple

from hbench.records import Completeness, PointTrials, RunPlan, ScreenedRun

ENOUGH_TRIALS = 3  # of a point; a plan may contain fewer
_POINT = (
    *("kind", "label", "direction", "f_load_n", "p_lr_ref_pa", "a_ref_m_s2", "v_ref_m_s"),
    "dwell_s",
)


class PlannedRuns(NamedTuple):
    """Plan of a campaign: its runs, and the ids of those that ended as planned."""

    runs: tuple[RunPlan, ...]
    completed: frozenset[str]
    undecided: tuple[RunPlan, ...] = ()  # the most runs that adaptive speeds may still need


def completeness(runs: Iterable[ScreenedRun], planned: PlannedRuns | None) -> Completeness:
    """Compare the screened runs with the plan; without one, with the points of all runs.

    Runs that were made have the operating point of the campaign's journal, the others that of the
    plan. Undecided runs count as runs, not as points.
    """
    runs = tuple(runs)
    plans = {run.run.plan.run: run.run.plan for run in runs}
    if planned is not None:
        plans = {plan.run: plan for plan in planned.runs} | plans
    trials = _trials(plans.values())
    accepted = _trials(run.run.plan for run in runs if run.accepted)
    short = []
    for point, of_point in trials.items():
        made = len(accepted.get(point, ()))
        if made < min(len(of_point), ENOUGH_TRIALS):
            series = dict(zip(_POINT, point, strict=True))
            short.append(PointTrials(**series, accepted=made, planned=len(of_point)))
    all_planned = () if planned is None else planned.runs + planned.undecided
    completed = frozenset[str]() if planned is None else planned.completed
    return Completeness(
        planned=None if planned is None else len(all_planned),
        at_most=planned is not None and bool(planned.undecided),
        not_completed=tuple(plan.run for plan in all_planned if plan.run not in completed),
        points=len(trials),
        short_points=tuple(short),
    )


def _trials(plans: Iterable[RunPlan]) -> dict[tuple, set[int]]:
    """Return the numbers of the trials of each operating point."""
    trials: dict[tuple, set[int]] = {}
    for plan in plans:
        trials.setdefault(tuple(getattr(plan, name) for name in _POINT), set()).add(plan.trial)
    return trials
