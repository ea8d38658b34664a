"""The steady fit on ramps and the ramps' fit on the steady curve (section 6.2).

The source finds that they differ: friction while accelerating is not the steady one.
"""

from collections.abc import Sequence

from hbench.analysis.curves.ramps import slid
from hbench.analysis.identification.verification import curve_error
from hbench.records import KINDS, Curve, Fit, RampComparison


def compare_fits(curves: Sequence[Curve]) -> tuple[RampComparison, ...]:
    """Put the Tustin fits of each ramp curve and its load's steady one to each other's data.

    A ramp counts from breakaway on, as in its fit. Curves without a fit are left out.
    """
    found = []
    for ramp in curves:
        for steady in curves:
            analyses = KINDS[ramp.kind].analysis, KINDS[steady.kind].analysis
            if analyses == ("ramp_curve", "steady_curve") and _load(ramp) == _load(steady):
                of_steady, of_ramp = _tustin(steady), _tustin(ramp)
                if of_steady and of_ramp:
                    found.append(_compared(steady, of_steady, slid(ramp), of_ramp))
    return tuple(found)


def _load(curve: Curve) -> tuple:
    return curve.direction, curve.f_load_n, curve.p_lr_ref_pa, curve.specimen


def _tustin(curve: Curve) -> Fit | None:
    return next((fit for fit in curve.fits if fit.law == "tustin" and fit.parameters), None)


def _compared(steady: Curve, of_steady: Fit, ramp: Curve, of_ramp: Fit) -> RampComparison:
    return RampComparison(
        direction=steady.direction,
        f_load_n=steady.f_load_n,
        p_lr_ref_pa=steady.p_lr_ref_pa,
        a_ref_m_s2=ramp.a_ref_m_s2,
        steady_on_steady_n=curve_error(of_steady, steady),
        steady_on_ramp_n=curve_error(of_steady, ramp),
        ramp_on_steady_n=curve_error(of_ramp, steady),
        ramp_on_ramp_n=curve_error(of_ramp, ramp),
        runs=tuple(dict.fromkeys(run for point in ramp.points for run in point.runs)),
    )
