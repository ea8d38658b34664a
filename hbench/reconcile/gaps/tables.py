"""Gaps before and after, by operating points and by run, with the floor of a correct model."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from hbench.reconcile.gaps.gap_map import GapMap, column_means, gap_map, point_of, run_gaps
from hbench.reconcile.measured.balances import (
    BalanceModel,
    PreparedRun,
    WindowedRun,
    prepare,
    residuals,
)
from hbench.reconcile.measured.window_signals import open_loop_errors, signals
from hbench.records import BeforeAfter, GapTable, Run, RunGap

Logs = Sequence[PreparedRun]
Evaluate = Callable[[PreparedRun, BalanceModel], WindowedRun]
_EVALUATIONS: Mapping[str, Evaluate] = {
    "balances": residuals,
    "signals": signals,
    "open_loop": open_loop_errors,
}


class GapComparison:
    """Comparison of the models before, refitted and after with the measured runs."""

    def __init__(
        self,
        measured: Logs,
        models: tuple[tuple[Sequence[Run], BalanceModel], ...],
        uncertain: Sequence[Sequence[Run]],
    ):
        """Evaluate all runs.

        ``models`` are the model as given, refitted, and with the effects: simulated runs and the
        balances' model of each. ``uncertain`` are runs of the last one with parameters drawn from
        their uncertainty.
        """
        simulated = [([prepare(run) for run in runs], model) for runs, model in models]
        drawn = [[prepare(run) for run in runs] for runs in uncertain]
        self._plans = [log.run.plan for log in measured]
        self._comparisons = {
            name: _Comparison(evaluate, measured, simulated, drawn)
            for name, evaluate in _EVALUATIONS.items()
        }

    def table(self, points: frozenset[Hashable]) -> GapTable:
        """Return the gaps over some operating points."""
        return _gap_table({name: each.over(points) for name, each in self._comparisons.items()})

    def runs(self, held_out: frozenset[Hashable]) -> tuple[RunGap, ...]:
        """Return the gaps of each run; ``held_out`` are operating points."""
        return tuple(
            RunGap(
                plan,
                point_of(plan) in held_out,
                _gap_table(
                    {name: each.of_run(plan.run) for name, each in self._comparisons.items()}
                ),
            )
            for plan in self._plans
        )


class _Comparison:
    """Balances or signals of the measured runs and of the runs of each model."""

    def __init__(
        self,
        evaluate: Evaluate,
        measured: Logs,
        simulated: Sequence[tuple[Logs, BalanceModel]],
        drawn: Sequence[Logs],
    ):
        pairs = [
            (_evaluated(evaluate, measured, model), _evaluated(evaluate, logs, model))
            for logs, model in simulated
        ]
        self._maps = [gap_map(*pair) for pair in pairs]
        self._runs = [run_gaps(*pair) for pair in pairs]
        self._points = {log.run.plan.run: point_of(log.run.plan) for log in measured}
        last, model = pairs[-1][1], simulated[-1][1]
        self._drawn = [gap_map(last, _evaluated(evaluate, logs, model)) for logs in drawn]

    def over(self, points: frozenset[Hashable]) -> dict[str, BeforeAfter]:
        return self._by_name([_gaps(_at(each, points)) for each in self._maps], points)

    def of_run(self, run: str) -> dict[str, BeforeAfter]:
        return self._by_name([gaps[run] for gaps in self._runs], frozenset({self._points[run]}))

    def _by_name(
        self, columns: Sequence[np.ndarray], points: frozenset[Hashable]
    ) -> dict[str, BeforeAfter]:
        """Return the gaps, one column a model, with the floors of ``points``, by name."""
        reference = _at(self._maps[-1], points)
        floors = [_structured(_at(each, points), reference) for each in self._drawn]
        floor = np.sqrt(1 + np.mean(floors, axis=0)) if floors else np.ones(len(reference.names))
        return {
            name: BeforeAfter(*[float(column[i]) for column in (*columns, floor)])
            for i, name in enumerate(reference.names)
            if all(np.isfinite(column[i]) for column in columns)
        }


def _evaluated(evaluate: Evaluate, logs: Logs, model: BalanceModel) -> list[WindowedRun]:
    """Evaluate each log; open loops are compiled and run in parallel threads."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(lambda log: evaluate(log, model), logs))


def _gap_table(columns: dict[str, dict[str, BeforeAfter]]) -> GapTable:
    balances = columns["balances"].values()
    total = BeforeAfter(
        *(
            float(np.sqrt(np.mean([getattr(balance, step) ** 2 for balance in balances])))
            if balances
            else float("nan")
            for step in ("before", "refitted", "after", "floor")
        )
    )
    return GapTable(total=total, **columns)


def _at(differences: GapMap, points: frozenset[Hashable]) -> GapMap:
    numbers = [i for i, point in enumerate(differences.points) if point in points]
    return differences.select_points(np.array(numbers))


def _gaps(differences: GapMap) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.maximum(1 + column_means(differences.excess), 0.0))


def _structured(differences: GapMap, reference: GapMap) -> np.ndarray:
    """Return the mean square (c,) of a difference of models over the measured scatter."""
    scatter = np.sqrt(column_means(reference.scatter**2))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = column_means(differences.difference**2 - differences.noise) / scatter**2
    return np.maximum(np.nan_to_num(ratio, posinf=0.0), 0.0)
