"""Values that no bench has are reported; the way after the valves close is that of the plant."""

import copy
import re

import numpy as np
import pytest
import yaml

from hbench.cli.commands.init import _FILES
from hbench.config.bench import parse_bench, parse_plant
from hbench.config.files.examples import example_path
from hbench.config.files.sized_examples import BENCH_FILE, Size
from hbench.control.linearisation import steady_point
from hbench.control.plausibility import implausible
from hbench.control.stopping import stopping_time_s
from hbench.errors import ConfigError
from hbench.model.build import plant_parameters
from hbench.model.plant import P_LP, P_LR, P_TP, P_TR, V, X, initial_state
from hbench.model.simulation import simulate
from hbench.workflow.example_files import sized_files

EXAMPLES = {name: example_path(name).read_text() for name in _FILES}
DATA = yaml.safe_load(EXAMPLES["bench-aau.yaml"])


def changed(path, value):
    data = copy.deepcopy(DATA)
    *parents, key = path.split(".")
    section = data
    for name in parents:
        section = section[name]
    section[key] = value
    return data


def bench(path="name", value="a"):
    return parse_bench(changed(path, value), "bench.yaml")


def simulated_s(of, direction):
    """Way over speed after the valves close at half of the highest speed, as the plant has it."""
    par, limits = plant_parameters(of), of.limits
    x_m, v_m_s = 0.5 * (limits.travel_min + limits.travel_max), 0.5 * direction * limits.speed_max
    supply_pa = of.supply.pressure
    area = par.test.area_piston_m2 if direction > 0 else -par.test.area_rod_m2
    rod_pa = (0.1 if direction > 0 else 0.7) * supply_pa
    point = steady_point(par, x_m, v_m_s, 0.1 * supply_pa * area, rod_pa)
    state = initial_state(par, x_m, point.p_lr_pa, point.p_lp_pa)
    state[[V, P_TP, P_TR, P_LP, P_LR]] = [
        v_m_s,
        *(point.p_tp_pa, point.p_tr_pa, point.p_lp_pa, point.p_lr_pa),
    ]
    volts = np.zeros((4000, 3))
    volts[:1000] = point.u_t_v, point.u_l1_v, point.u_l2_v
    path = simulate(par, state, volts).state
    return float(np.max(direction * (path[999:, X] - path[999, X])) / abs(path[999, V]))


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("name", "as it is"),
        ("moving_mass.test", "500 kg"),
        ("valve.bandwidth", "30 Hz"),
        ("oil.bulk_modulus", "300 bar"),
    ],
)
def test_the_way_after_the_valves_close_is_that_of_the_simulated_plant(path, value, direction):
    of = bench(path, value)
    assert stopping_time_s(plant_parameters(of), of.limits) == pytest.approx(
        simulated_s(of, direction), rel=0.14
    )


@pytest.mark.parametrize("size", [Size(0.020, 0.014, 0.100, 40e5), Size(0.0203, 0.0089, 1.6, 88e5)])
def test_init_writes_a_stopping_time_that_bounds_the_way_of_a_small_cylinder(size, monkeypatch):
    monkeypatch.setattr("hbench.workflow.example_files.RATIOS", (1.7,))  # seconds each
    of = parse_bench(yaml.safe_load(sized_files(EXAMPLES, size).files[BENCH_FILE]), "bench.yaml")
    longest_s = max(simulated_s(of, direction) for direction in (1, -1))
    assert 15e-3 < longest_s < of.limits.stopping_time < 1.6 * longest_s
    assert implausible(of) == ()


def test_nothing_is_implausible_on_the_example():
    assert implausible(bench()) == ()


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        ("moving_mass.test", "5 g", "moving_mass.test = 0.005 kg; .* at least 0.15 kg"),
        ("moving_mass.load", "5 g", "moving_mass.load = 0.005 kg; .* load_cylinder"),
        ("moving_mass.test", "5000 kg", "limits.stopping_time = 15 ms; .* is 88.1 ms"),
        ("friction.load.stiction", "100 N", "friction.load.stiction = 100 N; .* 180 N"),
        ("oil.bulk_modulus", "140 bar", "oil.bulk_modulus = 140 bar; .* = 150 bar"),
        ("valve.gain", "7.43e-4 m^2/V", "valve.gain = 0.000743 m.2/V; .* at 776 m/s"),
        ("valve.bandwidth", "2 Hz", "limits.stopping_time = 15 ms; .* is 1.* ms"),
    ],
)
def test_a_value_that_no_bench_has_is_reported_with_its_limit(path, value, words):
    found = implausible(bench(path, value))
    assert any(re.search(words, each) for each in found), found


def test_a_plant_file_has_no_limits_of_the_board():
    assert implausible(parse_plant(DATA, {"moving_mass": {"test": "5000 kg"}}, "plant.yaml")) == ()


@pytest.mark.parametrize(
    ("path", "value", "limit"),
    [
        ("valve.bandwidth", "0.09 Hz", "at least 1 Hz"),
        ("valve.bandwidth", "90 kHz", "at most 3000 Hz"),
        ("oil.bulk_modulus", "70000 bar", "at most 50000 bar"),
    ],
)
def test_a_value_that_no_oil_or_valve_has_is_refused(path, value, limit):
    with pytest.raises(ConfigError, match=f"{path} = '{value}': must be {limit}"):
        bench(path, value)
