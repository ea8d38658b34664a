"""Rounds of simulate, refit, compare on the virtual rig, as a workflow would put them together."""

import numpy as np

from hbench.config.bench import Plant
from hbench.config.schedule import parse_schedule
from hbench.experiment.closed_loop import record
from hbench.experiment.plan import plan_runs
from hbench.reconcile import simulated_runs
from hbench.reconcile.estimates import fit_coefficients
from hbench.reconcile.gaps.gap_map import gaps
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.linearised import linearise
from hbench.reconcile.measured.balances import balance_model, prepare, residuals
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.search import CampaignSearch


def schedule(trials=3, speeds=("20 mm/s", "60 mm/s", "150 mm/s")):
    """Steady speeds both ways under two loads each, and reversals under load."""
    common = {"trials": trials, "hold": "0.2 s"}
    steady = {
        "kind": "steady",
        "velocities": list(speeds),
        "travel": {"start": "60 mm", "end": "330 mm"},
        "acceleration": "1 m/s^2",
        "window": "1 s",
    }
    triangle = {
        "kind": "triangle",
        "p_lr": "15 bar",
        "loads": ["500 N", "5000 N"],
        "speed": "100 mm/s",
        "cycles": 1,
        "travel": {"start": "120 mm", "end": "280 mm"},
    }
    pushed = {"direction": "extend", "p_lr": "15 bar", "loads": ["500 N", "5000 N"]}
    pulled = {"direction": "retract", "p_lr": "110 bar", "loads": ["-500 N", "-5000 N"]}
    experiments = [steady | pushed, steady | pulled, triangle]
    return {"name": "balances", "experiments": [one | common for one in experiments]}


def plant_of(bench) -> Plant:
    """Return the physics of a bench file."""
    return Plant.model_construct(**{key: getattr(bench, key) for key in Plant.model_fields})


def compare(measured, modelled, bench, plant):
    """Return the ranked gaps by name, and the map."""
    known = balance_model(bench, plant)
    sides = [[residuals(prepare(run), known) for run in runs] for runs in (measured, modelled)]
    ranked, found = gaps(*sides)
    return {one.name: one for one in ranked}, found


def simulator(bench, plan):
    """Return what makes the runs of a schedule with hypotheses of the bench's plant."""
    plans = plan_runs(parse_schedule(dict(plan), "test"), bench, "test").runs
    return simulated_runs.simulator(bench, plant_of(bench), plans, spread=map)


def reconciled(measured, bench, plan, seed=100):
    """Return the refitted model, and the gaps before and after."""
    simulate, plant = simulator(bench, plan), plant_of(bench)
    before = compare(measured, record(bench, plan, plant, seed=seed).runs, bench, plant)[0]
    own = MeasuredCampaign(bench, plant, tuple(prepare(run) for run in measured))
    (runs,) = simulate([Hypothesis()], 3)
    given = linearise(own, Hypothesis(), runs, {})
    train = np.arange(len(given.gap_map.points))
    here = CampaignSearch(own, simulate, 3, {}, train, ()).refit(given, ())
    refitted = here.hypothesis.plant(plant)
    after = compare(measured, record(bench, plan, refitted, seed=seed + 1).runs, bench, refitted)[0]
    return fit_coefficients(plant, here, (), train).factors(), before, after


def table(title, ranked):
    """Print a ranked table; pytest -s shows it."""
    print(f"\n{title}\n{'balance':12} {'gap':>8} {'structured':>10} {'p':>6}")
    for one in ranked.values():
        print(f"{one.name:12} {one.gap:8.2f} {one.structured:10.2f} {one.p_value:6.3f}")
