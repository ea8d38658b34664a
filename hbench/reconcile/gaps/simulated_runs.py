"""Simulation of a campaign's runs with hypotheses of the plant, on all cores."""

from collections.abc import Callable, Iterable, Sequence

from hbench.config.bench import Bench, Plant
from hbench.config.scaling import scaled
from hbench.errors import ConfigError
from hbench.experiment.closed_loop import record_plans
from hbench.parallel.process_pool import map_on_cores
from hbench.parallel.threads import map_on_threads
from hbench.reconcile.gaps.gap_map import point_of
from hbench.reconcile.hypothesis import Hypothesis
from hbench.records import Run, RunPlan

_SEED = 20_011  # of the sensors' noise
_FEW = 3  # simulations that take less time in threads than the start of processes

_Task = tuple[int, Bench, Plant, tuple[RunPlan, ...]]


def simulator(
    bench: Bench,
    plant: Plant,
    report: Callable[[int, int], None] = lambda done, of: None,
    spread: Callable[[Callable, Sequence], Iterable] = map_on_cores,
) -> Callable[[Sequence[Hypothesis], Sequence[RunPlan]], list[tuple[Run, ...] | str]]:
    """Return a function that simulates plans with hypotheses of ``plant``.

    For a hypothesis with which the bench can't rest, the board stops, or takes far longer than
    expected, it returns the reason as text. One trial of each operating point gives the mean:
    friction has no scatter from stroke to stroke. ``report`` receives the number of completed
    simulations and the total. ``spread`` maps over many simulations; pass ``map`` to run them in
    sequence.
    """

    def simulate(
        hypotheses: Sequence[Hypothesis], plans: Sequence[RunPlan]
    ) -> list[tuple[Run, ...] | str]:
        chosen = tuple({point_of(plan): plan for plan in reversed(plans)}.values())[::-1]
        tasks = [
            (i, bench, _without_scatter(hypothesis.plant(plant)), chosen)
            for i, hypothesis in enumerate(hypotheses)
        ]
        every = map_on_threads if len(tasks) <= _FEW else spread
        results = every(_simulate, tasks)
        runs_by_number: dict[int, tuple[Run, ...] | str] = {}
        for number, runs in results:
            runs_by_number[number] = runs
            report(len(runs_by_number), len(tasks))
        return [runs_by_number[number] for number in range(len(tasks))]

    return simulate


def _simulate(task: _Task) -> tuple[int, tuple[Run, ...] | str]:
    number, bench, plant, plans = task
    try:
        recorded = record_plans(bench, plans, plant, seed=_SEED)
    except ConfigError as error:  # the supply of a hypothesis does not hold the load at rest
        return number, error.message
    return number, recorded.stopped or recorded.runs


def _without_scatter(plant: Plant) -> Plant:
    return scaled(plant, {f"friction.{side}.scatter": 0.0 for side in ("test", "load")})
