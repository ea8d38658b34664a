"""What an effect changes in steady strokes, at the load in the middle and over all loads."""

from collections.abc import Mapping

import numpy as np

from hbench.reconcile.estimates import ParameterEstimates
from hbench.reconcile.hypothesis import Hypothesis
from hbench.reconcile.practice.fitted import (
    change,
    effect_in_practice,
    half_widths,
    without_effect,
)
from hbench.reconcile.strokes.series import MeasuredStrokes
from hbench.records import Change, EffectInPractice, WorkingPoint

_NAN = float("nan")


def strokes_in_practice(
    strokes: MeasuredStrokes, final: Hypothesis, fits: Mapping[str, ParameterEstimates]
) -> tuple[WorkingPoint, tuple[EffectInPractice, ...]]:
    """Return the working point, and what each effect changes; ``fits`` are by its name.

    The working point is the mean extending stroke of the load in the middle of all and of the speed
    in the middle of its speeds, with the residuals of the ``final`` hypothesis.
    """
    runs = strokes.mean_runs
    loads = [np.mean([pair.extend.f_applied_n for pair in run]) for run in runs]
    of_load = int(np.argsort(loads, kind="stable")[len(runs) // 2])
    of_speed = len(runs[of_load]) // 2
    middle = sum(map(len, runs[:of_load])) + of_speed
    stroke = runs[of_load][of_speed].extend
    residuals = strokes.gap_map(final).difference[middle]
    point = WorkingPoint(
        direction="extend",
        windows=1,
        v_m_s=stroke.v_m_s,
        x_m=_NAN,
        f_applied_n=stroke.f_applied_n if strokes.load_is_known else _NAN,
        p_tp_pa=stroke.p_tp_pa,
        p_tr_pa=stroke.p_tr_pa or _NAN,
        p_lp_pa=_NAN,
        p_lr_pa=_NAN,
        p_s_pa=_NAN,
        u_t_v=_NAN,
        u_l1_v=_NAN,
        u_l2_v=_NAN,
        residuals=dict(zip(strokes.balances, residuals.tolist(), strict=True)),
    )
    effects = (
        effect_in_practice(name, _changes(strokes, middle, estimates, name))
        for name, estimates in fits.items()
    )
    return point, tuple(effects)


def _changes(
    strokes: MeasuredStrokes, middle: int, estimates: ParameterEstimates, name: str
) -> tuple[Change, ...]:
    def missing(hypothesis: Hypothesis) -> np.ndarray:
        without = strokes.gap_map(without_effect(hypothesis, name)).difference
        return without - strokes.gap_map(hypothesis).difference

    def at_point(hypothesis: Hypothesis) -> dict[str, float]:
        return dict(zip(strokes.balances, missing(hypothesis)[middle].tolist(), strict=True))

    fitted = estimates.hypothesis
    half = half_widths(strokes.plant, estimates, name, at_point)
    of_loads = missing(fitted)
    return tuple(
        change(balance, "N", float(values[middle]), half[balance], values)
        for balance, values in zip(strokes.balances, of_loads.T, strict=True)
    )
