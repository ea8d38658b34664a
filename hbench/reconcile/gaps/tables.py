"""Gaps before and after, by operating points and by run, with the floor of a correct model."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from hbench.parallel.threads import map_on_threads
from hbench.reconcile.gaps.gap_map import GapMap, column_means, gap_map, point_of, run_gaps
from hbench.reconcile.measured.balances import BalanceModel, WindowedRun
from hbench.reconcile.measured.window_signals import open_loop_errors, signals
from hbench.records import BeforeAfter, GapTable, Run, RunGap, RunPlan

_EVALUATIONS: Mapping[str, Callable[[Run, BalanceModel], WindowedRun]] = {
    "signals": signals,
    "open_loop": open_loop_errors,
}


@dataclass(frozen=True)
class BalanceStages:
    """Residuals of the models before, refitted and after, in the scatter of the second."""

    maps: tuple[GapMap, GapMap, GapMap]
    expected: np.ndarray  # (w, c) square of a correct model's residuals, in squares of scatters

    def over(self, windows: np.ndarray) -> dict[str, BeforeAfter]:
        """Return the gaps of the chosen windows (w,), by balance."""
        columns = [each.gaps(windows) for each in self.maps]
        floor = np.sqrt(column_means(self.expected[windows]))
        return _by_name(self.maps[0].names, columns, floor)


class SimulatedStages:
    """Signals of measured runs and of those of the models before, refitted and after.

    ``stages`` are their indices in ``simulated``, whose models differ. The open loop, which takes
    long, is that of the runs at ``held_out`` points.
    """

    def __init__(
        self,
        measured: Sequence[Run],
        simulated: Sequence[tuple[Sequence[Run], BalanceModel]],
        stages: Sequence[int],
        held_out: frozenset[Hashable],
    ):
        self._maps: dict[str, list[GapMap]] = {}
        self._runs: dict[str, list[dict[str, np.ndarray]]] = {}
        points = frozenset(point_of(run.plan) for run in measured)
        for name, evaluate in _EVALUATIONS.items():
            chosen = points & held_out if name == "open_loop" else points
            if not chosen:
                continue
            pairs = [
                (
                    _evaluated(evaluate, measured, model, chosen),
                    _evaluated(evaluate, runs, model, chosen),
                )
                for runs, model in simulated
            ]
            self._maps[name] = [gap_map(*pairs[i]) for i in stages]
            self._runs[name] = [run_gaps(*pairs[i]) for i in stages]

    @property
    def points(self) -> frozenset[Hashable]:
        """Operating points with gaps: those with a second trial."""
        return frozenset(point for maps in self._maps.values() for point in maps[0].points)

    def over(self, points: frozenset[Hashable]) -> dict[str, dict[str, BeforeAfter]]:
        """Return the gaps over some operating points, by evaluation and signal."""
        return {
            name: _by_name(maps[0].names, [each.gaps(each.at(points)) for each in maps])
            for name, maps in self._maps.items()
            if points.intersection(maps[0].points)
        }

    def of_run(self, run: str) -> dict[str, dict[str, BeforeAfter]]:
        """Return the gaps of a run; none where its operating point has no second trial."""
        return {
            name: _by_name(self._maps[name][0].names, [gaps[run] for gaps in stages])
            for name, stages in self._runs.items()
            if all(run in gaps for gaps in stages)
        }


def gap_table(
    balances: BalanceStages, simulated: SimulatedStages | None, points: frozenset[Hashable]
) -> GapTable:
    """Return the gaps over some operating points."""
    signals_of = simulated.over(points) if simulated and points & simulated.points else {}
    return _table(balances.over(balances.maps[0].at(points)), signals_of)


def gaps_of_runs(
    plans: Sequence[RunPlan],
    balances: BalanceStages,
    simulated: SimulatedStages | None,
    held_out: frozenset[Hashable],
) -> tuple[RunGap, ...]:
    """Return the gaps of each run, in the order of the maps; ``held_out`` are points."""
    run = balances.maps[0].run
    return tuple(
        RunGap(
            plan,
            point_of(plan) in held_out,
            _table(balances.over(run == i), simulated.of_run(plan.run) if simulated else {}),
        )
        for i, plan in enumerate(plans)
    )


def _evaluated(
    evaluate: Callable[[Run, BalanceModel], WindowedRun],
    runs: Sequence[Run],
    model: BalanceModel,
    points: frozenset[Hashable],
) -> list[WindowedRun]:
    """Evaluate the runs at some points; open loops are compiled and run in parallel threads."""
    chosen = [run for run in runs if point_of(run.plan) in points]
    return map_on_threads(lambda run: evaluate(run, model), chosen)


def _by_name(
    names: Sequence[str], columns: Sequence[np.ndarray], floor: np.ndarray | None = None
) -> dict[str, BeforeAfter]:
    floor = np.ones(len(names)) if floor is None else floor
    return {
        name: BeforeAfter(*[float(column[i]) for column in (*columns, floor)])
        for i, name in enumerate(names)
        if all(np.isfinite(column[i]) for column in columns)
    }


def _table(
    balances: dict[str, BeforeAfter], simulated: dict[str, dict[str, BeforeAfter]]
) -> GapTable:
    values = balances.values()
    total = BeforeAfter(
        *(
            float(np.sqrt(np.mean([getattr(balance, step) ** 2 for balance in values])))
            if values
            else float("nan")
            for step in ("before", "refitted", "after", "floor")
        )
    )
    signals_of, open_loop = simulated.get("signals", {}), simulated.get("open_loop", {})
    return GapTable(total=total, balances=balances, signals=signals_of, open_loop=open_loop)
