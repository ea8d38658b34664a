"""The experiment that would tell an ambiguous set of effects apart, found by simulating each."""

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.config.files.examples import example
from hbench.config.files.loading import parse_yaml
from hbench.config.schedule import parse_schedule
from hbench.errors import ConfigError
from hbench.experiment.plan import plan_runs
from hbench.reconcile.gap import column_means
from hbench.reconcile.linearised import Hypothesis, less, mean_column, windows_of
from hbench.reconcile.measured.balances import BALANCES, model
from hbench.reconcile.simulated_runs import simulator

_LIBRARY = "discriminate.yaml"
_TRIALS = 3
_NOISE = 2.0  # variance of a difference of two simulated runs, in squares of the scatter


def next_experiment(
    bench: Bench,
    plant: Plant,
    rivals: Mapping[str, Hypothesis],
    scatter: Mapping[str, float],
) -> tuple[str, dict[str, Any]] | None:
    """Return in words, and as a schedule, which experiment tells ``rivals`` apart best.

    The experiments of ``discriminate.yaml`` are tried, as far as the bench can make them.
    ``scatter`` is the trials' by balance. None where no experiment tells them apart.
    """
    best, chosen = 1.0, None  # a scatter
    for experiment in parse_yaml(example(_LIBRARY).decode())["experiments"]:
        apart = _apart(bench, plant, {**experiment, "trials": 1}, rivals, scatter)
        if apart > best:
            best, chosen = apart, experiment
    if chosen is None:
        return None
    names = " and ".join(rivals)
    label = f" {chosen['label']!r}" if "label" in chosen else ""
    words = (
        f"Measure the {chosen['kind']} runs{label} of next.yaml: there {names} "
        f"differ by {best:.1f} trial scatters."
    )
    schedule = {
        "name": f"Telling {names} apart",
        "order": "passes",
        "experiments": [{**chosen, "trials": _TRIALS}],
    }
    return words, schedule


def _apart(
    bench: Bench,
    plant: Plant,
    experiment: dict[str, Any],
    rivals: Mapping[str, Hypothesis],
    scatter: Mapping[str, float],
) -> float:
    """Return by how many scatters the two closest of the rivals differ; 0 if it can't be made."""
    try:
        schedule = parse_schedule({"name": "next", "experiments": [experiment]}, "next")
        plans = plan_runs(schedule, bench, "next").runs
    except ConfigError:
        return 0.0
    made = simulator(bench, plant, plans, spread=map)(tuple(rivals.values()), 1)
    known = model(bench, plant)
    columns = [mean_column(windows_of(runs, known)) for runs in made if runs is not None]
    if len(columns) < len(rivals):
        return 0.0
    unit = np.array([scatter.get(name, np.inf) for name in BALANCES])
    return min(_distance(less(a, b), unit) for a, b in combinations(columns, 2))


def _distance(apart: Mapping[Any, np.ndarray], unit: np.ndarray) -> float:
    square = column_means((np.concatenate(list(apart.values())) / unit) ** 2)
    return float(np.sqrt(max(np.nanmax(square) - _NOISE, 0.0)))
