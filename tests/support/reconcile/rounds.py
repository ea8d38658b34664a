"""Rounds of refit and compare on the virtual rig, as a workflow would put them together."""

import numpy as np

from hbench.config.bench import Plant
from hbench.config.schedule import parse_schedule
from hbench.experiment.plan import plan_runs
from hbench.reconcile.estimates import fit_coefficients
from hbench.reconcile.gaps.gap_map import gaps, point_of
from hbench.reconcile.gaps.log_map import ranked_gaps
from hbench.reconcile.measured.balances import BALANCES, balance_model, residuals
from hbench.reconcile.measured.session import sessions
from hbench.reconcile.measured_campaign import MeasuredCampaign
from hbench.reconcile.search.campaign_search import CampaignSearch
from hbench.records.reconcile.diagnosis import MATERIAL


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
    sides = [[residuals(run, known) for run in runs] for runs in (measured, modelled)]
    ranked, found = gaps(*sides)
    return {one.name: one for one in ranked}, found


def plans_of(bench, plan):
    """Return the runs of a schedule."""
    return plan_runs(parse_schedule(dict(plan), "test"), bench, "test").runs


def campaign_of(runs, bench, plant=None):
    """Return runs as measurements of the search; the model is the bench's plant."""
    own = plant or plant_of(bench)
    return MeasuredCampaign(bench, own, bench.instruments, sessions(runs), MATERIAL)


def reconciled(measured, bench):
    """Return the refitted hypothesis, its factors, and the gaps before and after."""
    own = campaign_of(measured, bench)
    points = np.arange(len({point_of(run.plan) for run in measured}))
    result = CampaignSearch(own, points, ()).run()
    factors = fit_coefficients(own.plant, result.refitted, (), points).factors()
    allowed = np.zeros(len(BALANCES))
    given = result.given.gap_map.in_units_of(result.refitted.gap_map)
    before, after = (ranked_gaps(each, allowed) for each in (given, result.refitted.gap_map))
    ranked = ({one.name: one for one in each} for each in (before, after))
    return result.refitted.hypothesis, factors, *ranked


def table(title, ranked):
    """Print a ranked table; pytest -s shows it."""
    print(f"\n{title}\n{'balance':12} {'gap':>8} {'structured':>10} {'p':>6}")
    for one in ranked.values():
        print(f"{one.name:12} {one.gap:8.2f} {one.structured:10.2f} {one.p_value:6.3f}")
