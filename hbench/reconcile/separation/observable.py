"""Effects that a search in some runs can name, and the operating points that it uses."""

from collections.abc import Sequence

import numpy as np

from hbench.config.bench import Plant
from hbench.model.effects.catalogue import EFFECTS
from hbench.reconcile.measured.balances import channels_missing
from hbench.reconcile.nuisance import BACKGROUND
from hbench.records import Run
from hbench.records.reconcile.diagnosis import FITTED

_HELD_OUT = 5  # every fifth operating point is held out: no value is fitted to it
_FIRST_HELD_OUT = 2


def divided_points(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of the operating points of the fits, and of those held out."""
    points = np.arange(count)
    held_out = points % _HELD_OUT == _FIRST_HELD_OUT
    return points[~held_out], points[held_out]


def observable_effects(runs: Sequence[Run], plant: Plant) -> tuple[tuple[str, ...], dict[str, str]]:
    """Return the effects that these channels can show, and why the others are not tried."""
    observable, not_tried = [], {}
    for name, row in EFFECTS.items():
        without = [
            balance
            for balance in row.balances
            if all(channels_missing(run, balance) for run in runs)
        ]
        if name in BACKGROUND:
            not_tried[name] = FITTED
        elif name in plant.effects:
            not_tried[name] = "the model already contains it; its coefficients are not changed"
        elif not row.balances:
            not_tried[name] = "runs of the kind breakaway measure it"
        elif len(without) == len(row.balances):
            not_tried[name] = f"no run has the channels of {', '.join(without)}"
        else:
            observable.append(name)
    return tuple(observable), not_tried
