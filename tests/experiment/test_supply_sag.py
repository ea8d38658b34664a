"""The pump's supply in closed loop: figures 4.15 and 4.16, and the accumulator."""

from pathlib import Path

import numpy as np
import pytest

from hbench.config.bench import parse_plant
from hbench.config.files.loading import read_yaml
from hbench.model.supply import pump_rates
from hbench.studies.supply_sag import SUPPLIES, deviation, least_capacity, ramped, simulated_runs

DATA = read_yaml(Path(__file__).parents[2] / "configs" / "bench-aau.yaml")


@pytest.fixture(scope="module")
def runs():
    return {supply: simulated_runs(DATA, supply) for supply in SUPPLIES}


def test_the_pressure_sags_with_demand(runs):
    lowest = [run.p_s_pa.min() / 1e5 for run in runs["pump"]]
    assert (np.diff(lowest) < 0).all() and lowest[0] < 145 and lowest[-1] < 110
    assert min(run.p_s_pa.min() for run in runs["constant"]) > 149e5


def test_up_to_150_mm_s_is_held_and_197_is_not(runs):
    off = [1e3 * deviation(run) for run in runs["pump"]]
    assert max(off[:3]) < 2.0 and off[3] > 5.0
    assert max(1e3 * deviation(run) for run in runs["constant"]) < 2.0


def test_an_accumulator_cures_it(runs):
    cured = runs["pump, accumulator"]
    assert max(1e3 * deviation(run) for run in cured) < 2.0
    assert cured[-1].p_s_pa.min() > runs["pump"][-1].p_s_pa.min() + 20e5


def test_the_pressure_sags_deeper_on_a_steeper_ramp():
    lowest = [run.p_s_pa.min() / 1e5 for run in ramped(DATA)]
    assert (np.diff(lowest) < -2.0).all()


@pytest.mark.parametrize("ratio,swings", [(0.9, True), (1.1, False)])
def test_the_line_swings_at_rest_below_the_least_capacity(ratio, swings):
    """Eigenvalues of the pump's own equations, by differences."""
    pump = parse_plant(DATA, SUPPLIES["pump"], "pump").supply.pump.model_dump()

    class Par:
        has_pump = True
        flow_m3_s, cut_off_pa, band_pa = pump["flow"], pump["cut_off"], pump["band"]
        compensator_lag_s, swash_lag_s = pump["compensator_lag"], pump["swash_lag"]
        relief_pa, relief_gain, leakage = pump["relief"], pump["relief_gain"], pump["leakage"]
        capacity = ratio * least_capacity(pump)

    at, steps = np.array([150e5, 1e-5, 1e-5]), np.array([10.0, 1e-9, 1e-9])
    columns = [
        np.subtract(pump_rates(*(at + h * e), 0.0, Par),
                    pump_rates(*(at - h * e), 0.0, Par)) / (2 * h)
        for h, e in zip(steps, np.eye(3), strict=True)
    ]  # fmt: skip
    assert (np.linalg.eigvals(np.array(columns).T).real.max() > 0) == swings
