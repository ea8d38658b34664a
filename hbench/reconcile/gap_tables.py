"""Gaps before and after, over some runs and of each, with the floor of a model that is right."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from hbench.reconcile.gap import GapMap, column_means, differences, gaps_of_runs, point_of
from hbench.reconcile.measured.balances import Model, Prepared, Windowed, prepared, residuals
from hbench.reconcile.measured.window_signals import astray, signals
from hbench.records import BeforeAfter, GapTable, Run, RunGap

Logs = Sequence[Prepared]
_VIEWS: Mapping[str, Callable[[Prepared, Model], Windowed]] = {
    "balances": residuals,
    "signals": signals,
    "open_loop": astray,
}


class Stages:
    """What the models on the way lack, window by window and run by run, in every view."""

    def __init__(
        self,
        measured: Logs,
        models: tuple[tuple[Sequence[Run], Model], ...],
        uncertain: Sequence[Sequence[Run]],
    ):
        """``models``: as given, refitted, with the effects; each with its balances' model.

        ``uncertain`` are runs of the last with parameters drawn from their uncertainty.
        """
        made = [([prepared(run) for run in runs], known) for runs, known in models]
        drawn = [[prepared(run) for run in runs] for runs in uncertain]
        self._plans = [log.run.plan for log in measured]
        self._views = {name: _View(view, measured, made, drawn) for name, view in _VIEWS.items()}

    def table(self, points: frozenset[Hashable]) -> GapTable:
        """Return the gaps over some operating points."""
        return _table({name: view.over(points) for name, view in self._views.items()})

    def runs(self, held_out: frozenset[Hashable]) -> tuple[RunGap, ...]:
        """Return the gaps of each run; ``held_out`` are operating points."""
        return tuple(
            RunGap(
                plan,
                point_of(plan) in held_out,
                _table({name: view.of_run(plan.run) for name, view in self._views.items()}),
            )
            for plan in self._plans
        )


class _View:
    """Balances or signals, of the measured runs and of those that the models have made."""

    def __init__(
        self,
        view: Callable[[Prepared, Model], Windowed],
        measured: Logs,
        made: Sequence[tuple[Logs, Model]],
        drawn: Sequence[Logs],
    ):
        sides = [(_seen(view, measured, known), _seen(view, logs, known)) for logs, known in made]
        self._maps = [differences(*both) for both in sides]
        self._runs = [gaps_of_runs(*both) for both in sides]
        self._points = {log.run.plan.run: point_of(log.run.plan) for log in measured}
        last, known = sides[-1][1], made[-1][1]
        self._drawn = [differences(last, _seen(view, logs, known)) for logs in drawn]

    def over(self, points: frozenset[Hashable]) -> dict[str, BeforeAfter]:
        return self._named([_gaps(_at(found, points)) for found in self._maps], points)

    def of_run(self, run: str) -> dict[str, BeforeAfter]:
        return self._named([each[run] for each in self._runs], frozenset({self._points[run]}))

    def _named(
        self, columns: Sequence[np.ndarray], points: frozenset[Hashable]
    ) -> dict[str, BeforeAfter]:
        """Return the gaps, a column a stage, with the floors of ``points``, by name."""
        unit = _at(self._maps[-1], points)
        floors = [_structured(_at(found, points), unit) for found in self._drawn]
        floor = np.sqrt(1 + np.mean(floors, axis=0)) if floors else np.ones(len(unit.names))
        return {
            name: BeforeAfter(*[float(column[i]) for column in (*columns, floor)])
            for i, name in enumerate(unit.names)
            if all(np.isfinite(column[i]) for column in columns)
        }


def _seen(view: Callable[[Prepared, Model], Windowed], logs: Logs, known: Model) -> list[Windowed]:
    """Return a view of each log; open loops, which are compiled, run side by side."""
    with ThreadPoolExecutor() as pool:
        return list(pool.map(lambda log: view(log, known), logs))


def _table(parts: dict[str, dict[str, BeforeAfter]]) -> GapTable:
    balances = parts["balances"].values()
    total = BeforeAfter(
        *(
            float(np.sqrt(np.mean([getattr(one, step) ** 2 for one in balances])))
            if balances
            else float("nan")
            for step in ("before", "refitted", "after", "floor")
        )
    )
    return GapTable(total=total, **parts)


def _at(found: GapMap, points: frozenset[Hashable]) -> GapMap:
    return found.at(np.array([i for i, point in enumerate(found.points) if point in points]))


def _gaps(found: GapMap) -> np.ndarray:
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.maximum(1 + column_means(found.excess), 0.0))


def _structured(found: GapMap, unit: GapMap) -> np.ndarray:
    """Return the mean square (c,) of a difference of models over the measured scatter."""
    scatter = np.sqrt(column_means(unit.scatter**2))
    with np.errstate(divide="ignore", invalid="ignore"):
        over = column_means(found.difference**2 - found.noise) / scatter**2
    return np.maximum(np.nan_to_num(over, posinf=0.0), 0.0)
