"""What benchmarks share: times of functions that take turns, and commands for the plant."""

import time
from collections.abc import Callable

import numpy as np

from hbench.model.plant import RATE_L2, Z_L, Z_T, X
from tests.support import ROOT

BENCH = ROOT / "configs" / "bench-aau.yaml"
STATES_IN_C = [*range(X, RATE_L2 + 1), Z_T, Z_L]  # of plant.c: all but those of a pump


def commands(ticks):
    """As the control loop's: other ones at each tick."""
    return np.array([0.7, 0.3, -1.4]) + np.random.default_rng(0).normal(0.0, 0.3, (ticks, 3))


CLEAR = 0.95  # share of a limit below which further rounds would hardly change the outcome
_FEWEST = 3  # rounds


def best_seconds(*functions, rounds=40, clear: Callable[..., bool] = lambda *best: False):
    """CPU time of each function, at the best of the rounds that they run in turn.

    From the third round on ``clear`` receives these times. No further rounds follow if it returns
    true; a result near a limit needs all of them.
    """
    best = [np.inf] * len(functions)
    for done in range(rounds):
        if done >= _FEWEST and clear(*best):
            break
        for i, function in enumerate(functions):
            before = time.process_time()
            function()
            best[i] = min(best[i], time.process_time() - before)
    return best
