"""Simulation of a campaign's runs with hypotheses of the plant, on all cores."""

from collections.abc import Callable, Iterable, Sequence

from hbench.config.bench import Bench, Plant
from hbench.config.scaling import scaled
from hbench.experiment.closed_loop import record_plans
from hbench.parallel.process_pool import map_on_cores
from hbench.reconcile.gaps.gap_map import point_of
from hbench.reconcile.hypothesis import Hypothesis, Simulate
from hbench.records import Run, RunPlan

_SEED = 20_011  # of the sensors' noise
_FEW = 2  # simulations that run in this process

_Task = tuple[int, Bench, Plant, tuple[RunPlan, ...]]


def simulator(
    bench: Bench,
    plant: Plant,
    plans: Sequence[RunPlan],
    report: Callable[[int, int], None] = lambda done, of: None,
    spread: Callable[[Callable, Sequence], Iterable] = map_on_cores,
) -> Simulate:
    """Return a function that simulates the runs of ``plans`` with hypotheses of ``plant``.

    Friction has no scatter from stroke to stroke, so that one trial gives the mean. ``report``
    receives the number of completed simulations and the total. ``spread`` maps over many
    simulations; pass ``map`` to run them in sequence.
    """

    def simulate(hypotheses: Sequence[Hypothesis], trials: int) -> Iterable[tuple[Run, ...] | None]:
        chosen = _first_trials(plans, trials)
        tasks = [
            (i, bench, _without_scatter(hypothesis.plant(plant)), chosen)
            for i, hypothesis in enumerate(hypotheses)
        ]
        results = map(_simulate, tasks) if len(tasks) <= _FEW else spread(_simulate, tasks)
        runs_by_number: dict[int, tuple[Run, ...] | None] = {}
        for number, runs in results:
            runs_by_number[number] = runs
            report(len(runs_by_number), len(tasks))
        return [runs_by_number[number] for number in range(len(tasks))]

    return simulate


def _simulate(task: _Task) -> tuple[int, tuple[Run, ...] | None]:
    number, bench, plant, plans = task
    recorded = record_plans(bench, plans, plant, seed=_SEED)
    return number, None if recorded.stopped else recorded.runs


def _without_scatter(plant: Plant) -> Plant:
    return scaled(plant, {f"friction.{side}.scatter": 0.0 for side in ("test", "load")})


def _first_trials(plans: Sequence[RunPlan], trials: int) -> tuple[RunPlan, ...]:
    """Return the first ``trials`` runs of each operating point, in the order of the plans."""
    counts: dict = {}
    chosen = []
    for plan in plans:
        point = point_of(plan)
        counts[point] = counts.get(point, 0) + 1
        if counts[point] <= trials:
            chosen.append(plan)
    return tuple(chosen)
