from pathlib import Path

import numpy as np
import pytest

from hbench.config.bench import Bench, parse_bench
from hbench.config.files.loading import read_yaml
from hbench.model.build import plant_parameters
from hbench.model.friction.laws import LAWS
from hbench.model.parameters import PlantParameters


@pytest.fixture(scope="session")
def bench_file() -> Path:
    return Path(__file__).parents[2] / "configs" / "bench-aau.yaml"


@pytest.fixture(scope="session")
def bench(bench_file) -> Bench:
    return parse_bench(read_yaml(bench_file), str(bench_file))


@pytest.fixture(scope="session")
def par(bench) -> PlantParameters:
    return plant_parameters(bench)


@pytest.fixture(scope="session")
def with_law(par):
    """Return the parameters with another friction law in both cylinders."""

    def replace(name: str) -> PlantParameters:
        law = LAWS[name]
        test = par.test._replace(friction=par.test.friction._replace(law=law.code))
        load = par.load._replace(friction=par.load.friction._replace(law=law.code))
        return par._replace(test=test, load=load, substeps=law.substeps)

    return replace


@pytest.fixture(scope="session")
def there_and_back() -> np.ndarray:
    """Commands of a start, a reversal and a stop: 0.4 s, 0.5 s and 0.4 s at about 50 mm/s."""
    commands = ([0.7, 0.3, -1.4], [-0.8, -1.0, 0.5], [0.0, 0.0, 0.0])
    return np.repeat(commands, (4000, 5000, 4000), axis=0)
