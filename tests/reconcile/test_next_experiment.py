"""Experiments that tell two hypotheses apart, found by simulating them on the shipped bench."""

import pytest

from hbench.config.schedule import parse_schedule
from hbench.experiment.plan import plan_runs
from hbench.reconcile.hypothesis import Hypothesis, typical_size
from hbench.reconcile.measured.balances import FLOWS
from hbench.reconcile.next_experiment import next_experiment
from tests.support.reconcile.rounds import plant_of

SHORT = """
experiments:
  - kind: steady
    direction: extend
    p_lr: 15 bar
    loads: [500 N]
    velocities: [150 mm/s]
    trials: 3
    travel: {start: 60 mm, end: 330 mm}
    acceleration: 1 m/s^2
    hold: 0.2 s
    window: 1 s
  - kind: steps
    label: up and down
    p_lr: 15 bar
    loads: [500 N]
    levels: [50 mm/s, 100 mm/s, -50 mm/s, -100 mm/s]
    dwell: 0.5 s
    trials: 3
    travel: {start: 60 mm, end: 330 mm}
    hold: 0.2 s
  - kind: hold
    p_lr: 15 bar
    loads: [5000 N]
    positions: [200 mm]
    duration: 2 s
    trials: 3
    hold: 0.2 s
"""
# Of the trials, by balance: what the shipped bench has.
SCATTER = {**dict.fromkeys(FLOWS, 2e-7), "force_test": 5.0, "force_load": 5.0,
           "kinematics": 1e-3, "supply": 1e4}  # fmt: skip


@pytest.fixture(autouse=True)
def short_library(monkeypatch):
    """Three experiments stand in for those of discriminate.yaml."""
    monkeypatch.setattr("hbench.reconcile.next_experiment.example", lambda name: SHORT.encode())


def with_effect(name, key, size=1.0):
    return Hypothesis().with_coefficients({(name, key): size * typical_size((name, key))})


def proposed(bench, one, other):
    rivals = {"one": one, "other": other}
    found = next_experiment(bench, plant_of(bench), rivals, SCATTER)
    if found is None:
        return None
    words, schedule = found
    plans = plan_runs(parse_schedule(schedule, "next"), bench, "next").runs
    assert "bench" not in schedule  # no such file lies beside it: --bench names one
    assert {plan.kind for plan in plans} == {schedule["experiments"][0]["kind"]}
    assert max(plan.trial for plan in plans) == 3
    assert {"one", "other"} <= set(words.split())
    return words, plans


def test_masses_are_distinguished_by_steps(bench):
    """Steady runs and closed valves have no acceleration."""
    words, plans = proposed(
        bench, with_effect("added_mass", "test", 3), with_effect("added_mass", "load", 3)
    )
    assert plans[0].kind == "steps" and f"'{plans[0].label}'" in words


def test_leaks_are_distinguished_by_closed_valves_under_load(bench):
    """There the pressure drop across the load piston is largest: the load's over its piston area.

    At 5 kN some 34 bar; without a load it hardly leaks either way.
    """
    words, plans = proposed(
        bench, with_effect("internal_leakage", "load"), with_effect("internal_leakage", "load", 2)
    )
    assert plans[0].kind == "hold" and "'" not in words


def test_equal_hypotheses_are_distinguished_by_nothing(bench):
    one = with_effect("added_mass", "test")
    assert proposed(bench, one, one) is None


def test_what_the_bench_cannot_make_is_not_proposed(bench):
    slow = bench.model_copy(update={"limits": bench.limits.model_copy(update={"speed_max": 0.04})})
    one, other = with_effect("added_mass", "test", 3), with_effect("added_mass", "load", 3)
    found = next_experiment(slow, plant_of(bench), {"one": one, "other": other}, SCATTER)
    assert found is None or found[1]["experiments"][0]["kind"] == "hold"
