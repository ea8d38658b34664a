"""Friction of identified laws along the measured steady curves."""

from collections.abc import Sequence

import numpy as np

from hbench.config.friction import parse_friction
from hbench.model.build import friction_parameters
from hbench.model.friction.laws import steady_friction
from hbench.records import Curve, IdentifiedLaw, LawsAlongCurve

_SPEEDS = 60  # along a curve


def laws_along_curves(
    curves: Sequence[Curve], laws: Sequence[IdentifiedLaw]
) -> tuple[LawsAlongCurve, ...]:
    """Return the steady friction [N] of each law between the lowest and highest speed of a curve.

    Chamber pressures are interpolated linearly between the measured points; without hydraulics
    they are zero. Curves of a single speed are left out.
    """
    parameters = {
        law.law: friction_parameters(parse_friction(law.section, law.law))
        for law in laws
        if law.fit is not None
    }
    found = []
    for curve in curves:
        points = sorted(curve.points, key=lambda point: point.v_m_s)
        if len(points) < 2:
            continue
        measured = np.array([point.v_m_s for point in points])
        v = np.linspace(measured[0], measured[-1], _SPEEDS)
        p_p, p_r = (
            np.interp(v, measured, [getattr(point, name) or 0.0 for point in points])
            for name in ("p_tp_pa", "p_tr_pa")
        )
        friction = {
            name: np.array([steady_friction(*at, par) for at in zip(v, p_p, p_r, strict=True)])
            for name, par in parameters.items()
        }
        found.append(LawsAlongCurve(curve, v, friction))
    return tuple(found)
