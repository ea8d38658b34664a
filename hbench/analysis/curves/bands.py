"""Friction bands: half difference and mean of both directions at one pressure, by trials.

half band    (F_extend - F_retract) / 2
middle       (F_extend + F_retract) / 2
energy       closed integral of F dx over a whole stroke out and back
"""

from collections.abc import Iterable

import numpy as np

from hbench.analysis.curves.average import student_interval
from hbench.records import Band, Curve, CurvePoint


def friction_bands(curves: Iterable[Curve]) -> tuple[Band, ...]:
    """Pair the directions of curves with few speeds, in order of series and of rising pressure.

    A pair has the same kind, label, cylinder, load and rod-side pressure, and the same number of
    speeds. Half band, middle and energy are formed within each trial that both directions have,
    since a trial affects both directions alike; the intervals are Student's over these trials.
    Pairs without a common trial give no band.
    """
    pairs: dict[tuple, dict[str, Curve]] = {}
    for curve in curves:
        if not curve.over_velocity:
            series = curve.kind, curve.label, curve.specimen
            key = *series, curve.f_load_n, curve.p_lr_ref_pa
            pairs.setdefault(key, {})[curve.direction] = curve
    bands = [
        _band(pair["extend"], *points)
        for pair in pairs.values()
        if len(pair) == 2 and len(pair["extend"].points) == len(pair["retract"].points)
        for points in zip(pair["extend"].points, pair["retract"].points, strict=True)
        if set(points[0].trials) & set(points[1].trials)
    ]
    order = list(dict.fromkeys((band.kind, band.label) for band in bands))
    return tuple(sorted(bands, key=lambda b: (order.index((b.kind, b.label)), b.p_tp_pa or 0.0)))


def _band(curve: Curve, extend: CurvePoint, retract: CurvePoint) -> Band:
    out, back = (dict(zip(p.trials, p.trials_n, strict=True)) for p in (extend, retract))
    both = [trial for trial in out if trial in back]
    halves = np.array([(out[trial] - back[trial]) / 2 for trial in both])
    middles = np.array([(out[trial] + back[trial]) / 2 for trial in both])
    energies = _energies(extend, retract)
    return Band(
        kind=curve.kind,
        label=curve.label,
        factors=curve.factors,
        specimen=curve.specimen,
        f_load_n=curve.f_load_n,
        p_lr_ref_pa=curve.p_lr_ref_pa,
        v_m_s=(abs(extend.v_m_s) + abs(retract.v_m_s)) / 2,
        p_tp_pa=_mean_pressure(extend, retract),
        half_n=float(halves.mean()),
        half_ci95_n=student_interval(halves),
        middle_n=float(middles.mean()),
        middle_ci95_n=student_interval(middles),
        energy_j=float(energies.mean()) if len(energies) else None,
        energy_ci95_j=student_interval(energies),
        n=len(both),
        trials=tuple(both),
        trials_half_n=tuple(halves.tolist()),
        trials_middle_n=tuple(middles.tolist()),
        trials_energy_j=tuple(energies.tolist()),
        extend=extend,
        retract=retract,
    )


def _energies(extend: CurvePoint, retract: CurvePoint) -> np.ndarray:
    """Return the energy of a cycle in each trial with the work of both strokes (n,) [J]."""
    out, back = (dict(zip(p.trials, p.trials_work_j, strict=False)) for p in (extend, retract))
    works = [(work, back.get(trial)) for trial, work in out.items()]
    return np.array([a + b for a, b in works if a is not None and b is not None])


def _mean_pressure(extend: CurvePoint, retract: CurvePoint) -> float | None:
    if extend.p_tp_pa is None or retract.p_tp_pa is None:
        return None
    return (extend.p_tp_pa + retract.p_tp_pa) / 2
