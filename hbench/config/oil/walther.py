"""Kinematic viscosity of a mineral oil over temperature, from its values at two temperatures.

ASTM D341 (after C. Walther): an oil is a straight line in the chart of log log Z over log T,

    log10 log10 Z = A - B log10 T,   Z = nu + 0.7,   nu in mm^2/s, T in K

for nu from 2 mm^2/s on. Below, the standard adds terms to Z that are left out here: at 2 mm^2/s
they are 1e-3 of it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

LEAST_M2_S = 2e-6  # validity of Z = nu + 0.7
_MM2_S = 1e-6
_SHIFT = 0.7


@dataclass(frozen=True)
class ViscosityLine:
    """Straight line of an oil in the chart of ASTM D341, by its constants A and B."""

    a: float
    b: float

    @classmethod
    def through(cls, points: dict[float, float]) -> "ViscosityLine":
        """Return the line through two points: kinematic viscosity [m^2/s] by temperature [K]."""
        t_k, nu = (np.array(list(column), dtype=float) for column in (points, points.values()))
        y, x = np.log10(np.log10(nu / _MM2_S + _SHIFT)), np.log10(t_k)
        b = float((y[0] - y[1]) / (x[1] - x[0]))
        return cls(float(y[0] + b * x[0]), b)

    def kinematic_m2_s(self, t_k: Any) -> Any:
        """Return the kinematic viscosity [m^2/s] at temperatures [K], of the same shape."""
        z = 10.0 ** (10.0 ** (self.a - self.b * np.log10(t_k)))
        return _MM2_S * (z - _SHIFT)
