"""Benchmarks compare times, so they run alone: xdist's workers (``pytest -n``) leave them out."""

import ctypes
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from hbench.config.bench import parse_bench
from hbench.config.files.loading import read_yaml
from hbench.model.build import plant_parameters
from hbench.model.plant import initial_state
from tests.support.benchmarks import BENCH

collect_ignore_glob = ["test_*.py"] if "PYTEST_XDIST_WORKER" in os.environ else []


@pytest.fixture(scope="module")
def par():
    return plant_parameters(parse_bench(read_yaml(BENCH), str(BENCH)))


@pytest.fixture(scope="module")
def start(par):
    return initial_state(par, 0.1, 15e5, 20e5)


@pytest.fixture
def plant_in_c(require_tool, par, tmp_path):
    """Return ``run(state, commands)`` of plant.c, which advances the state."""
    source, library = Path(__file__).with_name("plant.c"), tmp_path / "plant.so"
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(
        [require_tool("cc"), *flags, "-shared", "-fPIC", source, "-o", library, "-lm"], check=True
    )

    def cylinder(c):
        f = c.friction
        return (
            *c[: c._fields.index("friction")],
            *(f.coulomb, f.stiction, f.stribeck_velocity, f.stribeck_exponent),
            *(f.viscous, f.bristle_stiffness, f.bristle_damping, f.piston_seal, f.rod_seal),
        )

    numbers = np.array(
        [
            *cylinder(par.test),
            *cylinder(par.load),
            *(par.mass_test_kg, par.mass_load_kg, par.bulk_modulus_pa),
            *(par.supply.pressure_pa, par.supply.tank_pa, *par.valve, *par.end_stop),
        ]
    )
    run = ctypes.CDLL(str(library)).run
    array = np.ctypeslib.ndpointer(np.float64, flags="C")
    run.restype, run.argtypes = None, (array, array, array, ctypes.c_size_t)
    return lambda state, u: run(numbers, state, u, len(u))
