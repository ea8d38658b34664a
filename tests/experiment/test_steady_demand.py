"""Steady states that a schedule needs: against the rig, and what cannot be held."""

import pytest
import yaml

from hbench import workflow
from hbench.errors import ConfigError
from hbench.experiment.closed_loop import record_plans
from tests.support import ROOT


def schedule(tmp_path, supply="150 bar", **changes):
    data = yaml.safe_load((ROOT / "configs" / "demo.yaml").read_text())
    data["experiments"] = [data["experiments"][0] | {"trials": 1} | changes]
    bench = yaml.safe_load((ROOT / "configs" / "bench-aau.yaml").read_text())
    bench["supply"]["pressure"] = supply
    (tmp_path / "bench.yaml").write_text(yaml.safe_dump(bench))
    data["bench"] = "bench.yaml"
    path = tmp_path / "demand.yaml"
    path.write_text(yaml.safe_dump(data))
    return workflow.load_experiment(path, None)


def test_openings_and_pressures_are_those_of_the_rig(tmp_path):
    experiment = schedule(tmp_path, loads=["2 kN"], velocities=["150 mm/s"])
    demand = workflow.demand(experiment)
    (run,) = record_plans(experiment.bench, experiment.plan.runs, seed=3).runs
    steady = run.at_reference
    steady[: len(steady) // 2] = False
    valves = [abs(run.channel(name)[steady].mean()) for name in ("u_t_v", "u_l1_v", "u_l2_v")]
    assert demand.valve_v == pytest.approx(max(valves), rel=0.05)
    names = ("p_tp_pa", "p_tr_pa", "p_lp_pa", "p_lr_pa")
    pressures = [run.channel(name)[steady].mean() for name in names]
    assert demand.p_highest_pa == pytest.approx(max(pressures), rel=0.1)
    assert demand.p_lowest_pa == pytest.approx(min(pressures), rel=0.1)
    bench = experiment.bench
    area = bench.test_cylinder.area_piston_m2 + bench.load_cylinder.area_rod_m2
    assert demand.flow_m3_s == pytest.approx(0.150 * area)


def test_what_the_supply_cannot_hold_is_refused_with_numbers(tmp_path):
    with pytest.raises(ConfigError) as refused:
        workflow.demand(schedule(tmp_path, supply="100 bar", loads=["11 kN"]))
    assert "1.1e+04 N" in refused.value.message


def test_in_runs_with_changing_velocity_it_is_a_note(tmp_path):
    """A triangle nearly without load, at whose peak the load's piston side would be below 0."""
    data = yaml.safe_load((ROOT / "configs" / "dynamics.yaml").read_text())
    lower = [
        each | ({"p_lr": "5 bar"} if each.get("p_lr") == "10 bar" else {})
        for each in data["experiments"]
    ]
    data |= {"bench": str(ROOT / "configs" / "bench-aau.yaml"), "experiments": lower}
    (tmp_path / "low.yaml").write_text(yaml.safe_dump(data))
    demand = workflow.demand(workflow.load_experiment(tmp_path / "low.yaml", None))
    assert demand.not_held and demand.valve_v <= demand.valve_limit_v


def test_a_schedule_at_rest_needs_nothing(tmp_path):
    hold = {
        "kind": "hold",
        "p_lr": "15 bar",
        "loads": ["500 N"],
        "hold": "1 s",
        "positions": ["200 mm"],
    }
    data = {"name": "rest", "bench": str(ROOT / "configs" / "bench-aau.yaml")}
    path = tmp_path / "rest.yaml"
    path.write_text(yaml.safe_dump(data | {"experiments": [hold | {"duration": "2 s"}]}))
    assert workflow.demand(workflow.load_experiment(path, None)) is None
