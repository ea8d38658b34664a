"""Scatter of friction from stroke to stroke: each reversal of motion draws a new level.

A cylinder's friction is not the same on every stroke (lubrication, how the seals lie). The level,
a factor on the dry part, is 1 + scatter N(0, 1), drawn for each cylinder when the velocity
changes sign after a stroke, and held to the next reversal. Only a motion above 2 mm/s counts as
a stroke, so that trembling about rest draws nothing.
"""

import numpy as np

from hbench.model.compiled import compiled, inlined
from hbench.model.noise import normal
from hbench.model.parameters import PlantParameters
from hbench.model.plant import LEVEL_L, LEVEL_T

STROKE_VELOCITY_M_S = 2e-3
LOWEST_LEVEL = 0.1  # friction stays passive however large the scatter

_DIRECTION = 2  # of the stroke under way: +-1, or 0 until one is recognised


def new_levels(noise: np.ndarray, par: PlantParameters) -> np.ndarray:
    """Return the levels of a first stroke: those of both cylinders, then the direction."""
    levels = np.zeros(3)
    _draw(levels, noise, par)
    return levels


@inlined
def update_levels(levels: np.ndarray, v: float, noise: np.ndarray, par: PlantParameters) -> None:
    """Draw new levels, in place, if the motion reversed at velocity ``v`` [m/s]. Once a tick."""
    if v * levels[_DIRECTION] < 0.0:
        _draw(levels, noise, par)
        levels[_DIRECTION] = 0.0
    if abs(v) > STROKE_VELOCITY_M_S:
        levels[_DIRECTION] = np.sign(v)


@compiled
def _draw(levels: np.ndarray, noise: np.ndarray, par: PlantParameters) -> None:
    levels[LEVEL_T] = max(LOWEST_LEVEL, 1.0 + par.test.friction.scatter * normal(noise))
    levels[LEVEL_L] = max(LOWEST_LEVEL, 1.0 + par.load.friction.scatter * normal(noise))
