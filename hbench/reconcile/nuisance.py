"""Known parameters that may only be badly tuned, and are refitted before effects are sought.

Each is a factor on a value of the plant file, with a prior (standard deviation of its logarithm)
and bounds at three of them, so that none can swallow an effect. Balances share no nuisance but
within a group: what friction lacks can't bend the valve's gain.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from hbench.config.bench import Bench, Plant
from hbench.config.scaling import scaled
from hbench.reconcile.measured.balances import FLOWS, Prepared, model, residuals

_FRICTION = {
    "coulomb": 0.3,
    "stiction": 0.3,
    "stribeck_velocity": 0.2,
    "viscous": 0.3,
    "bristle_stiffness": 0.3,
    "stribeck_force": 0.3,
}
# Balances, and the priors of their nuisances. Judged: how well a bench file's values are known.
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
    """Return the priors of the nuisances that a plant has, by dotted path."""
    return {
        path: prior
        for priors in GROUPS.values()
        for path, prior in priors.items()
        if _value(plant, path)
    }


def slopes(
    logs: Sequence[Prepared],
    bench: Bench,
    plant: Plant,
    factors: Mapping[str, float],
    names: tuple[str, ...],
) -> dict[str, list[np.ndarray]]:
    """Return each run's change (m, names) of the balances in ``names`` with ln of each factor.

    ``factors`` are the ones on ``plant`` so far.
    """
    known = nuisances(plant)
    found = {}
    for balances, priors in GROUPS.items():
        here = model(bench, scaled(plant, factors))
        before = [residuals(log, here, balances).values for log in logs]
        own = [balances.index(name) if name in balances else -1 for name in names]
        for path in priors:
            if path not in known:
                continue
            log_factor = np.log(factors.get(path, 1.0))
            step = -_STEP if log_factor > 0 else _STEP  # inwards
            moved = {**factors, path: float(np.exp(log_factor + step))}
            there = model(bench, scaled(plant, moved))
            after = [residuals(log, there, balances).values for log in logs]
            found[path] = [
                np.where(np.array(own) >= 0, ((b - a) / step)[:, own], 0.0)
                for a, b in zip(before, after, strict=True)
            ]
    return found


def _value(plant: Plant, path: str) -> float:
    value: Any = plant
    for name in path.split("."):
        value = getattr(value, name, 0.0)
    return value
