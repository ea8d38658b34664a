"""Hersey number of the points of a friction curve.

    H = eta(T) |v| / p   [m]

with the oil's dynamic viscosity at its measured temperature, the speed of the piston, and p the
higher of the two chamber pressures: a double-acting piston seal is pressed on by the pressure that
it seals, which acts on its flank. M. D. Hersey (The laws of lubrication of horizontal journal
bearings, J. Washington Acad. Sci. 4, 1914, 542-552) formed eta n / p of a bearing's revolutions n,
which has no dimension; of a sliding speed it is a length. Divided by the width of the contact,
which is not known here, H would be a number. The seal's preload is not in p, so H of seals at a
low pressure is too large.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hbench.config.oil.record import OilRecord
from hbench.records import Curve, CurvePoint


def with_hersey(curves: Sequence[Curve], oil: OilRecord) -> tuple[Curve, ...]:
    """Return ``curves`` with the Hersey number of each point that has all of its quantities."""
    return tuple(
        replace(curve, points=tuple(_with_hersey(point, oil) for point in curve.points))
        for curve in curves
    )


def _with_hersey(point: CurvePoint, oil: OilRecord) -> CurvePoint:
    pressures = [p for p in (point.p_tp_pa, point.p_tr_pa) if p is not None]
    eta = oil.dynamic_pa_s(np.array(point.trials_temp_k)) if point.trials_temp_k else None
    if eta is None or not pressures or max(pressures) <= 0.0:
        return point
    trials = eta * abs(point.v_m_s) / max(pressures)
    return replace(point, hersey_m=float(trials.mean()), trials_hersey_m=tuple(trials.tolist()))
