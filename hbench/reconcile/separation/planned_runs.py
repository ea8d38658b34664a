"""Linearised model along runs that are only planned: simulated once with the given model."""

from collections.abc import Sequence

from hbench.config.bench import Bench, Plant
from hbench.errors import DataError
from hbench.reconcile.gaps.simulated_runs import simulator
from hbench.reconcile.hypothesis import Hypothesis, coefficient_names
from hbench.reconcile.linearised import LinearisedModel, linearise
from hbench.reconcile.measured.session import sessions
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.separation.missing_data import data_shortfalls, missing_experiments
from hbench.reconcile.separation.observable import divided_points, observable_effects
from hbench.reconcile.separation.separability import Separation
from hbench.records import KINDS, PlannedEffects, Run, RunPlan
from hbench.records.reconcile.diagnosis import MATERIAL


def planned_effects(bench: Bench, plant: Plant, plans: Sequence[RunPlan]) -> PlannedEffects:
    """Return the effects that ``hbench reconcile`` would find in planned runs, and their pairs.

    One run of each operating point is simulated. More trials hardly change the noise that a search
    assumes: most of it is what is not material. Effects that build up over a campaign are smaller
    in this shorter one. Raises ``DataError`` where the simulation ends early.
    """
    chosen = [plan for plan in plans if KINDS[plan.kind].is_reconciled]
    if not chosen:
        raise DataError("effects: the schedule has no runs that hbench reconcile compares")
    runs = simulated_runs(bench, plant, chosen)
    if isinstance(runs, str):
        raise DataError(f"effects: the simulation of the schedule ended early: {runs}")
    names, not_tried = observable_effects(runs, plant)
    model = linearised_runs(bench, plant, runs, names)
    train, _ = divided_points(len(model.gap_map.points))
    return PlannedEffects(
        Separation(model, train).separability(names),
        not_tried,
        tuple(data_shortfalls(runs).values()),
        tuple(missing_experiments(runs).values()),
    )


def linearised_runs(
    bench: Bench, plant: Plant, runs: Sequence[Run], effects: Sequence[str]
) -> LinearisedModel:
    """Return the given model, linearised along runs, with the columns of some effects."""
    campaign = MeasuredCampaign(bench, plant, bench.instruments, sessions(runs), MATERIAL)
    names = dict.fromkeys([*campaign.nuisance_columns, *coefficient_names(effects)])
    return linearise(campaign, campaign.start, campaign.columns(campaign.start, names))


def simulated_runs(
    bench: Bench, plant: Plant, plans: Sequence[RunPlan], at: Hypothesis | None = None
) -> tuple[Run, ...] | str:
    """Return a run of each operating point, or the reason why the simulation ended early."""
    (runs,) = simulator(bench, plant, spread=map)((at or Hypothesis(),), plans)
    return runs
