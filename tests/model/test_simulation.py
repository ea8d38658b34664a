import subprocess
import sys

import numpy as np
import pytest

from hbench.errors import ConfigError
from hbench.model.plant import P_LP, P_LR, P_TP, P_TR, V, X, initial_state
from hbench.model.simulation import simulate

BAR = 1e5


@pytest.mark.parametrize("p_lp", [9.6, 20.0, 88.7, 120.0])
@pytest.mark.parametrize("p_lr", [15.0, 110.0])
def test_initial_state_stays_at_rest(par, p_lr, p_lp):
    state = initial_state(par, 0.1, p_lr * BAR, p_lp * BAR)
    run = simulate(par, state, np.zeros((2000, 3)))
    assert run.state[-1] == pytest.approx(state, rel=1e-12, abs=1e-12)
    assert run.f_applied_n[-1] == pytest.approx(
        1.25664e-3 * state[P_LP] - 7.65763e-4 * state[P_LR], abs=0.1
    )
    assert np.all(state[[P_TP, P_TR]] >= 2 * BAR)
    assert np.all(state[[P_TP, P_TR]] <= 150 * BAR)


def test_a_load_beyond_the_supply_is_refused(par):
    with pytest.raises(ConfigError, match=r"\b25035 N\b"):
        initial_state(par, 0.1, 2 * BAR, 200.44 * BAR)


def test_positive_voltage_extends(par):
    state = initial_state(par, 0.1, 15 * BAR, 20 * BAR)
    run = simulate(par, state, np.tile([0.7, 0.3, -1.4], (3000, 1)))
    assert run.state[-1, V] > 0.02
    assert run.state[-1, X] > 0.1
    back = simulate(par, state, np.tile([-0.7, -0.3, 1.4], (3000, 1)))
    assert back.state[-1, V] < -0.02


def test_same_seed_same_bytes(par, there_and_back):
    state = initial_state(par, 0.15, 15 * BAR, 20 * BAR)

    def bytes_of(seed):
        return simulate(par, state, there_and_back, seed).state.tobytes()

    assert bytes_of(1) == bytes_of(1)
    assert bytes_of(1) != bytes_of(2)
    assert bytes_of(None) == bytes_of(None)


def test_scatter_moves_friction_by_its_standard_deviation(par, there_and_back):
    """Friction of 80 strokes at one speed, against the bench file's 1.5 % of the dry part."""
    state = initial_state(par, 0.15, 15 * BAR, 20 * BAR)
    commands = there_and_back[:4000]
    dry = [
        run.friction_test_n[-1] - par.test.friction.viscous * run.state[-1, V]
        for run in (simulate(par, state, commands, seed) for seed in range(80))
    ]
    spread = np.std(dry) / np.mean(dry)
    assert spread == pytest.approx(par.test.friction.scatter, rel=0.3)


REUSE = """
import sys
from pathlib import Path
import numpy as np
from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.model import simulation
from hbench.model.build import plant_parameters
from hbench.model.plant import initial_state

par = plant_parameters(parse_bench(read_yaml(Path(sys.argv[1])), "bench"))
simulation.simulate(par, initial_state(par, 0.1, 15e5, 20e5), np.zeros((2, 3)))
stats = simulation._run.stats
print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""


def test_compiled_code_is_reused_by_another_process(par, bench_file, tmp_path):
    simulate(par, initial_state(par, 0.1, 15 * BAR, 20 * BAR), np.zeros((2, 3)))
    second = subprocess.run(
        [sys.executable, "-c", REUSE, str(bench_file)],
        capture_output=True,
        text=True,
        check=True,
        cwd=tmp_path,  # a checkout in the working folder would be imported instead
    )
    assert second.stdout.split() == ["1", "0"]
