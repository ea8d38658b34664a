"""Disturbances: what every measurement has and no model file describes, fitted as nuisances.

A drift is the change of a sensor's reading from the middle of the campaign to its last run, linear
from run to run. A ripple is a share of a cylinder's dry friction that depends on the position: no
bore is the same along the whole stroke. It consists of modes (see ``learned/table.py``). A delay is
the time by which the readings of a sensor, or the commands, are late against the position:
amplifiers filter, and a logger may read one channel after another. Where all sensors are early, the
position is late. Values are in standard deviations of their priors.
"""

from typing import NamedTuple

import numpy as np

from hbench.reconcile.column_names import delayed_channel

CYLINDERS = "test", "load"
ALL_COMMANDS, POSITION = "commands", "x"  # channels; that of the commands is of all valves
_LARGEST = 3**0.5  # equally likely within a limit
DELAY_S = 30e-3 / _LARGEST  # assumed; a filter of 10 Hz takes 23 ms


class Ripples(NamedTuple):
    """Ripple of the dry friction of both cylinders."""

    at_m: np.ndarray  # (k,) positions
    shares: np.ndarray  # (2, k) of the friction, test and load cylinder

    def along(self, x_m: np.ndarray) -> np.ndarray:
        """Return the factors (2, n) on the dry friction at positions (n,)."""
        return 1.0 + np.stack([np.interp(x_m, self.at_m, share) for share in self.shares])


def limits(name: str) -> tuple[float, float]:
    """Return the limits of a disturbance, in standard deviations.

    Commands that are early, against all else, are late valves.
    """
    is_late = delayed_channel(name) in (ALL_COMMANDS, POSITION)
    return (0.0 if is_late else -_LARGEST), _LARGEST
