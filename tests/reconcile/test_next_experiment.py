"""Experiments that separate the effects of an ambiguous set, on the shipped bench."""

import re

import numpy as np
import pytest
import yaml

from hbench.config.schedule import parse_schedule
from hbench.experiment import closed_loop
from hbench.experiment.plan import plan_runs, run_seconds
from hbench.reconcile.hypothesis import typical_size
from hbench.reconcile.separation.next_experiment import (
    ExperimentLibrary,
    Undecided,
    detectable,
    joined,
    separation,
)
from hbench.reconcile.separation.planned_runs import linearised_runs, simulated_runs
from hbench.reconcile.separation.separability import Separation
from hbench.rig import virtual
from tests.support.reconcile.products import all_products
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
EFFECTS = ("added_mass", "friction_lag", "load_friction", "supply_droop", "direction_asymmetry")
CLEAR = (  # none of which is about detectable in these runs
    "friction_lag",
    "load_friction",
    "supply_droop",
    "direction_asymmetry",
    "end_cushion",
)
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
  - kind: triangle
    label: slow
    p_lr: 15 bar
    loads: [500 N]
    speed: 20 mm/s
    cycles: 2
    travel: {start: 190 mm, end: 210 mm}
    hold: 0.2 s
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
    """Steady runs that all start at one acceleration."""
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


def inertias(campaign):
    """Return a mass or a lag of friction, as either of these fits runs with the other."""
    return undecided(campaign, added_mass=("test", 3.0), friction_lag=("time", 1.5))


def library(bench, schedule=SCHEDULE):
    return ExperimentLibrary(bench, bench, bench.instruments, schedule)


def test_a_mass_and_a_lag_of_friction_are_separated_by_slow_reversals(bench, campaign):
    """Neither more of the same nor closed valves help: these have no acceleration."""
    rivals = inertias(campaign)
    assert not separation(rivals).distinguishable
    words, schedule, notes = library(bench).propose(rivals)
    assert not notes
    assert "triangle runs 'slow'" in words
    assert {"added_mass", "friction_lag"} <= set(words.split())
    assert "bench" not in schedule  # no such file lies beside it: --bench names one
    assert schedule["experiments"][0] == EXTENDING
    plans = plan_runs(parse_schedule(schedule, "next"), bench, "next").runs
    own = [plan for plan in plans if plan.label == "slow"]
    assert max(plan.trial for plan in own) == len(own) == 3


def test_effects_of_separate_balances_need_no_experiment(campaign):
    rivals = undecided(campaign, supply_droop=("slope", 2.0), load_friction=("test", 3.0))
    assert separation(rivals).distinguishable


def test_where_no_experiment_of_the_bench_helps_none_is_proposed(bench, campaign):
    """A bench that moves no faster than 10 mm/s has none of these runs."""
    limits = bench.limits.model_copy(update={"speed_max": 0.01})
    slow = bench.model_copy(update={"limits": limits})
    rivals = inertias(campaign)
    words, schedule, (note,) = library(slow).propose(rivals)
    assert words is None and schedule is None
    assert "hold runs" in note and "limits.speed_max" in note  # as they go to their start


def test_without_a_schedule_the_proposal_contains_the_experiment_alone(bench, campaign):
    rivals = inertias(campaign)
    words, schedule, _ = library(bench, {}).propose(rivals)
    assert [each["label"] for each in schedule["experiments"]] == ["slow"]
    assert "contains" in words


def test_joined_products_are_those_of_both_in_the_scatters_of_the_first(bench, campaign):
    """Runs joined to themselves double every sum, whatever the scatter they are given in."""
    model, _ = campaign
    data = joined(model, model)
    n = len(model.data.squares)
    for each in (all_products(data.columns), data.windows, data.noise):
        assert each[n:].sum(axis=0) == pytest.approx(each[:n].sum(axis=0))


def test_experiments_are_proposed_that_show_effects_which_the_runs_do_not(bench):
    """Runs that only extend do not show what differs between the directions; reversals do.

    No run reaches a cushion.
    """
    model = linearised_runs(
        bench, bench, simulated_runs(bench, bench, plans_of(bench, SCHEDULE)), CLEAR
    )
    compared = Separation(model, np.arange(len(model.gap_map.points)))
    hidden = set(CLEAR) - detectable(compared, CLEAR)
    words, schedule, _ = library(bench).reveal(compared, CLEAR)
    added = schedule["experiments"][1:]
    assert schedule["experiments"][0] == EXTENDING and added
    runs = simulated_runs(bench, bench, plans_of(bench, schedule))
    more = linearised_runs(bench, bench, runs, CLEAR)
    seen = detectable(Separation(more, np.arange(len(more.gap_map.points))), CLEAR)
    named, _, never = words.partition("No single experiment")
    assert {name for name in CLEAR if name in named} == {"direction_asymmetry"} <= seen & hidden
    assert {name for name in CLEAR if name in never} == {"end_cushion"} <= hidden
    assert "hbench run next.yaml --bench" in words
    seen = sorted(set(CLEAR) - hidden)
    assert library(bench).reveal(compared, seen) == (None, None, ())


class Counted(virtual.VirtualRig):
    """A rig that keeps the time of the bench at which each was closed."""

    ended_s: list[float] = []

    def close(self):
        self.ended_s.append(self.now())
        super().close()


def test_experiments_that_crawl_cost_a_bounded_time_and_are_reported(bench, campaign, monkeypatch):
    """A supply of 8 bar never brings the piston to the start of a run with p_lr at 15 bar."""
    monkeypatch.setattr(virtual, "VirtualRig", Counted)
    monkeypatch.setattr(Counted, "ended_s", [])
    monkeypatch.setattr(closed_loop, "LONGEST_S", 0.0)  # the board stops after 20 s in a return
    limits = bench.limits.model_copy(update={"speed_error": 1.0})
    patient = bench.model_copy(update={"limits": limits})
    supply = bench.supply.model_copy(update={"pressure": 8e5})
    weak = bench.model_copy(update={"supply": supply})
    given = ExperimentLibrary(patient, weak, bench.instruments, SCHEDULE)
    expected_s = [
        sum(run_seconds(plans_of(bench, {"name": "one", "experiments": [each]}), bench).values())
        for each in yaml.safe_load(SHORT)["experiments"]
    ]
    both = given.propose(inertias(campaign)), given.reveal(Separation(*campaign), EFFECTS)
    for proposal in both:
        assert [re.match("Not compared .*: (.*) runs '", note)[1] for note in proposal.notes] == [
            "steady",
            "triangle",
        ]
        assert all("the simulation was ended after" in note for note in proposal.notes)
    # They are simulated side by side, so the shorter one ends first.
    for took_s, most_s in zip(sorted(Counted.ended_s), sorted(2 * expected_s), strict=True):
        assert took_s < closed_loop.LONGEST * most_s + 0.5


def test_a_model_that_can_not_rest_is_reported_as_a_simulation_that_ended_early(bench, campaign):
    supply = bench.supply.model_copy(update={"pressure": 5e5})
    weak = bench.model_copy(update={"supply": supply})
    given = ExperimentLibrary(bench, weak, bench.instruments, SCHEDULE)
    words, _, notes = given.propose(inertias(campaign))
    assert words is None and len(notes) == 3
    assert all("it has 2 to 5 bar" in note for note in notes)
