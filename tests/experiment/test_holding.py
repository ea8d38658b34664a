"""The default rig holds every reference of the source's schedule, with room to spare."""

import json
from pathlib import Path

import numpy as np
import pytest

from hbench import workflow
from hbench.analysis.screening.calibrate import calibrate
from hbench.analysis.screening.screen import screen
from hbench.config.files.loading import read_yaml
from hbench.store.campaign.folder import load_campaign
from tests.support.rig_campaign import measure_on_rig

CONFIGS = Path(__file__).parents[2] / "configs"
VARIED = ("coulomb", "stiction", "stribeck_velocity", "viscous", "bristle_stiffness")


def held(folder, plant, speeds):
    """Worst deviations over all references: mean speed, its ripple [m/s], load pressures [Pa]."""
    folder.mkdir()
    data = read_yaml(CONFIGS / "stribeck.yaml")
    data["experiments"] = data["experiments"][1:-1]  # without its zero checks
    for experiment in data["experiments"]:
        experiment |= {"velocities": speeds, "trials": 1}
    schedule, plant_file = folder / "schedule.yaml", folder / "plant.yaml"
    schedule.write_text(json.dumps(data | {"bench": str(CONFIGS / "bench-aau.yaml")}))
    plant_file.write_text(json.dumps(plant))
    measure_on_rig(workflow.load_experiment(schedule, None), folder / "campaign", plant=plant_file)
    campaign = load_campaign(folder / "campaign")
    rows = []
    for raw in campaign.raw_runs():
        run = calibrate(raw, campaign.bench())
        screened = screen(run, campaign.screening())
        assert screened.accepted, (run.plan, screened.reasons)
        window = (run.t_s > screened.means.t_start_s) & (run.t_s < screened.means.t_stop_s)
        rows.append(
            (
                abs(screened.means.v_m_s - run.plan.v_ref_m_s),
                run.v_m_s[window].std(),
                abs(run.p_lr_pa[window].mean() - run.plan.p_lr_ref_pa),
                abs(run.p_lp_pa[window].mean() - run.plan.p_lp_ref_pa),
            )
        )
    speed, ripple, p_lr, p_lp = np.max(rows, axis=0)
    print(f"{1e3 * speed:.3f} {1e3 * ripple:.3f} mm/s, {max(p_lr, p_lp) / 1e5:.3f} bar")
    return speed, ripple, max(p_lr, p_lp)


def test_every_load_and_direction_is_held_from_the_slowest_to_the_fastest_speed(tmp_path):
    speed, ripple, pressure = held(tmp_path / "a", {}, ["5 mm/s", "60 mm/s", "200 mm/s"])
    assert speed < 0.2e-3 and ripple < 0.5e-3 and pressure < 0.4e5


@pytest.mark.slow
def test_references_are_held_with_every_value_of_the_friction_varied_by_20_percent(tmp_path):
    rng = np.random.default_rng(0)
    friction = read_yaml(CONFIGS / "bench-aau.yaml")["friction"]
    for draw in range(15):
        plant = {"friction": {side: {} for side in friction}}
        for side, values in friction.items():
            for name in VARIED:
                number, unit = values[name].split(" ", 1)
                plant["friction"][side][name] = f"{float(number) * rng.uniform(0.8, 1.2)} {unit}"
        speeds = ["5 mm/s", "20 mm/s", "60 mm/s", "120 mm/s", "200 mm/s"]
        speed, ripple, pressure = held(tmp_path / str(draw), plant, speeds)
        assert speed < 0.25e-3 and ripple < 0.7e-3 and pressure < 0.4e5
