"""The shipped bench, its parameters, and the source's linear design."""

from pathlib import Path

import pytest

from hbench.config.bench import merge, parse_bench
from hbench.config.files.loading import read_yaml
from hbench.control.linearisation import linear_coefficients
from hbench.model.build import plant_parameters
from hbench.studies.source_design import OPERATING_POINT

_FILE = Path(__file__).parents[2] / "configs" / "bench-aau.yaml"


@pytest.fixture(scope="session")
def make_bench():
    """Return the shipped bench with some keys of its file replaced."""
    data = read_yaml(_FILE)
    return lambda **changes: parse_bench(merge(data, changes), "changed")


@pytest.fixture(scope="session")
def bench(make_bench):
    return make_bench()


@pytest.fixture(scope="session")
def par(bench):
    return plant_parameters(bench)


@pytest.fixture(scope="session")
def source(par):
    """The coefficients at the source's own operating points."""
    return linear_coefficients(par, OPERATING_POINT)
