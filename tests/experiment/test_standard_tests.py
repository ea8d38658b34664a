"""Acceptance test, run-in and endurance on plants whose leakage, friction and wear are known.

None of the laws is one that the analysis assumes: orifices, a static law with the exponent 2,
bristles with the exponent 0.7, and wear by an effect that is not in the catalogue.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench.analysis.conformity.acceptance import conformity_checks
from hbench.cli.commands.init import _FILES
from hbench.config.conformity.limits import parse_limits
from hbench.config.files.loading import read_yaml
from hbench.config.files.sized_examples import Size
from hbench.workflow import sized_files
from hbench.workflow.controllers import RATIOS
from hbench.workflow.results import derive
from tests.support import ROOT

CONFIGS = ROOT / "configs"
WEAR = Path(__file__).parent / "wearing_plant.py"
ML_MIN = 1e-6 / 60
APPROACH_M = 0.16  # to the first start position; hbench does not know this distance
BREAKAWAY, FRICTION, SLIP, PISTON, ROD = range(5)  # limits of the shipped file
PLANTS = {
    "shipped": ({}, set()),
    "orifice across the piston": (
        {"effects": {"internal_leakage": {"test": "0.00015 l/min/bar", "exponent": 0.5}}},
        {PISTON},
    ),
    "leaking rod seal": ({"effects": {"external_leakage": {"tr": "0.00002 l/min/bar"}}}, {ROD}),
    "high friction": (
        {
            "friction": {
                "test": {
                    **{"coulomb": "600 N", "stiction": "1400 N", "stribeck_exponent": 0.7},
                    "bristle_stiffness": "1e6 N/m",
                }
            }
        },
        {BREAKAWAY, FRICTION},
    ),
    "stick-slip": (
        {
            "friction": {
                "test": {
                    **{"law": "tustin", "coulomb": "150 N", "stiction": "700 N"},
                    **{"stribeck_velocity": "8 mm/s", "stribeck_exponent": 2},
                    "viscous": "2500 N s/m",
                }
            }
        },
        {SLIP},
    ),
}


def shortened(folder, kinds=(), **changes):
    """Write the shipped acceptance test with other values of keys that an experiment has."""
    schedule = read_yaml(CONFIGS / "acceptance-test.yaml") | {
        "bench": str(CONFIGS / "bench-aau.yaml")
    }
    schedule["experiments"] = [
        experiment | {key: value for key, value in changes.items() if key in experiment}
        for experiment in schedule["experiments"]
        if not kinds or experiment["kind"] in kinds
    ]
    file = folder / "schedule.yaml"
    file.write_text(yaml.safe_dump(schedule))
    return file


def accepted(results):
    """Return the decisions by the number of the limit in the shipped file."""
    data = read_yaml(CONFIGS / "acceptance-limits.yaml")
    limits = parse_limits(data, "limits")
    requirements = [limit.requirement for limit in limits.limits]
    checks = conformity_checks(results, requirements, limits.rule, None)
    return [
        (requirements.index(check.requirement), check.decision, check.measurement)
        for check in checks
    ]


def plant_file(folder, plant):
    file = folder / "plant.yaml"
    file.write_text(yaml.safe_dump(plant))
    return file


def test_all_pushes_of_a_large_cylinder_show_a_breakaway(tmp_path, on_the_rig, monkeypatch):
    """With the trials of a direction one after the other, a retracting push showed none."""
    monkeypatch.setattr("hbench.workflow.example_files.RATIOS", RATIOS[:1])  # seconds each
    examples = {name: (CONFIGS / name).read_text() for name in _FILES}
    files = sized_files(examples, Size(0.125, 0.090, 0.500, 250e5)).files
    schedule = yaml.safe_load(files["acceptance-test.yaml"])
    pushes = [one for one in schedule["experiments"] if one["kind"] == "breakaway"]
    (tmp_path / "bench.yaml").write_text(files["bench.yaml"])
    (tmp_path / "schedule.yaml").write_text(yaml.safe_dump(schedule | {"experiments": pushes}))
    results = derive(on_the_rig(tmp_path / "schedule.yaml", tmp_path / "campaign"))
    assert [run.reasons for run in results.runs] == 6 * [()]
    found = {push.direction: push.n for push in results.motions.breakaways}
    assert found == {"extend": 3, "retract": 3}


def test_a_leaking_piston_seal_fails_with_the_flow_of_its_orifice(tmp_path, on_the_rig):
    plant, _ = PLANTS["orifice across the piston"]
    file = shortened(tmp_path, kinds={"hold"}, duration="5 s")
    campaign = on_the_rig(file, tmp_path / "campaign", plant=plant_file(tmp_path, plant))
    by_limit = {limit: (decision, m) for limit, decision, m in accepted(derive(campaign))}
    decision, across = by_limit[PISTON]
    true = 7.5 * np.sqrt(2)  # ml/min at 100 bar; 7.5 at 50 bar
    print(f"{across.value / ML_MIN:.3f} ± {across.u95 / ML_MIN:.3f} ml/min, true {true:.3f}")
    assert decision == "FAIL" and across.value / ML_MIN == pytest.approx(true, rel=0.005)
    decision, rod = by_limit[ROD]
    assert decision == "PASS" and abs(rod.value) < 0.05 * ML_MIN


@pytest.mark.slow
@pytest.mark.parametrize("name", PLANTS)
def test_the_acceptance_test_fails_a_cylinder_for_its_own_fault(name, tmp_path, on_the_rig):
    plant, faults = PLANTS[name]
    file = shortened(tmp_path, dwells=["5 s"], duration="10 s")
    campaign = on_the_rig(file, tmp_path / "campaign", plant=plant_file(tmp_path, plant))
    results = derive(campaign)
    decisions = accepted(results)
    for limit, decision, measured in decisions:
        print(name, limit, decision, measured)
    assert {limit for limit, decision, _ in decisions if decision == "FAIL"} == faults
    # Stick-slip leaves no steady friction to measure.
    not_tested = {limit for limit, decision, _ in decisions if decision == "NOT TESTED"}
    assert not_tested == ({FRICTION} if name == "stick-slip" else set())


def over_distance(schedule, plant, folder):
    """Make a campaign on a plant that wears, and return its trends from results.json."""
    environment = os.environ | {"HBENCH_EFFECTS": str(WEAR), "PYTHONPATH": str(ROOT)}
    campaign, file = folder / "campaign", plant_file(folder, {"effects": {"wear": plant}})
    for arguments in (
        ["run", CONFIGS / schedule, "-o", campaign, "--plant", file],
        ["analyze", campaign],
    ):
        made = subprocess.run(
            [sys.executable, "-m", "hbench", *map(str, arguments)],
            capture_output=True, text=True, env=environment,
        )  # fmt: skip
        assert made.returncode == 0, made.stderr
    return json.loads((campaign / "results" / "results.json").read_text())["over_distance"]


@pytest.mark.slow
def test_run_in_is_the_exponential_of_the_plant_and_settles(tmp_path):
    slow, fast = over_distance("run-in.yaml", {"run_in": "150 N", "length": "4 m"}, tmp_path)
    at, friction = np.array(slow["distance_m"]), np.array(slow["values"])
    shape = np.exp(-at / 4.0)
    run_in, settled = np.polyfit(shape, friction, 1)
    true = 150 * np.exp(-APPROACH_M / 4.0)
    print(f"run-in by {run_in:.1f} N, true {true:.1f} N; settled at {settled:.1f} N")
    assert run_in == pytest.approx(true, rel=0.02)
    assert np.std(friction - settled - run_in * shape) < 0.01 * settled
    assert slow["p_holm"] < 1e-6 and fast["verdict"] == "settled" and fast["p_holm"] > 0.05


@pytest.mark.slow
def test_endurance_finds_the_wear_of_friction_breakaway_and_leakage(tmp_path):
    """Twenty blocks of ten cycles instead of eight of 25.

    The values of half of the distance decide whether friction still changes at the end. Their
    scatter is 5 to 8 N: by the noncentral t distribution a trend of 0.8 N/m is then missed at most
    once in 1000 draws, with eight blocks in 20 to 52 % of them.
    """
    text = (CONFIGS / "endurance.yaml").read_text()
    longer = tmp_path / "endurance.yaml"
    longer.write_text(
        text.replace("&blocks 8", "&blocks 20")
        .replace("cycles: 25", "cycles: 10")
        .replace("bench-aau.yaml", str(CONFIGS / "bench-aau.yaml"), 1)
    )
    plant = {"loss": "0.8 N/m", "leak": "0.05 ml/min/m"}
    trends = over_distance(longer, plant, tmp_path)
    kinds = [trend["kind"] for trend in trends]
    assert sorted(kinds) == ["breakaway"] * 2 + ["hold"] * 2 + ["steady"] * 2 + ["triangle"]
    for trend in trends:
        true = -0.8
        if trend["quantity"] == "leakage_m3_s":
            bar = 85.0 if trend["f_load_n"] > 0 else 139.0  # as the holds reach without a leak
            true = 0.05 * ML_MIN * np.sqrt(bar / 100)
        found, half = trend["slope"], trend["slope_ci95"]
        print(f"{trend['kind']} {trend['direction']}: {found / true:.3f} ± {half / abs(true):.3f}")
        assert abs(found - true) < 1.5 * half + 0.02 * abs(true)
        assert trend["verdict"] == "changing" and trend["p_holm"] < 1e-3
