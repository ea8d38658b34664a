"""Reduction of steady friction to a reference temperature of the oil.

With r = eta(T) / eta(T_ref) by ASTM D341, friction y_ij of trial j of point i is taken as

    y_ij = a_i + (c_0 + c_1 |v_i|) (r_ij - 1) + e_ij

with a level a_i of each point at the reference temperature. c_1 is viscous friction at that
temperature, as far as it follows the viscosity of the oil's record; c_0 is what depends on
viscosity at any speed, such as boundary friction that falls with temperature (c_0 > 0), or mixed
friction that rises as the film thins (c_0 < 0). With a wrong record both are wrong, but hardly
their product with r, which is the reduction. They are estimated from trials of one point at
different temperatures alone (fixed effects, ``statistics/within.py``), together for all loads of
a label and direction:

    y_ij - y_i = (c_0 + c_1 |v_i|) (r_ij - r_i) + e_ij

by least squares, with N - G - 2 degrees of freedom for N trials of G points: of newtons, or of
shares of friction where the scatter is proportional to it (the larger likelihood). No law of
friction is assumed between the points, so temperature that differs from speed to speed is not
taken for the effect of speed, nor the reverse. Friction is left as it was measured, with a reason,

  - where speeds were measured one after the other while the oil warmed. The trials of a point then
    have nearly one temperature, and the sensor's noise biases the coefficients towards zero. As for
    drift, the variance of r within the curves may be up to five times that within the points;
  - where the reference temperature is further outside of the measured ones than their range is
    wide, hbench's own limit: a line in r is not a law of friction;
  - where the correction is less than its uncertainty, and this is more than 5 % of friction (root
    mean squares of the points).

The reduced friction of a trial is y_ij - g'c with g = (r_ij - 1) (1, |v_i|). The half-width of a
point's interval is the root sum of squares of that of its reduced trials and the instruments, and
of Student's for the correction, t sqrt(g' C g) with the mean r of its trials. The error of the
correction is common to all points of a direction.
"""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.special import fdtrc

from hbench.analysis.curves.average import student_interval
from hbench.analysis.statistics.student import student_factor
from hbench.analysis.statistics.within import is_proportional, within
from hbench.analysis.uncertainty.budget import (
    combined,
    finite_or_none,
    of_instruments,
    of_trials,
)
from hbench.config.oil.record import OilRecord
from hbench.config.sensors import Instruments
from hbench.records import Curve, CurvePoint, ViscosityEffect
from hbench.records.summary import SEPARATED_VIF
from hbench.units import from_si

_LEAST_DOF = 2
_LARGEST_CONDITION = 1e6  # of the two columns, at unit length
_LARGEST_SHARE = 0.05  # of friction: an uncertainty of the correction that is small in any case


@dataclass(frozen=True)
class Estimate:
    """Coefficients c (2,) with their covariance (2, 2) and its degrees of freedom."""

    c: np.ndarray
    covariance: np.ndarray
    dof: int
    p: float  # of c = 0


@dataclass(frozen=True)
class _Trials:
    """Trials of the points with two or more; arrays (n,)."""

    curve: np.ndarray  # number of the curve
    point: np.ndarray  # number of the point
    speed_m_s: np.ndarray
    ratio: np.ndarray  # eta / eta_ref
    friction_n: np.ndarray  # positive against the motion


def reduced_curves(
    curves: Sequence[Curve], oil: OilRecord, t_ref_k: float, instruments: Instruments | None
) -> tuple[tuple[ViscosityEffect, ...], tuple[Curve, ...]]:
    """Return the effect of viscosity in each label and direction, and the reduced curves.

    Effects need two degrees of freedom, curves a determined effect and the temperatures of all
    their trials. The reduced curves have no fits.
    """
    groups: dict[tuple, list[Curve]] = defaultdict(list)
    for curve in curves:
        if curve.points and all(point.trials_temp_k for point in curve.points):
            groups[curve.kind, curve.label, curve.direction].append(curve)
    effects, reduced = [], []
    for (kind, label, direction), group in groups.items():
        trials = _trials(group, oil, t_ref_k)
        estimate = viscosity_coefficients(trials)
        if estimate is None:
            continue
        half = student_factor(estimate.dof) * np.sqrt(np.diag(estimate.covariance))
        change, change_half, friction = _corrections(group, oil, t_ref_k, estimate)
        most = int(np.argmax(np.abs(change)))
        vif = _speed_vif(trials)
        reason = (
            _not_separated(vif)
            or _too_far(group, t_ref_k)
            or _not_significant(change, change_half, friction)
        )
        effects.append(
            ViscosityEffect(
                kind=kind,
                label=label,
                direction=direction,
                dry_n=float(estimate.c[0]),
                dry_ci95_n=float(half[0]),
                viscous_n_s_m=float(estimate.c[1]),
                viscous_ci95_n_s_m=float(half[1]),
                p=estimate.p,
                points=len(np.unique(trials.point)),
                trials=len(trials.point),
                correction_n=float(change[most]),
                correction_ci95_n=float(change_half[most]),
                speed_vif=vif,
                reason=reason,
            )
        )
        if not reason:
            reduced += [_reduced(curve, oil, t_ref_k, estimate, instruments) for curve in group]
    return tuple(effects), tuple(reduced)


def viscosity_coefficients(trials: _Trials) -> Estimate | None:
    """Return c_0 [N] and c_1 [N s/m]; None with fewer than two degrees of freedom.

    None too where the ratio does not differ within points of two speeds.
    """
    dof = len(trials.point) - len(np.unique(trials.point)) - 2
    if dof < _LEAST_DOF:
        return None
    r = within(trials.ratio, trials.point)
    y = within(trials.friction_n, trials.point)
    x = np.column_stack([r, r * trials.speed_m_s])
    scale = np.sqrt((x**2).sum(axis=0))
    if not scale.all() or np.linalg.cond(x / scale) > _LARGEST_CONDITION:
        return None
    estimate, squares = _least_squares(x, y, dof)
    mean_n = np.abs(trials.friction_n - y)
    if mean_n.min() > 0.0:
        of_shares, squares_of_shares = _least_squares(x / mean_n[:, None], y / mean_n, dof)
        if is_proportional(squares, squares_of_shares, mean_n):
            return of_shares
    return estimate


def _least_squares(x: np.ndarray, y: np.ndarray, dof: int) -> tuple[Estimate, float]:
    """Return the coefficients of ``y`` (n,) over ``x`` (n, 2), and the residuals' squares."""
    scale = np.sqrt((x**2).sum(axis=0))
    c, *_ = np.linalg.lstsq(x / scale, y)
    residual = y - x / scale @ c
    squares = max(float(residual @ residual), np.finfo(float).tiny)
    variance = squares / dof
    p = float(fdtrc(2, dof, float(np.sum((x / scale @ c) ** 2)) / 2 / variance))
    return Estimate(c / scale, variance * np.linalg.inv(x.T @ x), dof, p), squares


def _trials(curves: Sequence[Curve], oil: OilRecord, t_ref_k: float) -> _Trials:
    rows = []
    points = [(i, curve, point) for i, curve in enumerate(curves) for point in curve.points]
    for number, (i, curve, point) in enumerate(points):
        if point.n < 2:
            continue
        ratios = oil.viscosity_ratio(np.array(point.trials_temp_k), t_ref_k)
        for ratio, friction in zip(ratios, point.trials_n, strict=True):
            against = curve.against_motion * friction
            rows.append((i, number, abs(point.v_m_s), ratio, against))
    return _Trials(*np.array(rows, dtype=float).reshape(-1, len(fields(_Trials))).T)


def _gradient(point: CurvePoint, oil: OilRecord, t_ref_k: float) -> np.ndarray:
    """Return g (n, 2) of each trial: the correction is -g c against the motion."""
    ratio = oil.viscosity_ratio(np.array(point.trials_temp_k), t_ref_k)
    return np.column_stack([ratio - 1.0, (ratio - 1.0) * abs(point.v_m_s)])


def _corrections(
    curves: Sequence[Curve], oil: OilRecord, t_ref_k: float, estimate: Estimate
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return each point's correction, its half-width at 95 % and the friction [N], (n,) each."""
    points = [(curve.against_motion, p) for curve in curves for p in curve.points]
    g = np.array([_gradient(p, oil, t_ref_k).mean(axis=0) for _, p in points])
    sigma = np.sqrt(np.einsum("ni,ij,nj->n", g, estimate.covariance, g))
    friction = np.array([sign * p.friction_n for sign, p in points])
    return -g @ estimate.c, student_factor(estimate.dof) * sigma, friction


def _speed_vif(trials: _Trials) -> float:
    in_curve, in_point = within(trials.ratio, trials.curve), within(trials.ratio, trials.point)
    return float(in_curve @ in_curve / (in_point @ in_point))


def _not_separated(vif: float) -> str:
    if vif <= SEPARATED_VIF:
        return ""
    return (
        "the order of the runs does not separate temperature from speed (variance inflation "
        f"{vif:.3g}; limit {SEPARATED_VIF:g})"
    )


def _too_far(curves: Sequence[Curve], t_ref_k: float) -> str:
    ranges = [curve.temp_range_k for curve in curves if curve.temp_range_k is not None]
    low, high = min(low for low, _ in ranges), max(high for _, high in ranges)
    if low - (high - low) <= t_ref_k <= high + (high - low):
        return ""
    low_c, high_c, ref_c = (from_si(temp, "degC") for temp in (low, high, t_ref_k))
    return (
        f"the oil was at {low_c:.1f} to {high_c:.1f} °C, which is too narrow a range to "
        f"extrapolate to {ref_c:.1f} °C"
    )


def _not_significant(change_n: np.ndarray, half_n: np.ndarray, friction_n: np.ndarray) -> str:
    change, half, friction = (np.sqrt(np.mean(x**2)) for x in (change_n, half_n, friction_n))
    if half < max(change, _LARGEST_SHARE * friction):
        return ""
    return (
        f"the correction, {change:.3g} N, is less than its uncertainty, {half:.3g} N, and this is "
        f"above {100 * _LARGEST_SHARE:g} % of friction (root mean squares)"
    )


def _reduced(
    curve: Curve,
    oil: OilRecord,
    t_ref_k: float,
    estimate: Estimate,
    instruments: Instruments | None,
) -> Curve:
    def at_reference(point: CurvePoint) -> CurvePoint:
        g = _gradient(point, oil, t_ref_k)
        trials = np.array(point.trials_n) - curve.against_motion * (g @ estimate.c)
        g_mean = g.mean(axis=0)
        sigma = float(np.sqrt(g_mean @ estimate.covariance @ g_mean))
        ci95 = student_interval(trials)
        u95, dof = ci95, None
        if ci95 is not None and (inputs := of_instruments(point)) is not None:
            both = combined([of_trials(ci95, point.n), inputs])
            u95, dof = both.expanded(instruments), finite_or_none(both.dof)
        half = student_factor(estimate.dof) * sigma
        return replace(
            point,
            friction_n=float(trials.mean()),
            trials_n=tuple(trials.tolist()),
            ci95_n=ci95,
            sigma_temperature_n=sigma,
            u95_n=None if u95 is None else float(np.hypot(u95, half)),
            u95_dof=dof,
            u95_monte_carlo_n=None,
            sigma_drift_n=None,
        )

    points = tuple(map(at_reference, curve.points))
    return replace(curve, points=points, fits=(), selection=None)
