"""Start of the search for a dynamic law: Tustin's law along the sliding parts of motions.

At a given Stribeck velocity the law is linear in its other parameters, so that their best values
are computed, and the search needs no first guess of the size of friction:

    F = sign(v) (F_C (1 - e) + F_s e) + B v + offset,   e = exp(-|v| / v_s)
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import nnls

from hbench.analysis.screening.sample_friction import LoggedMotion
from hbench.model.parameters import FrictionParameters

_SLIDING_M_S = 2e-3  # faster samples slide
_SPEEDS = np.geomspace(2e-3, 0.5, 25)  # Stribeck velocities that are tried
_MOST_SAMPLES = 5000  # enough for a start


def sliding_start(
    motions: Sequence[LoggedMotion], known: FrictionParameters
) -> FrictionParameters | None:
    """Return ``known`` with the sliding friction along ``motions``; None where nothing slides."""
    v = np.concatenate([motion.v_m_s[motion.compared] for motion in motions])
    friction = np.concatenate([motion.friction_n[motion.compared] for motion in motions])
    sliding = np.flatnonzero(np.abs(v) > _SLIDING_M_S)[:: len(v) // _MOST_SAMPLES + 1]
    if not len(sliding):
        return None
    v, friction = v[sliding], friction[sliding]
    least, best = np.inf, None
    for v_s in _SPEEDS.tolist():
        near = np.exp(-np.abs(v) / v_s)
        either_sign = np.ones(len(v)), -np.ones(len(v))
        columns = np.sign(v) * (1 - near), np.sign(v) * near, v, *either_sign
        values, distance = nnls(np.column_stack(columns), friction)
        if distance < least:
            least, best = distance, (v_s, *values[:3].tolist())
    if best is None:
        return None
    v_s, coulomb, stiction, viscous = best
    return known._replace(
        coulomb=coulomb, stiction=stiction, stribeck_velocity=v_s, viscous=viscous
    )
