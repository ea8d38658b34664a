"""Columns of the linearised model: means of window values over the trials, and differences."""

from collections.abc import Hashable, Sequence

import numpy as np

from hbench.reconcile.gaps.gap_map import by_point
from hbench.reconcile.measured.balances import BalanceModel, WindowedRun, residuals
from hbench.records import Run

ModelColumn = dict[Hashable, np.ndarray]  # by operating point: (m, balances)


def residuals_of_runs(runs: Sequence[Run], model: BalanceModel) -> list[WindowedRun]:
    """Return the residuals of all balances for each run."""
    return [residuals(run, model) for run in runs]


def mean_column(runs: Sequence[WindowedRun]) -> ModelColumn:
    """Return the means over the trials of each operating point."""
    return {
        point: np.mean(
            [trial.values[: min(len(each.t_s) for each in trials)] for trial in trials], axis=0
        )
        for point, trials in by_point(runs).items()
    }


def column_difference(minuend: ModelColumn, subtrahend: ModelColumn) -> ModelColumn:
    """Return the difference of two columns over the windows that both have."""
    difference = {}
    for point in minuend.keys() & subtrahend.keys():
        m = min(len(minuend[point]), len(subtrahend[point]))
        difference[point] = minuend[point][:m] - subtrahend[point][:m]
    return difference
