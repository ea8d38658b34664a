"""Coulomb and viscous friction from both directions, without a friction law.

For benches without hydraulics, and for curves with too few speeds for a law. At the same speed in
both directions, F(v) and F(-v) of the steady curves are

    (F(v) - F(-v)) / 2 = F_C + B v        Coulomb and viscous friction
    (F(v) + F(-v)) / 2 = F_0 + A v        offset of the force, asymmetry of the viscous part

Each is a line through the speeds, with the intervals of ``line_of_trials``.
"""

from collections import defaultdict
from collections.abc import Iterable

import numpy as np

from hbench.analysis.rounding import distinct
from hbench.analysis.statistics.line_of_trials import line_of_trials
from hbench.records import Curve, CurvePoint, MotionBalance

_FEWEST = 3  # speeds of a line
_SAME_SPEED = 0.05  # relative difference of two points of one nominal speed


def motion_balances(curves: Iterable[Curve]) -> tuple[MotionBalance, ...]:
    """Return the balance of each series that has three speeds in both directions.

    Series with pressures and a fitted law have none. Points with the same trials in both directions
    form the pairs.
    """
    series: dict[tuple, dict[str, Curve]] = defaultdict(dict)
    for curve in curves:
        if curve.points and (not curve.fits or all(p.p_tp_pa is None for p in curve.points)):
            loads = curve.f_load_n, curve.p_lr_ref_pa
            series[curve.kind, curve.label, curve.specimen, *loads][curve.direction] = curve
    balances = []
    for (kind, label, _, f_load_n, _), pair in series.items():
        points = list(_pairs(pair)) if len(pair) == 2 else []
        speeds = np.array([out.v_m_s - back.v_m_s for out, back in points]) / 2
        if len(points) and len(distinct(speeds)) >= _FEWEST:
            halves = [_by_trial(out, back, -1) for out, back in points]
            middles = [_by_trial(out, back, 1) for out, back in points]
            half, middle = (
                line_of_trials(speeds, [float(np.mean(list(v.values()))) for v in values], values)
                for values in (halves, middles)
            )
            balances.append(
                MotionBalance(
                    kind=kind,
                    label=label,
                    f_load_n=f_load_n,
                    speeds_m_s=tuple(speeds.tolist()),
                    coulomb_n=half.intercept,
                    coulomb_ci95_n=half.intercept_ci95,
                    viscous_n_s_m=half.slope,
                    viscous_ci95_n_s_m=half.slope_ci95,
                    offset_n=middle.intercept,
                    offset_ci95_n=middle.intercept_ci95,
                    asymmetry_n_s_m=middle.slope,
                    asymmetry_ci95_n_s_m=middle.slope_ci95,
                )
            )
    return tuple(balances)


def _pairs(pair: dict[str, Curve]) -> Iterable[tuple[CurvePoint, CurvePoint]]:
    for out in pair["extend"].points:
        for back in pair["retract"].points:
            near = abs(out.v_m_s + back.v_m_s) <= _SAME_SPEED * out.v_m_s
            if near and set(out.trials) & set(back.trials):
                yield out, back


def _by_trial(out: CurvePoint, back: CurvePoint, sign: int) -> dict[int, float]:
    of_back = dict(zip(back.trials, back.trials_n, strict=True))
    return {
        trial: (force + sign * of_back[trial]) / 2
        for trial, force in zip(out.trials, out.trials_n, strict=True)
        if trial in of_back
    }
