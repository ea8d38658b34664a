"""Gaps before and after over some runs, with the floor of a model that is right."""

from collections.abc import Callable, Hashable, Sequence
from functools import partial

import numpy as np

from hbench.reconcile.balances import Model, Prepared, Windowed, prepared, residuals
from hbench.reconcile.gap import GapMap, column_means, differences, point_of
from hbench.reconcile.signals import astray, signals
from hbench.records import BeforeAfter, GapTable, Run

View = Callable[[Prepared, Model], Windowed]
Logs = Sequence[Prepared]


class Stages:
    """The logs of the measured runs and of those that the models on the way have made."""

    def __init__(
        self,
        measured: Logs,
        models: tuple[tuple[Sequence[Run], Model], ...],
        uncertain: Sequence[Sequence[Run]],
    ):
        """``models``: as given, refitted, with the effects; each with its balances' model.

        ``uncertain`` are runs of the last with parameters drawn from their uncertainty.
        """
        self._measured = measured
        self._models = [([prepared(run) for run in runs], known) for runs, known in models]
        self._uncertain = [[prepared(run) for run in runs] for runs in uncertain]

    def table(self, points: frozenset[Hashable], open_loop: bool) -> GapTable:
        """Return the gaps over some operating points."""
        balances = self._gaps(residuals, points)
        total = BeforeAfter(
            *(
                float(np.sqrt(np.mean([getattr(one, name) ** 2 for one in balances.values()])))
                for name in ("before", "refitted", "after", "floor")
            )
        )
        return GapTable(
            total=total,
            balances=balances,
            signals=self._gaps(signals, points),
            open_loop=self._gaps(astray, points) if open_loop else {},
        )

    def _gaps(self, view: View, points: frozenset[Hashable]) -> dict[str, BeforeAfter]:
        stages = []
        for logs, known in self._models:
            see = partial(_seen, view, known, points)
            stages.append(differences(see(self._measured), see(logs)))
        last = see(self._models[-1][0])
        floors = [_structured(differences(last, see(logs)), stages[-1]) for logs in self._uncertain]
        floor = np.sqrt(1 + np.mean(floors, axis=0)) if floors else np.ones(len(stages[0].names))
        columns = [_gaps(found) for found in stages]
        return {
            name: BeforeAfter(*[float(column[i]) for column in (*columns, floor)])
            for i, name in enumerate(stages[0].names)
            if all(np.isfinite(column[i]) for column in columns)
        }


def _seen(view: View, known: Model, points: frozenset[Hashable], logs: Logs) -> list[Windowed]:
    return [view(log, known) for log in logs if point_of(log.run.plan) in points]


def _gaps(found: GapMap) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.maximum(1 + column_means(found.excess), 0.0))


def _structured(found: GapMap, unit: GapMap) -> np.ndarray:
    """Return the mean square (c,) of a difference of models over the measured scatter."""
    scatter = np.sqrt(column_means(unit.scatter**2))
    with np.errstate(divide="ignore", invalid="ignore"):
        over = column_means(found.difference**2 - found.noise) / scatter**2
    return np.maximum(np.nan_to_num(over, posinf=0.0), 0.0)
