"""Speed of the plant, as a ratio to scipy on the same compiled equations in the same run.

As in the closed loop the commands change every 100 us, so scipy integrates tick by tick.
"""

import time
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hbench.config.bench import parse_bench
from hbench.config.loading import read_yaml
from hbench.model.parameters import plant_parameters
from hbench.model.plant import TICK_S, derivatives, initial_state
from hbench.model.simulation import simulate

BENCH = Path(__file__).parents[2] / "configs" / "bench-aau.yaml"
TICKS = 10_000
TICKS_OF_SCIPY = 200


@pytest.fixture(scope="module")
def par():
    return plant_parameters(parse_bench(read_yaml(BENCH), str(BENCH)))


@pytest.fixture(scope="module")
def start(par):
    return initial_state(par, 0.1, 15e5, 20e5)


@pytest.fixture(scope="module")
def commands():
    hiss = np.random.default_rng(0).normal(0.0, 0.3, (TICKS, 3))
    return np.array([0.7, 0.3, -1.4]) + hiss


def scipy_seconds_per_tick(par, start, commands):
    """Return the time of one tick, at the best of three runs, and the state after the run."""
    out, levels = np.empty_like(start), np.ones(2)

    def rhs(t, y, u):
        derivatives(y, u, levels, par, out)
        return out.copy()

    rhs(0.0, start, commands[0])
    best = np.inf
    for _ in range(3):
        state, before = start, time.perf_counter()
        for u in commands[:TICKS_OF_SCIPY]:
            state = solve_ivp(rhs, (0.0, TICK_S), state, "DOP853", args=(u,)).y[:, -1]
        best = min(best, time.perf_counter() - before)
    return best / TICKS_OF_SCIPY, state


def test_a_tick_is_hundreds_of_times_faster_than_scipy(benchmark, par, start, commands):
    run = benchmark(simulate, par, start, commands)
    scipy_s, state = scipy_seconds_per_tick(par, start, commands)
    assert run.state[TICKS_OF_SCIPY] == pytest.approx(state, rel=1e-3, abs=1e-6)
    if benchmark.stats is None:  # --benchmark-disable: the comparison of states is left
        return
    tick_s = benchmark.stats.stats.min / TICKS
    ratio = scipy_s / tick_s
    benchmark.extra_info.update(ns_per_tick=tick_s * 1e9, scipy_over_plant=ratio)
    assert 200 < ratio < 4000
