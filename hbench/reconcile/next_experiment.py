"""Next experiment: the one in which the effects of an ambiguous set differ most."""

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
from hbench.reconcile.gaps.gap_map import column_means
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.measured.balances import BALANCES, balance_model, residuals
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
    """Return the experiment that distinguishes ``rivals`` best, in words and as a schedule.

    The experiments of ``discriminate.yaml`` that the bench can run are simulated. ``scatter`` is
    that of the trials by balance. None where the rivals are not distinguishable in any of them.
    """
    best, chosen = 1.0, None  # a scatter
    for experiment in parse_yaml(example(_LIBRARY).decode())["experiments"]:
        separation = _separation(bench, plant, {**experiment, "trials": 1}, rivals, scatter)
        if separation > best:
            best, chosen = separation, experiment
    if chosen is None:
        return None
    names = " and ".join(rivals)
    label = f" {chosen['label']!r}" if "label" in chosen else ""
    words = (
        f"Measure the {chosen['kind']} runs{label} of next.yaml. In these runs {names} differ by "
        f"{best:.1f} trial scatters."
    )
    schedule = {
        "name": f"Distinguish {names}",
        "order": "passes",
        "experiments": [{**chosen, "trials": _TRIALS}],
    }
    return words, schedule


def _separation(
    bench: Bench,
    plant: Plant,
    experiment: dict[str, Any],
    rivals: Mapping[str, Hypothesis],
    scatter: Mapping[str, float],
) -> float:
    """Return the difference of the two closest rivals, in scatters; 0 if the bench can't run it."""
    try:
        schedule = parse_schedule({"name": "next", "experiments": [experiment]}, "next")
        plans = plan_runs(schedule, bench, "next").runs
    except ConfigError:
        return 0.0
    simulated = simulator(bench, plant, spread=map)(tuple(rivals.values()), plans)
    model = balance_model(bench, plant)
    logs = [
        [residuals(run, model).values for run in runs] for runs in simulated if runs is not None
    ]
    if len(logs) < len(rivals):
        return 0.0
    unit = np.array([scatter.get(name, np.inf) for name in BALANCES])
    return min(_distance(one, other, unit) for one, other in combinations(logs, 2))


def _distance(one: list[np.ndarray], other: list[np.ndarray], unit: np.ndarray) -> float:
    """Return the largest difference of two sets of runs over the balances, in scatters."""
    lengths = [min(len(a), len(b)) for a, b in zip(one, other, strict=True)]
    difference = np.concatenate(
        [a[:m] - b[:m] for a, b, m in zip(one, other, lengths, strict=True)]
    )
    square = column_means((difference / unit) ** 2)
    return float(np.sqrt(max(np.nanmax(square) - _NOISE, 0.0)))
