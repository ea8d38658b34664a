"""One Stribeck curve, of the bench's size, in each law that the phenomena use."""

import numpy as np

from hbench.model.friction.laws import LAWS
from hbench.model.parameters import FrictionParameters
from hbench.records import Line

TUSTIN = FrictionParameters(
    law=LAWS["tustin"].code, coulomb=300.0, stiction=500.0, stribeck_velocity=0.03, viscous=2500.0
)
LUGRE = TUSTIN._replace(law=LAWS["lugre"].code, bristle_stiffness=3e5)
LEUVEN = TUSTIN._replace(
    law=LAWS["leuven"].code, elements=(60.0,) * 10, presliding=1e-3, shape=20.0
)

_MOST_POINTS = 2000  # of a curve


def line(label: str, x: np.ndarray, y: np.ndarray, points: bool = False) -> Line:
    """Return a series of a panel, thinned where it has more points than a figure shows."""
    every = -(-len(x) // _MOST_POINTS)
    return Line(label, np.asarray(x)[::every], np.asarray(y)[::every], points)
