"""Experiments that separate the effects of an ambiguous set, on the shipped bench."""

import numpy as np
import pytest

from hbench.config.schedule import parse_schedule
from hbench.experiment.plan import plan_runs
from hbench.reconcile.hypothesis import typical_size
from hbench.reconcile.separation.next_experiment import (
    ExperimentLibrary,
    Undecided,
    joined,
    separation,
)
from hbench.reconcile.separation.planned_runs import linearised_runs, simulated_runs
from tests.support.reconcile.rounds import plans_of

STEADY = {
    "kind": "steady",
    "trials": 1,
    "travel": {"start": "60 mm", "end": "330 mm"},
    "acceleration": "1 m/s^2",
    "hold": "0.2 s",
    "window": "0.5 s",
}
EXTENDING = STEADY | {
    "direction": "extend",
    "p_lr": "15 bar",
    "loads": ["500 N", "2500 N", "5000 N"],
    "velocities": ["30 mm/s", "80 mm/s", "150 mm/s"],
}
SCHEDULE = {
    "name": "Extending only",
    "bench": "bench-aau.yaml",
    "order": "passes",
    "experiments": [EXTENDING],
}
EFFECTS = ("seal_pressure_friction", "load_friction", "supply_droop")
SHORT = """
experiments:
  - kind: steady
    label: the same
    direction: extend
    p_lr: 15 bar
    loads: [2500 N]
    velocities: [80 mm/s]
    travel: {start: 60 mm, end: 330 mm}
    acceleration: 1 m/s^2
    hold: 0.2 s
    window: 0.5 s
  - kind: steady
    label: other pressures
    direction: extend
    p_lr: 60 bar
    loads: [500 N, 2500 N]
    velocities: [80 mm/s, 150 mm/s]
    order: passes
    travel: {start: 60 mm, end: 330 mm}
    acceleration: 1 m/s^2
    hold: 0.2 s
    window: 0.5 s
  - kind: hold
    p_lr: 15 bar
    loads: [5000 N]
    positions: [200 mm]
    duration: 1 s
    hold: 0.2 s
"""


@pytest.fixture(autouse=True)
def short_library(monkeypatch):
    """Three experiments stand in for those of discriminate.yaml."""
    place = "hbench.reconcile.separation.next_experiment.example"
    monkeypatch.setattr(place, lambda name: SHORT.encode())


@pytest.fixture(scope="module")
def campaign(bench):
    """Runs with one rod-side pressure: the pressures follow the load."""
    runs = simulated_runs(bench, bench, plans_of(bench, SCHEDULE))
    model = linearised_runs(bench, bench, runs, EFFECTS)
    return model, np.arange(len(model.gap_map.points))


def undecided(campaign, **rivals):
    """Return a set of effects, each with one coefficient [typical sizes]."""
    hypotheses = {}
    for name, (key, size) in rivals.items():
        value = size * typical_size((name, key))
        hypotheses[name] = campaign[0].hypothesis.with_coefficients({(name, key): value})
    return Undecided(*campaign, (), hypotheses)


def frictions(campaign):
    """Return friction of load or of pressure, as either of these fits runs with the other."""
    return undecided(
        campaign, seal_pressure_friction=("load_piston", 6.0), load_friction=("load", 4.0)
    )


def library(bench, schedule=SCHEDULE):
    return ExperimentLibrary(bench, bench, bench.instruments, schedule)


def test_friction_of_load_and_of_pressure_is_separated_by_other_pressures_at_the_same_load(
    bench, campaign
):
    """Neither more of the same nor closed valves help: these have no friction."""
    rivals = frictions(campaign)
    assert not separation(rivals).distinguishable
    words, schedule = library(bench).propose(rivals)
    assert "steady runs 'other pressures'" in words
    assert {"seal_pressure_friction", "load_friction"} <= set(words.split())
    assert "bench" not in schedule  # no such file lies beside it: --bench names one
    assert schedule["experiments"][0] == EXTENDING
    plans = plan_runs(parse_schedule(schedule, "next"), bench, "next").runs
    own = [plan for plan in plans if plan.label == "other pressures"]
    assert max(plan.trial for plan in own) == 3 and len(own) == 3 * 4


def test_effects_of_separate_balances_need_no_experiment(campaign):
    rivals = undecided(campaign, supply_droop=("slope", 2.0), load_friction=("test", 3.0))
    assert separation(rivals).distinguishable


def test_where_no_experiment_of_the_bench_helps_none_is_proposed(bench, campaign):
    """A bench that holds its load but moves no faster than 10 mm/s has no such steady runs."""
    limits = bench.limits.model_copy(update={"speed_max": 0.01})
    slow = bench.model_copy(update={"limits": limits})
    rivals = frictions(campaign)
    assert library(slow).propose(rivals) is None


def test_without_a_schedule_the_proposal_contains_the_experiment_alone(bench, campaign):
    rivals = frictions(campaign)
    words, schedule = library(bench, {}).propose(rivals)
    assert [each["label"] for each in schedule["experiments"]] == ["other pressures"]
    assert "contains" in words


def test_joined_products_are_those_of_both_in_the_scatters_of_the_first(bench, campaign):
    """Runs joined to themselves double every sum, whatever the scatter they are given in."""
    model, _ = campaign
    data = joined(model, model)
    n = len(model.data.squares)
    for name in ("columns", "windows", "noise"):
        each = getattr(data, name)
        assert each[n:].sum(axis=0) == pytest.approx(each[:n].sum(axis=0)), name
