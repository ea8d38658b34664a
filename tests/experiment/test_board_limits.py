"""What the board or a file can't hold is refused when the schedule is read."""

import pytest
import yaml

from hbench import workflow
from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.errors import ConfigError
from hbench.protocol.dictionary import SETTING_RANGES
from hbench.rig.board_settings import board_settings
from hbench.store.files.bounded_read import LARGEST_LOG
from tests.support import ROOT

BENCH = read_yaml(ROOT / "configs" / "bench-aau.yaml")


def test_the_shipped_bench_is_a_factor_of_four_within_the_boards_ranges():
    """Except where the range's end is exact, such as 0 of a time constant or of the feedforward."""
    settings = board_settings(parse_bench(BENCH, "bench-aau.yaml"))
    for name, (low, high) in SETTING_RANGES.items():
        value = settings[name]
        assert value <= high / 4 or name == "feedforward_on", name
        assert low <= 0 or value >= 4 * low, name


def test_a_setting_that_the_board_refuses_is_named_when_the_schedule_is_read(short_schedule):
    """An amplifier of 1e-6 makes each count 10 MPa."""
    wrong = BENCH["sensors"]["pressure"] | {"amplifier": 1e-6}
    path = short_schedule({"sensors": {"pressure": wrong}})
    with pytest.raises(ConfigError, match=r"gain_p_tp = .*; limits 0\.001 to 100000"):
        workflow.load_experiment(path, None)


@pytest.mark.parametrize(("duration", "fits"), [("2490 s", True), ("2510 s", False)])
def test_a_log_that_could_not_be_read_again_is_refused(tmp_path, duration, fits):
    """200 records/s of 80 bytes: 40 MB after 2500 s."""
    assert LARGEST_LOG / (200 * 80) == 2500
    rates = {"log_rate": "200 Hz"}
    data = {**BENCH, "controllers": BENCH["controllers"] | rates}
    schedule = {
        "name": "long",
        "bench": "bench.yaml",
        "experiments": [
            {"kind": "hold", "positions": ["200 mm"], "duration": duration}
            | {"p_lr": "15 bar", "loads": ["2000 N"], "hold": "1 s"}
        ],
    }
    (tmp_path / "bench.yaml").write_text(yaml.safe_dump(data))
    (tmp_path / "long.yaml").write_text(yaml.safe_dump(schedule))
    if fits:
        assert workflow.load_experiment(tmp_path / "long.yaml", None).plans
        return
    with pytest.raises(ConfigError, match=r"run 0001 \(hold\) may last 25\d\d s.*limit 40 MB"):
        workflow.load_experiment(tmp_path / "long.yaml", None)
