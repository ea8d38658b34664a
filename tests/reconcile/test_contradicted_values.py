"""A bulk modulus or valve gain that no refit reaches: the measured flows show the true one."""

import json
from dataclasses import replace

import numpy as np
import pytest

from hbench.config.scaling import scaled
from hbench.errors import DataError
from hbench.reconcile.contradicted_values import (
    GAIN,
    MODULUS,
    contradicted_values,
    given_value,
)
from hbench.reconcile.measured.balances import CHAMBERS
from tests.support import ROOT
from tests.support.reconcile.blind import task_of

BLIND = ROOT / "data_samples" / "blind"
CAMPAIGNS = ("none-5", "internal_leakage-clear-1", "flow_force-clear-10")
TRUTH = json.loads((BLIND / "truth.json").read_text())


@pytest.mark.parametrize("factor", [0.05, 0.1, 3.0, 20.0, 100.0])
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_the_flows_show_the_modulus_whatever_the_model_file_states(name, factor):
    """Within 20 %, also where a leak or flow forces, which the model lacks, change the flows."""
    task = task_of(BLIND / name)
    true_pa = task.plant.oil.bulk_modulus * TRUTH[name]["truth"]["factors"][MODULUS]
    found = contradicted_values(task.bench, scaled(task.plant, {MODULUS: factor}), task.runs)
    assert found == {MODULUS: pytest.approx(true_pa, rel=0.2)}


@pytest.mark.parametrize("factor", [0.5, 2.0])
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_the_flows_show_the_gain_of_the_valves(name, factor):
    task = task_of(BLIND / name)
    wrong = scaled(task.plant, {GAIN: factor, MODULUS: 20.0})
    found = contradicted_values(task.bench, wrong, task.runs)
    true = task.plant.valve.gain * TRUTH[name]["truth"]["factors"][GAIN]
    assert found.keys() == {GAIN, MODULUS}
    assert found[GAIN] == pytest.approx(true, rel=0.05)


def with_trim(plant, **coefficients):
    return plant.model_copy(update={"effects": {"valve_trim": coefficients}})


@pytest.mark.parametrize("uneven", [-25, 20])
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_the_flows_show_that_the_edges_of_both_ports_have_one_size(name, uneven):
    """The model file has a spool for an asymmetric cylinder; a modulus would take its part."""
    task = task_of(BLIND / name)
    wrong = with_trim(task.plant, ports=f"{uneven} %")
    path = "effects.valve_trim.ports"
    assert given_value(wrong, path) == pytest.approx(uneven / 100)
    found = contradicted_values(task.bench, wrong, task.runs)
    assert found == {path: pytest.approx(0.0, abs=0.03)}


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_nulls_of_the_valves_contradict_nothing(name):
    """They would be taken for gains of the load valves that are twice as large."""
    task = task_of(BLIND / name)
    shifted = with_trim(task.plant, null_test="0.3 V", null_load_1="-0.3 V", null_load_2="0.3 V")
    assert contradicted_values(task.bench, shifted, task.runs) == {}


@pytest.mark.parametrize("asymmetry", ["0 %", "15 %", "-15 %"])
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_the_flows_show_the_sizes_of_the_load_valves(name, asymmetry):
    """Also beside valves that open further in one direction, which would take the gains' part."""
    task = task_of(BLIND / name)
    wrong = with_trim(task.plant, gain_load_1="50 %", gain_load_2="-40 %", gain_test="20 %")
    uneven = dict.fromkeys(("test", "load", "load_apart"), asymmetry)
    wrong = wrong.model_copy(update={"effects": {**wrong.effects, "valve_asymmetry": uneven}})
    found = contradicted_values(task.bench, wrong, task.runs)
    loads = [f"effects.valve_trim.gain_load_{i}" for i in (1, 2)]
    assert found.keys() == {GAIN, *loads}
    true = task.plant.valve.gain * TRUTH[name]["truth"]["factors"][GAIN]
    assert 1.2 * found[GAIN] == pytest.approx(true, rel=0.05)
    for path in loads:
        assert found[GAIN] * (1 + found[path]) == pytest.approx(true, rel=0.08)


def test_commands_of_another_scale_are_refused_and_no_gain():
    task = task_of(BLIND / "none-5")
    with pytest.raises(DataError, match="u_t_v"):
        contradicted_values(task.bench, scaled(task.plant, {GAIN: 10.0}), task.runs)


@pytest.mark.parametrize(
    "factors", [{}, {MODULUS: 0.5}, {MODULUS: 2.0}, {GAIN: 0.7}, {GAIN: 1.4}], ids=str
)
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_values_that_the_refit_reaches_are_kept(name, factors):
    task = task_of(BLIND / name)
    assert contradicted_values(task.bench, scaled(task.plant, factors), task.runs) == {}


def test_few_runs_contradict_nothing():
    task = task_of(BLIND / "none-5")
    wrong = scaled(task.plant, {MODULUS: 20.0})
    assert contradicted_values(task.bench, wrong, task.runs[:5]) == {}
    assert contradicted_values(None, wrong, task.runs)


def test_runs_without_transients_contradict_nothing():
    """Constant pressures compress nothing, so that they do not show how stiff the oil is."""
    task = task_of(BLIND / "none-5")
    steady = [
        replace(run, **{name: np.full_like(getattr(run, name), 50e5) for name in CHAMBERS})
        for run in task.runs
    ]
    wrong = scaled(task.plant, {MODULUS: 20.0})
    assert contradicted_values(task.bench, wrong, steady) == {}
