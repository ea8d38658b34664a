"""Which residuals matter: a made-up campaign that moves at constant speed and reverses."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.reconcile.gaps.log_map import Windows, log_map
from hbench.reconcile.search.materiality import matters

LENGTH, RUNS = 60, 12
NAMES = ("force_test", "force_load")
REVERSALS = np.abs(np.arange(LENGTH) % 20 - 10) < 2  # of each run


def residuals(steady, reversing):
    """Residuals of the first balance; a deviation of 1 is the limit."""
    rng = np.random.default_rng(1)
    run = np.repeat(np.arange(RUNS), LENGTH)
    at = np.tile(np.arange(LENGTH), RUNS)
    v = 0.1 * np.where((at + 10) // 20 % 2, 1.0, -1.0)
    points = tuple(f"point {i // 3}" for i in range(RUNS))
    windows = Windows(run, points, at * 0.1, at * 0.01, v, 0.0 * at)
    turns = np.tile(REVERSALS, RUNS)
    values = 0.1 * rng.standard_normal((len(run), 2))
    values[:, 0] += np.where(turns, reversing, steady) * rng.choice([-1, 1], RUNS)[run]
    found = log_map(windows, NAMES, values, np.zeros(2))
    return replace(found, material=1.0 / found.scatter[0])


@pytest.mark.parametrize(
    ("steady", "reversing", "told"),
    [(0.0, 0.0, False), (0.7, 0.7, False), (1.5, 0.0, True), (0.0, 2.0, True)],
)
def test_a_deviation_matters_over_all_windows_or_in_one_motion(steady, reversing, told):
    found = residuals(steady, reversing)
    assert matters(found, ("force_test",), np.arange(4)) is told
    assert not matters(found, ("force_load",), np.arange(4))


def test_all_matters_where_no_limit_is_known():
    assert matters(replace(residuals(0.0, 0.0), material=None), NAMES, np.arange(4))
