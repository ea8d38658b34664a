"""What several test rooms share: the shipped bench and a short schedule."""

import copy
import os
import shutil
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[1]

SHORT = {
    "name": "short",
    "bench": "bench.yaml",
    "experiments": [
        {
            "kind": "steady",
            "direction": "extend",
            "p_lr": "15 bar",
            "loads": ["2000 N"],
            "velocities": ["60 mm/s", "120 mm/s"],
            "trials": 2,
            "travel": {"start": "100 mm", "end": "300 mm"},
            "acceleration": "1 m/s^2",
            "hold": "0.2 s",
            "window": "0.6 s",
        }
    ],
}


@pytest.fixture(scope="session")
def require_tool():
    """Return a function that gives a program's path; one that is missing skips the test.

    Not in CI, which sets HBENCH_CI and installs them all: there it fails the test.
    """

    def find(name: str) -> str:
        path = shutil.which(name)
        if path is None:
            (pytest.fail if os.environ.get("HBENCH_CI") else pytest.skip)(f"no {name}")
        return path

    return find


@pytest.fixture
def short_schedule(tmp_path):
    """Return a function that writes the short schedule (two speeds, two trials) and its bench.

    Keyword arguments replace keys of its only experiment; ``bench`` replaces keys of the bench.
    """

    def write(bench: dict | None = None, **changes) -> Path:
        data = copy.deepcopy(SHORT)
        data["experiments"][0] |= changes
        bench_data = yaml.safe_load((ROOT / "configs" / "bench-aau.yaml").read_text())
        for section, values in (bench or {}).items():
            bench_data[section] |= values
        (tmp_path / "bench.yaml").write_text(yaml.safe_dump(bench_data))
        path = tmp_path / "short.yaml"
        path.write_text(yaml.safe_dump(data))
        return path

    return write


@pytest.fixture
def clock():
    """Return a clock that goes on by a second each time it is read."""
    ticks = iter(range(10**6))
    start = datetime(2026, 1, 1, tzinfo=UTC)
    return lambda: start + timedelta(seconds=next(ticks))
