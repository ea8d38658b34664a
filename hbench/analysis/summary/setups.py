"""Set-ups of imported runs: strokes and speeds that were cut from one file are not independent.

A file whose name states its trial is one set-up: what differs from trial to trial, such as the
mounting or the oil's temperature, is common to all runs that were cut from it. Runs of a file with
several trials, and those of hbench's own benches, each count by themselves.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping

import numpy as np

from hbench.records import ScreenedRun


def setups_of(runs: Iterable[ScreenedRun], files: Mapping[str, str]) -> dict[str, str]:
    """Return the set-up of each run by its id; ``files`` are those that runs are from."""
    trials: dict[str, set[int]] = defaultdict(set)
    plans = [run.run.plan for run in runs]
    for plan in plans:
        trials[files.get(plan.run, "")].add(plan.trial)
    return {
        plan.run: f"file {files[plan.run]}"
        if plan.run in files and len(trials[files[plan.run]]) == 1
        else f"run {plan.run}"
        for plan in plans
    }


def sizes_and_sets(setup: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, int]:
    """Return the number of trials of each set-up (k,), and that of the sets of linked points.

    ``setup`` and ``point`` (n,) are the numbers of each trial's. Deviations from the means of the
    points sum to zero in each set of points that set-ups link.
    """
    setups, row = np.unique(setup, return_inverse=True)
    points, column = np.unique(point, return_inverse=True)
    return np.bincount(row), _linked_sets(row, column, len(setups), len(points))


def _linked_sets(setup: np.ndarray, point: np.ndarray, setups: int, points: int) -> int:
    """Return the number of sets of points that set-ups link; both (n,) count from 0."""
    lowest = np.arange(points)  # of the points in the set of each, as far as it is known
    while True:
        before, of_setup = lowest.copy(), np.full(setups, points)
        np.minimum.at(of_setup, setup, lowest[point])
        np.minimum.at(lowest, point, of_setup[setup])
        if np.array_equal(lowest, before):
            return len(np.unique(lowest))


def means_of_setups(values: np.ndarray, setup: np.ndarray) -> np.ndarray:
    """Return the mean of each set-up's values (k,)."""
    _, row = np.unique(setup, return_inverse=True)
    return np.bincount(row, values) / np.bincount(row)
