"""The shipped schedules run to their end within the shipped bench's limits, with room to spare."""

import json
from pathlib import Path

import pytest

from hbench.config.files.loading import read_yaml

CONFIGS = Path(__file__).parents[2] / "configs"
CLOSER = {"speed_error": "30 mm/s", "stopping_time": "20 ms", "speed_max": "300 mm/s"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    ["demo", "dynamics", "breakaway", "discriminate", "warm-up", "stribeck"]
    + ["acceptance-test", "run-in", "endurance"],
)
def test_no_limit_stops_a_shipped_schedule_even_when_limits_are_a_quarter_closer(
    name, tmp_path, on_the_rig
):
    bench, schedule = (read_yaml(CONFIGS / f"{file}.yaml") for file in ("bench-aau", name))
    bench["limits"] |= CLOSER
    (tmp_path / "bench.yaml").write_text(json.dumps(bench))
    (tmp_path / "schedule.yaml").write_text(json.dumps(schedule | {"bench": "bench.yaml"}))
    campaign = on_the_rig(tmp_path / "schedule.yaml", tmp_path / "campaign")
    assert {raw.outcome for raw in campaign.raw_runs()} == {"done"}
