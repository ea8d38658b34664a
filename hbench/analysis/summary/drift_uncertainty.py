"""Drift of friction as a part of the uncertainty of points, fits and efficiencies."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from hbench.analysis.fitting.fit import CURVE_LAWS, typical_sizes
from hbench.analysis.fitting.fit_data import fit_points
from hbench.analysis.statistics.intervals import too_wide
from hbench.analysis.statistics.student import student_factor
from hbench.analysis.summary.run_clock import RunClock, campaign_place
from hbench.analysis.summary.zero_drift import ZeroDrift
from hbench.analysis.uncertainty.budget import (
    StandardUncertainty,
    combined,
    combined_n,
    finite_or_none,
)
from hbench.records import Curve, CurvePoint, Drift, EfficiencyCurve, EfficiencyPoint, Fit
from hbench.records.numbers import NORMAL_95


def with_drift(
    curves: Sequence[Curve], drift: Drift | None, clock: RunClock, weights: str = "trials"
) -> tuple[Curve, ...]:
    """Return ``curves`` with a significant drift as a part of each point's and fit's interval.

    The measured friction of a point is that at its own mean time t_i; its result is understood as
    that at the campaign's mean time t. The deviation between them is estimated, not corrected, and
    counts as a standard uncertainty, with that of the estimate (JCGM 100:2008, F.2.4.5 and (10)):

        u_i = |t_i - t| sqrt(d^2 + se^2),   U95_i^2 <- U95_i^2 + (1.96 u_i)^2

    d and se are those of ``friction_drift``, for a relative drift times the point's friction. The
    drift within a point is part of the scatter of its trials. u_i has the same cause in all points:
    it shifts the parameters of a fit with the Jacobian J by J^+ (t_i - t) sqrt(d^2 + se^2), which
    widens their intervals in the same way, and so can make them not determined. ``weights`` are
    those of the fits. The drift has infinite degrees of freedom in those of U95_i (G.2b).

    Where only the order of the runs is known, which may be that of file names, a drift that is not
    separated from speed adds nothing: it would be extrapolated from neighbours to a whole campaign.
    """
    if drift is None or not drift.significant or not any(curve.points for curve in curves):
        return tuple(curves)
    if drift.of_unknown_size:
        return tuple(curves)
    se = drift.change_ci95 / student_factor(drift.dof)
    per_span = float(np.hypot(drift.change, se))
    is_relative = drift.scale == "relative"
    return _with_change(
        curves, clock, weights,
        lambda _, point: per_span * (abs(point.friction_n) if is_relative else 1.0),
    )  # fmt: skip


def with_zero_drift(
    curves: Sequence[Curve], zero: ZeroDrift | None, clock: RunClock, weights: str = "trials"
) -> tuple[Curve, ...]:
    """Return ``curves`` with a drifting zero as a part of each point's and fit's interval.

    As in ``with_drift``; the force is added to friction in one direction, and subtracted from it
    in the other.
    """
    if zero is None or zero.of_unknown_size:
        return tuple(curves)
    per_span = float(np.copysign(np.hypot(zero.change_n, zero.se_n), zero.change_n))
    return _with_change(curves, clock, weights, lambda curve, _: curve.against_motion * per_span)


def _with_change(
    curves: Sequence[Curve],
    clock: RunClock,
    weights: str,
    change_n: Callable[[Curve, CurvePoint], float],
) -> tuple[Curve, ...]:
    """Return ``curves`` with a linear change of friction [N] over the campaign in the intervals."""
    place = campaign_place(curves, clock)

    def widened(curve: Curve) -> Curve:
        deviations = [place(point) * change_n(curve, point) for point in curve.points]
        points = (_wider(p, d) for p, d in zip(curve.points, deviations, strict=True))
        fits = (_wider_fit(fit, curve, np.array(deviations), weights) for fit in curve.fits)
        return replace(curve, points=tuple(points), fits=tuple(fits))

    return tuple(map(widened, curves))


def efficiency_with_drift(
    efficiencies: Iterable[EfficiencyCurve], curves: Iterable[Curve]
) -> tuple[EfficiencyCurve, ...]:
    """Return efficiencies with the drift of their ``curves``' points, those of ``with_drift``.

    Friction is a part of F_T, so that u(eta) = |eta / F_T| u_i (6.10).
    """

    def widened(point: EfficiencyPoint, measured: CurvePoint) -> EfficiencyPoint:
        known = point.sigma_combined is not None
        before, u, dof = (
            (point.u95, point.sigma_combined, point.u95_dof)
            if known
            else (point.ci95, point.sigma_trials, measured.n - 1)
        )
        if before is None or u is None or not measured.sigma_drift_n:
            return point
        sigma = efficiency_drift(point, measured)
        whole = _with_part(u, dof, sigma)
        return replace(
            point,
            sigma_combined=whole.value,
            u95=float(np.hypot(before, NORMAL_95 * sigma)),
            u95_dof=finite_or_none(whole.dof),
        )

    return tuple(
        replace(eta, points=tuple(map(widened, eta.points, curve.points)))
        for eta, curve in zip(efficiencies, curves, strict=True)
    )


def efficiency_drift(point: EfficiencyPoint, measured: CurvePoint) -> float:
    """Return u(eta) of a significant drift, with the sign of the friction's; 0 without one."""
    if point.efficiency is None or measured.sigma_drift_n is None:
        return 0.0
    return abs(point.efficiency / measured.f_test_n) * measured.sigma_drift_n


def _wider(point: CurvePoint, sigma_n: float) -> CurvePoint:
    u = combined_n(point)
    both = _larger_signed(point.sigma_drift_n or 0.0, sigma_n)
    if u is None or point.ci95_n is None:
        return replace(point, sigma_drift_n=both)
    before, dof = (
        (point.ci95_n, point.n - 1.0) if point.u95_n is None else (point.u95_n, point.u95_dof)
    )
    return replace(
        point,
        sigma_drift_n=both,
        u95_n=float(np.hypot(before, NORMAL_95 * sigma_n)),
        u95_dof=finite_or_none(_with_part(u, dof, sigma_n).dof),
    )


def _larger_signed(a: float, b: float) -> float:
    """Return both independent parts together, with the sign of the larger one."""
    return float(np.copysign(np.hypot(a, b), a if abs(a) > abs(b) else b))


def _with_part(u: float, dof: float | None, drift: float) -> StandardUncertainty:
    """Return an uncertainty ``u`` and a drift combined; the drift's dof are infinite."""
    parts = StandardUncertainty(u, np.inf if dof is None else dof), StandardUncertainty(drift)
    return combined(parts)


def _wider_fit(fit: Fit, curve: Curve, deviations_n: np.ndarray, weights: str) -> Fit:
    """Return the fit with the shifts of its parameters by ``deviations_n`` (n,) in ``ci95``."""
    if fit.law not in CURVE_LAWS or not fit.parameters or not fit.converged:
        return fit
    data, law = fit_points([curve], weights), CURVE_LAWS[fit.law]
    force_n, sizes = typical_sizes(law, data)
    lower, upper = law.limits(data.inputs, force_n, {})
    values = np.array([parameter.value for parameter in fit.parameters.values()])
    free = np.array([parameter.at_bound is None for parameter in fit.parameters.values()])
    jacobian = law.jacobian(data.inputs, values) / data.sigma[:, None]
    shifts = np.zeros(len(values))
    shifts[free] = np.linalg.lstsq(jacobian[:, free], deviations_n / data.sigma, rcond=None)[0]
    parameters = {}
    for i, (name, parameter) in enumerate(fit.parameters.items()):
        ends, wide, shift = parameter.ci95, parameter.wide, float(shifts[i])
        if ends is not None and parameter.at_bound is None:
            low, high = (np.hypot(parameter.value - end, NORMAL_95 * shift) for end in ends)
            ends = (parameter.value - float(low), parameter.value + float(high))
            cut_off = not (lower[i] < ends[0] and ends[1] < upper[i])
            half = np.array((ends[1] - ends[0]) / 2)
            wide |= bool(too_wide(half, np.array(parameter.value), sizes[i], cut_off))
        parameters[name] = replace(parameter, ci95=ends, wide=wide)
    contained = "the intervals contain the drift"
    message = "; ".join(dict.fromkeys(filter(None, (fit.message, contained))))
    return replace(fit, parameters=parameters, message=message)
