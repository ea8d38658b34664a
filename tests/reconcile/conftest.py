"""The shipped bench, for what is compared with models of it."""

from pathlib import Path

import pytest

from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml

BENCH = Path(__file__).parents[2] / "configs" / "bench-aau.yaml"


@pytest.fixture(scope="session")
def bench_data():
    return read_yaml(BENCH)


@pytest.fixture(scope="session")
def bench(bench_data):
    return parse_bench(bench_data, "bench")
