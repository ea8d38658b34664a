"""Rounds of simulate, refit, compare on the virtual rig, as a workflow would put them together."""

from hbench.config.bench import Plant
from hbench.config.scaling import scaled
from hbench.experiment.closed_loop import record
from hbench.reconcile.balances import model, prepared, residuals
from hbench.reconcile.gap import gaps
from hbench.reconcile.nuisance import refit


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
    known = model(bench, plant)
    sides = [[residuals(prepared(run), known) for run in runs] for runs in (measured, modelled)]
    ranked, found = gaps(*sides)
    return {one.name: one for one in ranked}, found


def without_scatter(plant) -> Plant:
    """Return the plant with the same friction at each stroke, which only a mean has to match."""
    return scaled(plant, {f"friction.{side}.scatter": 0.0 for side in ("test", "load")})


def reconciled(measured, bench, plan, rounds, seed=100):
    """Return the last refit, and the gaps before the first and after each round."""
    plant, factors, history, fit = plant_of(bench), {}, [], None
    for number in range(rounds + 1):
        modelled = record(bench, plan, plant, seed=seed + number).runs
        history.append(compare(measured, modelled, bench, plant)[0])
        if number < rounds:
            expected = record(bench, plan, without_scatter(plant), seed=seed + 1000 + number).runs
            fit = refit(measured, expected, bench, plant_of(bench), factors)
            factors = {path: one.value for path, one in fit.factors.items()}
            plant = fit.plant
    return fit, history


def table(title, ranked):
    """Print a ranked table; pytest -s shows it."""
    print(f"\n{title}\n{'balance':12} {'gap':>8} {'structured':>10} {'p':>6}")
    for one in ranked.values():
        print(f"{one.name:12} {one.gap:8.2f} {one.structured:10.2f} {one.p_value:6.3f}")
