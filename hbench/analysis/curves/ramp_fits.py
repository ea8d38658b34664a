"""Errors of the steady fit on ramps, and of the ramps' fit on the steady curve (section 6.2).

The source finds that they differ: friction during acceleration is not the steady friction.
"""

from collections.abc import Sequence

import numpy as np

from hbench.analysis.curves.ramps import sliding
from hbench.analysis.fitting.tustin import PARAMETER_NAMES, tustin_friction
from hbench.records import KINDS, Curve, Fit, RampComparison


def compare_fits(curves: Sequence[Curve]) -> tuple[RampComparison, ...]:
    """Compare the Tustin fits of each ramp curve and of the steady curve at its load.

    A ramp counts from breakaway on, as in its fit. Curves without a fit are left out.
    """
    comparisons = []
    for ramp in curves:
        for steady in curves:
            analyses = KINDS[ramp.kind].analysis, KINDS[steady.kind].analysis
            if analyses == ("ramp_curve", "steady_curve") and _load(ramp) == _load(steady):
                steady_fit, ramp_fit = _tustin(steady), _tustin(ramp)
                if steady_fit and ramp_fit:
                    comparisons.append(_compared(steady, steady_fit, sliding(ramp), ramp_fit))
    return tuple(comparisons)


def curve_error(fit: Fit, curve: Curve) -> float:
    """Return the root mean square [N] of a Tustin fit's differences from a curve's points."""
    p = np.array([fit.parameters[name].value for name in PARAMETER_NAMES])
    v = np.abs([point.v_m_s for point in curve.points])
    measured = curve.against_motion * np.array([point.friction_n for point in curve.points])
    return float(np.sqrt(np.mean((tustin_friction(v, p) - measured) ** 2)))


def _load(curve: Curve) -> tuple:
    return curve.direction, curve.f_load_n, curve.p_lr_ref_pa, curve.specimen


def _tustin(curve: Curve) -> Fit | None:
    return next((fit for fit in curve.fits if fit.law == "tustin" and fit.parameters), None)


def _compared(steady: Curve, steady_fit: Fit, ramp: Curve, ramp_fit: Fit) -> RampComparison:
    assert ramp.a_ref_m_s2 is not None  # every ramp has an acceleration
    return RampComparison(
        direction=steady.direction,
        f_load_n=steady.f_load_n,
        p_lr_ref_pa=steady.p_lr_ref_pa,
        a_ref_m_s2=ramp.a_ref_m_s2,
        steady_on_steady_n=curve_error(steady_fit, steady),
        steady_on_ramp_n=curve_error(steady_fit, ramp),
        ramp_on_steady_n=curve_error(ramp_fit, steady),
        ramp_on_ramp_n=curve_error(ramp_fit, ramp),
        runs=tuple(dict.fromkeys(run for point in ramp.points for run in point.runs)),
    )
