"""What benchmarks share: times of functions that take turns, and commands for the plant."""

import time

import numpy as np

from hbench.model.plant import RATE_L2, Z_L, Z_T, X
from tests.support import ROOT

BENCH = ROOT / "configs" / "bench-aau.yaml"
STATES_IN_C = [*range(X, RATE_L2 + 1), Z_T, Z_L]  # of plant.c: all but those of a pump


def commands(ticks):
    """As the control loop's: other ones at each tick."""
    return np.array([0.7, 0.3, -1.4]) + np.random.default_rng(0).normal(0.0, 0.3, (ticks, 3))


def best_seconds(*functions, rounds=40):
    """CPU time of each function, at the best of the rounds that they run in turn."""
    best = [np.inf] * len(functions)
    for _ in range(rounds):
        for i, function in enumerate(functions):
            before = time.process_time()
            function()
            best[i] = min(best[i], time.process_time() - before)
    return best
