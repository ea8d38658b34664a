"""Friction surfaces over velocity and load, from steady curves at three loads or more."""

from collections import defaultdict
from collections.abc import Iterable

import numpy as np

from hbench.analysis.rounding import ROUNDING, distinct, exceeds
from hbench.records import KINDS, Curve, Surface

_LEAST = 3  # loads, and speeds


def friction_surfaces(curves: Iterable[Curve]) -> tuple[Surface, ...]:
    """Return a surface for each label, direction and rod-side pressure of the steady curves.

    Its speeds are those of the curve with the fewest points, in the range of all curves. Curves are
    linearly interpolated between their points, and not extrapolated.
    """
    groups: dict[tuple, list[tuple[float, Curve]]] = defaultdict(list)
    for curve in curves:
        is_steady = KINDS[curve.kind].has_constant_speed
        if is_steady and curve.f_load_n is not None and curve.over_velocity:
            key = curve.kind, curve.label, curve.direction, curve.p_lr_ref_pa, curve.specimen
            groups[key].append((curve.f_load_n, curve))
    surfaces = []
    for (kind, label, direction, p_lr, _), group in groups.items():
        group = sorted(group, key=lambda pair: pair[0])
        v = _common_speeds([curve for _, curve in group])
        if len(group) >= _LEAST and len(v) >= _LEAST:
            rows = [_row(curve, v) for _, curve in group]
            surfaces.append(
                Surface(
                    label=label,
                    direction=direction,
                    p_lr_ref_pa=p_lr,
                    v_m_s=tuple(v.tolist()),
                    f_load_n=tuple(load for load, _ in group),
                    friction_n=tuple(tuple(friction.tolist()) for friction, _ in rows),
                    ci95_n=tuple(
                        tuple(float(c) if np.isfinite(c) else None for c in interval)
                        for _, interval in rows
                    ),
                    kind=kind,
                )
            )
    return tuple(surfaces)


def _common_speeds(group: list[Curve]) -> np.ndarray:
    speeds = [np.abs([point.v_m_s for point in curve.points]) for curve in group]
    low, high = max(v.min() for v in speeds), min(v.max() for v in speeds)
    fewest = min(speeds, key=len)
    nothing = ROUNDING * high
    inside = fewest[(fewest > low + nothing) & (fewest < high - nothing)]
    return distinct(np.array([low, *inside, high])) if exceeds(high, low) else np.zeros(0)


def _row(curve: Curve, v_m_s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    v = np.abs([point.v_m_s for point in curve.points])
    friction = curve.against_motion * np.array([point.friction_n for point in curve.points])
    interval = [np.nan if point.ci95_n is None else point.ci95_n for point in curve.points]
    return np.interp(v_m_s, v, friction), np.interp(v_m_s, v, interval)
