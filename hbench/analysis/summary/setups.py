"""Set-ups of imported runs: strokes and speeds that were cut from one file are not independent.

A file whose name states its trial is one set-up: what differs from trial to trial, such as the
mounting or the oil's temperature, is common to all runs that were cut from it. Runs of a file with
several trials, and those of hbench's own benches, each count by themselves.
"""

from collections import defaultdict
from collections.abc import Iterable, Mapping

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

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
    count = len(setups) + len(points)
    links = coo_array((np.ones(len(row)), (row, len(setups) + column)), shape=(count, count))
    return np.bincount(row), int(connected_components(links, directed=False)[0])


def means_of_setups(values: np.ndarray, setup: np.ndarray) -> np.ndarray:
    """Return the mean of each set-up's values (k,)."""
    _, row = np.unique(setup, return_inverse=True)
    return np.bincount(row, values) / np.bincount(row)
