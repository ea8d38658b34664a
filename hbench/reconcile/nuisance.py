"""Nuisance parameters: known parameters with uncertain values, refitted before the search.

Each is a factor on a value of the plant file, with a prior (standard deviation of its logarithm)
and bounds at three standard deviations, so that no nuisance can absorb an effect. Balances share
nuisances only within a group: a residual of friction cannot change the valve's gain.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.config.scaling import scaled, value_paths
from hbench.errors import ConfigError
from hbench.reconcile.measured.balances import FLOWS, PreparedRun, balance_model, residuals

_FRICTION = {
    "coulomb": 0.3,
    "stiction": 0.3,
    "stribeck_velocity": 0.2,
    "viscous": 0.3,
    "bristle_stiffness": 0.3,
    "stribeck_force": 0.3,
}
# Priors of the nuisances of each group of balances: assumed accuracy of a bench file's values.
GROUPS: Mapping[tuple[str, ...], Mapping[str, float]] = {
    FLOWS: {
        "valve.gain": 0.1,
        "valve.bandwidth": 0.04,
        "oil.bulk_modulus": 0.3,
        "test_cylinder.dead_volume_piston": 0.3,
        "test_cylinder.dead_volume_rod": 0.3,
        "load_cylinder.dead_volume_piston": 0.3,
        "load_cylinder.dead_volume_rod": 0.3,
    },
    **{
        (f"force_{side}",): {
            f"moving_mass.{side}": 0.2,
            **{f"friction.{side}.{name}": prior for name, prior in _FRICTION.items()},
        }
        for side in ("test", "load")
    },
}
BOUND = 3.0  # priors
_STEP = 1e-3  # of a logarithm, for its derivative


def nuisances(plant: Any) -> dict[str, float]:
    """Return the priors of the nuisances that a plant, or part of a plant, has, by dotted path.

    Left out are values of zero, sections that a part of a plant does not have, and parameters of
    other friction laws. Raises ``ConfigError`` for a path that no plant has.
    """
    return {
        path: prior
        for priors in GROUPS.values()
        for path, prior in priors.items()
        if nuisance_value(plant, path)
    }


def nuisance_value(plant: Any, path: str) -> float:
    """Return the value at a nuisance's path; 0 where this plant has none.

    Raises ``ConfigError`` for a path that no plant has.
    """
    if path not in value_paths(Plant):
        raise ConfigError(f"nuisance {path}: no plant file has this key", "Correct the path.")
    value: Any = plant
    for name in path.split("."):
        if not hasattr(value, name):
            return 0.0
        value = getattr(value, name)
    return value


def slopes(
    logs: Sequence[PreparedRun],
    bench: Bench,
    plant: Plant,
    factors: Mapping[str, float],
    names: tuple[str, ...],
) -> dict[str, list[np.ndarray]]:
    """Return each run's derivative (m, names) of the balances by the logarithm of each factor.

    ``factors`` are the current ones on ``plant``.
    """
    of_plant = nuisances(plant)
    derivatives = {}
    for balances, priors in GROUPS.items():
        model = balance_model(bench, scaled(plant, factors))
        before = [residuals(log, model, balances).values for log in logs]
        column = [balances.index(name) if name in balances else -1 for name in names]
        for path in priors:
            if path not in of_plant:
                continue
            log_factor = np.log(factors.get(path, 1.0))
            step = -_STEP if log_factor > 0 else _STEP  # towards a factor of 1
            stepped = {**factors, path: float(np.exp(log_factor + step))}
            model_after = balance_model(bench, scaled(plant, stepped))
            after = [residuals(log, model_after, balances).values for log in logs]
            derivatives[path] = [
                np.where(np.array(column) >= 0, ((b - a) / step)[:, column], 0.0)
                for a, b in zip(before, after, strict=True)
            ]
    return derivatives
