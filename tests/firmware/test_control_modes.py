"""Optional control modes: velocity from an accelerometer, force by the load cell or a friction law.

Off by default. The plant's friction is LuGre's with seals that depend on pressure, not the law on
the board, whose parameters are 10 % too low.
"""

import numpy as np
import pytest
from pydantic import ValidationError

from hbench.config.bench import LoadControl, parse_bench
from hbench.config.files.loading import read_yaml
from hbench.config.schedule import parse_schedule
from hbench.errors import ConfigError
from hbench.experiment.closed_loop import record
from hbench.experiment.plan import plan_runs
from hbench.experiment.steady_demand import steady_demand
from tests.support import ROOT

T = 1e-4
FILE = ROOT / "configs" / "bench-aau.yaml"
ACCELEROMETER = {"span": "100 m/s^2", "output": "5 V", "amplifier": 0.6, "offset": "1.5 V"}
LAW = {"coulomb": "162 N", "stiction": "234 N", "stribeck_velocity": "54 mm/s"}


def bench(load=None, sensors=None, **controllers):
    data = read_yaml(FILE)
    data["controllers"] |= controllers | ({"load": load} if load else {})
    data["sensors"] |= sensors or {}
    return parse_bench(data, "bench")


def steady(direction, load, speeds, **more):
    return {
        "kind": "steady",
        "direction": direction,
        "p_lr": "15 bar" if direction == "extend" else "110 bar",
        "loads": [load],
        "velocities": speeds,
        "trials": 1,
        "travel": {"start": "100 mm", "end": "280 mm"},
        "acceleration": "1 m/s^2",
        "hold": "0.5 s",
        "window": "0.6 s",
    } | more


RUNS = {
    "name": "both directions",
    "experiments": [
        steady("extend", "2000 N", ["10 mm/s", "150 mm/s"]),
        steady("retract", "-2000 N", ["10 mm/s", "150 mm/s"]),
    ],
}


def test_with_the_exact_acceleration_the_velocity_has_no_lag(probes):
    """D.11 with D.23: a sine at the filter's bandwidth, which D.11 alone shifts by 45 degrees."""
    tau, t = 5e-3, T * np.arange(20_000)
    omega = 1 / tau
    x = (0.001 * np.sin(omega * t)).astype(np.float32)
    v = 0.001 * omega * np.cos(omega * t)
    a = (-0.001 * omega**2 * np.sin(omega * t)).astype(np.float32)
    settled = t > 20 * tau
    alone = np.abs(probes.velocity(tau, T, x) - v)[settled].max() / v.max()
    both = np.abs(probes.velocity(tau, T, x, a) - v)[settled].max() / v.max()
    assert alone > 0.6 and both < 0.02


def test_without_the_position_it_is_equation_d23(probes):
    a = np.random.default_rng(2).standard_normal(500).astype(np.float32)
    v = probes.velocity(1e9, T, np.zeros_like(a), a)
    np.testing.assert_allclose(v, np.cumsum(a.astype(float)) * T, atol=1e-6)


def test_an_offset_of_the_accelerometer_adds_no_more_than_its_product_with_tau(probes):
    tau = 0.02
    v = probes.velocity(tau, T, np.zeros(5000, np.float32), np.full(5000, 0.3, np.float32))
    assert v[-1] == pytest.approx(0.3 * tau, rel=0.01)


@pytest.fixture(scope="module")
def force_errors():
    """Mean error of the force [N] between the cylinders, of each run, by the loop that is used."""
    modes = {
        "pressures": None,
        "load_cell": {"by": "load_cell"},
        "friction_law": {"by": "friction_law", "friction": LAW | {"viscous": "2700 N s/m"}},
    }
    found = {}
    for name, load in modes.items():
        recorded = record(bench(load), RUNS)
        assert not recorded.stopped and len(recorded.runs) == 4
        found[name] = np.array(
            [
                run.f_applied_n[run.at_reference][-40:].mean() - run.plan.f_load_n
                for run in recorded.runs
            ]
        )
    return found


def test_with_pressures_alone_friction_of_the_load_cylinder_is_added(force_errors):
    assert np.all(np.abs(force_errors["pressures"]) > 200)
    print({name: errors.round() for name, errors in force_errors.items()})


def test_the_load_cell_makes_the_force_right(force_errors):
    assert np.abs(force_errors["load_cell"]).max() < 25  # what the integral has not removed yet


def test_a_friction_law_that_is_10_percent_too_low_leaves_a_part(force_errors):
    left = np.abs(force_errors["friction_law"]) / np.abs(force_errors["pressures"])
    assert left.max() < 0.4


def test_in_a_campaign_an_accelerometer_takes_the_lag_out_of_the_logged_velocity():
    """With a slow filter, so that the lag of D.11 shows at the ramps."""
    lags = {}
    schedule = {"name": "ramp", "experiments": [steady("extend", "2000 N", ["150 mm/s"])]}
    for name, sensors in (("position", {}), ("both", {"accelerometer": ACCELEROMETER})):
        (run,) = record(bench(None, sensors, velocity_filter="10 ms"), schedule).runs
        assert not run.truncated
        true = np.gradient(run.x_m, run.t_s)
        rising = (run.v_m_s > 0.03) & (run.v_m_s < 0.12) & ~run.at_reference
        lags[name] = np.median((true - run.v_m_s)[rising]) / 1.0  # at 1 m/s^2
    print(
        f"lag {1e3 * lags['position']:.1f} ms with the position alone, {1e3 * lags['both']:.1f} ms"
    )
    assert lags["position"] > 7e-3 and abs(lags["both"]) < 2e-3


def test_one_input_takes_one_sensor_and_a_law_needs_its_friction():
    temperature = {"span": "100 K", "lowest": "0 degC", "output": "10 V", "amplifier": 0.3}
    with pytest.raises(ConfigError, match="accelerometer"):
        bench(None, {"accelerometer": ACCELEROMETER, "temperature": temperature})
    for wrong in ({"by": "friction_law"}, {"by": "load_cell", "friction": {}}):
        with pytest.raises(ValidationError):
            LoadControl(**wrong)


@pytest.mark.parametrize(
    ("setting", "name"),
    [({"load_control": 1.0}, "f_applied"), ({"acceleration_gain_m_s2": 1e-6}, "auxiliary")],
)
@pytest.mark.parametrize("word", [0, 65_520])
@pytest.mark.parametrize("used", [False, True])
def test_only_a_sensor_that_a_loop_uses_stops_the_board_at_the_ends_of_its_range(
    board, setting, name, word, used
):
    assert board.write_settings(**(setting if used else {})) == b""
    board.rest(0.05, x=0.06)
    assert board.start() == b""
    board.tick()
    assert board.cause() == ("running", "none")
    board.raw[name] = word
    board.tick()
    assert board.cause() == (("fault", "sensor") if used else ("running", "none"))


def test_the_check_before_the_runs_refuses_a_load_below_the_load_cylinders_friction():
    """Without its friction P_Lp would have to be below the tank's pressure."""
    schedule = {"name": "light", "experiments": [steady("extend", "500 N", ["200 mm/s"])]}
    for load, held in ((None, True), ({"by": "load_cell"}, False)):
        used = bench(load)
        plans = plan_runs(parse_schedule(schedule, "light"), used, "light").runs
        if held:
            assert steady_demand(plans, used, "light").p_lowest_pa > 2e5
        else:
            with pytest.raises(ConfigError, match="200 mm/s"):
                steady_demand(plans, used, "light")
