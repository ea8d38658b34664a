"""Friction bands: half difference and mean of both directions at one pressure, by trials."""

from collections.abc import Iterable

import numpy as np

from hbench.analysis.curves.average import student_interval
from hbench.records import Band, Curve, CurvePoint


def friction_bands(curves: Iterable[Curve]) -> tuple[Band, ...]:
    """Pair the directions of curves with few speeds, in order of series and of rising pressure.

    A pair has the same kind, label, cylinder, load and rod-side pressure, and the same number of
    speeds. The half band is formed within each trial that both directions have, since a trial
    affects both directions alike; the interval is Student's over these trials.
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
    by_trial_extend, by_trial_retract = (
        dict(zip(point.trials, point.trials_n, strict=True)) for point in (extend, retract)
    )
    both = [trial for trial in by_trial_extend if trial in by_trial_retract]
    out = np.array([by_trial_extend[trial] for trial in both])
    back = np.array([by_trial_retract[trial] for trial in both])
    halves = (out - back) / 2
    return Band(
        kind=curve.kind,
        label=curve.label,
        f_load_n=curve.f_load_n,
        p_lr_ref_pa=curve.p_lr_ref_pa,
        p_tp_pa=_mean_pressure(extend, retract),
        half_n=float(halves.mean()),
        half_ci95_n=student_interval(halves),
        middle_n=float((out + back).mean() / 2),
        n=len(both),
        extend=extend,
        retract=retract,
    )


def _mean_pressure(extend: CurvePoint, retract: CurvePoint) -> float | None:
    if extend.p_tp_pa is None or retract.p_tp_pa is None:
        return None
    return (extend.p_tp_pa + retract.p_tp_pa) / 2
