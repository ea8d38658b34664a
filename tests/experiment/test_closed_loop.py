"""Simulations of campaigns have a bound on time."""

import pytest

from hbench import workflow
from hbench.experiment import closed_loop
from hbench.experiment.plan import run_seconds
from hbench.reconcile.gaps.simulated_runs import simulator
from hbench.reconcile.hypothesis import Hypothesis
from hbench.rig import virtual


class Counted(virtual.VirtualRig):
    """A rig that keeps the time at which it is closed."""

    ended_s = 0.0

    def close(self):
        type(self).ended_s = self.now()
        super().close()


@pytest.fixture
def ended(monkeypatch):
    monkeypatch.setattr(virtual, "VirtualRig", Counted)
    return lambda: Counted.ended_s


@pytest.fixture
def crawling(quick_schedule):
    """An experiment whose board allows any speed error, and a plant whose valves hardly open."""
    experiment = workflow.load_experiment(
        quick_schedule({"limits": {"speed_error": "1 m/s"}}, trials=1), None
    )
    bench = experiment.bench
    valve = bench.valve.model_copy(update={"gain": bench.valve.gain / 300})
    return experiment, bench.model_copy(update={"valve": valve})


def test_a_sound_plant_needs_less_than_the_estimated_time(quick_experiment, ended):
    plans = quick_experiment.plans
    expected_s = sum(run_seconds(plans, quick_experiment.bench).values())
    assert not closed_loop.record_plans(quick_experiment.bench, plans).stopped
    assert 0.5 * expected_s < ended() < 1.1 * expected_s


def test_a_plant_that_crawls_costs_a_bounded_time_and_is_reported(crawling, ended, monkeypatch):
    experiment, plant = crawling
    plans, bench = experiment.plans, experiment.bench
    expected_s = sum(run_seconds(plans, bench).values())
    monkeypatch.setattr(closed_loop, "LONGEST_S", 0.0)  # the board stops after 20 s in a return
    recorded = closed_loop.record_plans(bench, plans, plant)
    assert "simulation was ended after" in recorded.stopped
    assert ended() < closed_loop.LONGEST * expected_s + 0.5
    (reason,) = simulator(bench, plant)((Hypothesis(),), plans)
    assert "expected for 2 runs" in reason
