"""Each effect, at its typical size, on the virtual rig: the firmware still runs a schedule."""

import numpy as np
import pytest

from hbench.config.bench import parse_bench, parse_plant
from hbench.config.files.loading import read_yaml
from hbench.experiment.closed_loop import record
from hbench.model.effects.catalogue import EFFECTS
from tests.support import ROOT

BENCH = read_yaml(ROOT / "configs" / "bench-aau.yaml")
RUN = {
    "p_lr": "15 bar",
    "loads": ["2000 N"],
    "trials": 1,
    "hold": "0.1 s",
}
SCHEDULE = {
    "name": "effects",
    "experiments": [
        RUN | {
            "kind": "triangle", "speed": "150 mm/s", "cycles": 1,
            "travel": {"start": "150 mm", "end": "250 mm"},
        },
        RUN | {
            "kind": "ramp", "speed": "150 mm/s", "accelerations": ["0.2 m/s^2"],
            "travel": {"start": "250 mm", "end": "355 mm"}, "direction": "extend",
        },
    ],
}  # fmt: skip
PRESSURES = ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa", "p_s_pa")
SIGNALS = ("x_m", "v_m_s", *PRESSURES, "f_applied_n", "u_t_v")


def made(effects):
    sensors = {"adc": {"noisy": False}}
    scatter = {side: {"scatter": "0 %"} for side in ("test", "load")}
    over = {"sensors": sensors, "friction": scatter, "effects": effects}
    plant = parse_plant(BENCH, over, "plant")
    return record(parse_bench(BENCH, "bench"), SCHEDULE, plant)


def typical(name):
    return {
        key: f"{one.typical or one.default} {one.unit}"
        for key, one in EFFECTS[name].coefficients.items()
    }


@pytest.fixture(scope="module")
def without():
    return made({}).runs


@pytest.mark.parametrize("name", EFFECTS)
def test_a_schedule_runs_and_its_log_is_another(without, name):
    got = made({name: typical(name)})
    assert got.stopped == "" and len(got.runs) == got.planned == 2
    different = 0.0
    for one, other in zip(got.runs, without, strict=True):
        n = min(len(one.t_s), len(other.t_s))
        for signal in SIGNALS:
            a, b = getattr(one, signal)[:n], getattr(other, signal)[:n]
            different = max(different, np.abs(a - b).max() / (np.ptp(b) + 1e-9))
    assert different > 2e-3


def lag_s(run):
    """tau of x' = v + tau v', central differences, by least squares where it moves."""
    x, v, t = run.x_m, run.v_m_s, run.t_s
    speed, slope = np.gradient(x, t)[2:-2], np.gradient(v, t)[2:-2]
    away = np.abs(slope) > 0.05
    return float(np.sum((speed - v[2:-2]) * away * slope) / np.sum(away * slope**2))


def test_a_slower_velocity_filter_shows_in_the_logged_velocity_alone(without):
    slower = made({"velocity_filter_lag": {"time": "6 ms"}}).runs
    change = lag_s(slower[0]) - lag_s(without[0])
    assert change == pytest.approx(6e-3, rel=0.15)


def test_an_effect_that_the_bench_cannot_bear_ends_with_the_boards_reason():
    """A valve that lags by 100 ms makes the velocity loop unstable."""
    got = made({"valve_lag": {"time": "100 ms"}})
    assert len(got.runs) < got.planned and "stopped" in got.stopped
