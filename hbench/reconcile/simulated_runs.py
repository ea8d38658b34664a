"""A campaign's runs made again by models of its bench, on all cores."""

from collections.abc import Callable, Iterable, Sequence

from hbench.config.bench import Bench, Plant
from hbench.config.scaling import scaled
from hbench.experiment.closed_loop import record_plans
from hbench.parallel.process_pool import on_all_cores
from hbench.reconcile.gap import point_of
from hbench.reconcile.linearised import Hypothesis, Simulate
from hbench.records import Run, RunPlan

_SEED = 20_011  # of the sensors' noise
_FEW = 2  # simulations that no other process is started for

_Task = tuple[int, Bench, Plant, tuple[RunPlan, ...]]


def simulator(
    bench: Bench,
    plant: Plant,
    plans: Sequence[RunPlan],
    report: Callable[[int, int], None] = lambda done, of: None,
    spread: Callable[[Callable, Sequence], Iterable] = on_all_cores,
) -> Simulate:
    """Return what makes the runs of ``plans`` with hypotheses of ``plant``.

    Friction does not scatter from stroke to stroke: a mean is wanted. ``report`` is told how many
    of how many simulations are done; ``spread`` does many of them, ``map`` one by one.
    """

    def simulate(hypotheses: Sequence[Hypothesis], trials: int) -> Iterable[tuple[Run, ...] | None]:
        chosen = _first_trials(plans, trials)
        tasks = [(i, bench, _even(one.plant(plant)), chosen) for i, one in enumerate(hypotheses)]
        made = map(_made, tasks) if len(tasks) <= _FEW else spread(_made, tasks)
        found: dict[int, tuple[Run, ...] | None] = {}
        for i, runs in made:
            found[i] = runs
            report(len(found), len(tasks))
        return [found[i] for i in range(len(tasks))]

    return simulate


def _made(task: _Task) -> tuple[int, tuple[Run, ...] | None]:
    number, bench, plant, plans = task
    recorded = record_plans(bench, plans, plant, seed=_SEED)
    return number, None if recorded.stopped else recorded.runs


def _even(plant: Plant) -> Plant:
    return scaled(plant, {f"friction.{side}.scatter": 0.0 for side in ("test", "load")})


def _first_trials(plans: Sequence[RunPlan], trials: int) -> tuple[RunPlan, ...]:
    """Return the first ``trials`` runs of each operating point, in the order of the plans."""
    seen: dict = {}
    chosen = []
    for plan in plans:
        point = point_of(plan)
        seen[point] = seen.get(point, 0) + 1
        if seen[point] <= trials:
            chosen.append(plan)
    return tuple(chosen)
