"""Friction at the working speed, breakaway and efficiency, each with its uncertainty."""

import math
from collections.abc import Iterable
from dataclasses import replace
from statistics import median_low, stdev
from typing import NamedTuple

from hbench.analysis.uncertainty.budget import StandardUncertainty, combined, of_instruments
from hbench.records import (
    KINDS,
    Basis,
    Breakaway,
    Curve,
    CurvePoint,
    EfficiencyCurve,
    Headline,
    HeadlineNumber,
    HeadlineSeries,
    Results,
    RunPlan,
)
from hbench.records.numbers import NORMAL_95
from hbench.records.rod_pressure import SeriesKey, series_key, without_common_rod_pressure

V_TOLERANCE = 0.2  # relative distance of a measured speed from the working speed


class _AtRest(NamedTuple):
    """Friction as the piston begins to slide, and the time that it was measured after."""

    breakaway_n: HeadlineNumber | None
    dwell_s: float | None = None


def headline(
    curves: Iterable[Curve],
    efficiency: Iterable[EfficiencyCurve],
    breakaways: Iterable[Breakaway] = (),
    speed_m_s: float | None = None,
) -> Headline:
    """Return the headline numbers of each steady curve, or of each ramp without steady curves.

    A load of which only breakaway was measured has a row of its own.

    The working speed is ``speed_m_s``, by default the median of the measured steady speeds. The
    measured point next to it counts, up to ``V_TOLERANCE``; nothing is interpolated. Where all
    curves have a single speed, such as strokes whose speed depends on the pressure, each has its
    own by default.
    """
    curves, efficiency = tuple(curves), without_common_rod_pressure(efficiency)
    at_rest = _longest_dwells(breakaways)
    speed = _median_speed(curves) if speed_m_s is None else speed_m_s
    marked = without_common_rod_pressure(curves)
    ramps = [curve for curve in marked if KINDS[curve.kind].is_ramp]
    steady = any(KINDS[curve.kind].has_constant_speed for curve in marked)
    own_speed = speed_m_s is None and all(
        len(curve.points) == 1 for curve in curves if KINDS[curve.kind].has_constant_speed
    )
    series, seen = [], set()
    for curve, original in zip(marked, curves, strict=True):
        kind = KINDS[curve.kind]
        if not (kind.has_constant_speed if steady else kind.is_ramp) or series_key(curve) in seen:
            continue  # ramps of other accelerations
        seen.add(series_key(curve))
        if own_speed and steady:
            point: CurvePoint | None = curve.points[0]
        else:
            point = _nearest(curve.points, speed) if steady else None
        measured = at_rest.pop(series_key(original), None)
        breakaway = _measured(measured) if measured else _AtRest(_breakaway(curve, ramps))
        friction = None if point is None else _friction(curve, point)
        area = curve.specimen.driving_area_m2(curve.direction)
        series.append(
            HeadlineSeries(
                kind=curve.kind,
                label=curve.label,
                direction=curve.direction,
                f_load_n=curve.f_load_n,
                p_lr_ref_pa=original.p_lr_ref_pa,
                a_ref_m_s2=curve.a_ref_m_s2,
                v_m_s=None if point is None else abs(point.v_m_s),
                friction_n=friction,
                breakaway_n=breakaway.breakaway_n,
                breakaway_dwell_s=breakaway.dwell_s,
                efficiency=None if point is None else _efficiency(curve, point, efficiency),
                friction_pa=_on(area, friction),
                breakaway_pa=_on(area, breakaway.breakaway_n),
            )
        )
    series += map(_only_breakaway, at_rest.values())
    return Headline(speed, V_TOLERANCE, tuple(series))


def at_working_speed(results: Results, speed_m_s: float | None) -> Results:
    """Return ``results`` with the headline numbers of another working speed."""
    at_speed = headline(results.curves, results.efficiency, results.motions.breakaways, speed_m_s)
    return replace(results, headline=at_speed)


def planned_speed_m_s(plans: Iterable[RunPlan]) -> float | None:
    """Return the median of the steady speeds that were planned, accepted or not."""
    speeds = [abs(plan.v_ref_m_s) for plan in plans if KINDS[plan.kind].has_constant_speed]
    return median_low(speeds) if speeds else None


def _median_speed(curves: Iterable[Curve]) -> float | None:
    steady = (curve for curve in curves if KINDS[curve.kind].has_constant_speed)
    speeds = [abs(point.v_m_s) for curve in steady for point in curve.points]
    return median_low(speeds) if speeds else None


def _nearest(points: tuple[CurvePoint, ...], speed: float | None) -> CurvePoint | None:
    if speed is None or not points:
        return None
    nearest = min(points, key=lambda point: abs(abs(point.v_m_s) - speed))
    return nearest if abs(abs(nearest.v_m_s) - speed) <= V_TOLERANCE * speed else None


def _friction(curve: Curve, point: CurvePoint) -> HeadlineNumber:
    """Return the friction against the motion; a wrong sign makes it negative."""
    se = stdev(point.trials_n) / math.sqrt(point.n) if len(point.trials_n) > 1 else None
    u95 = point.u95_n or point.ci95_n
    return HeadlineNumber(
        curve.against_motion * point.friction_n, u95, point.ci95_n, se, _basis(point)
    )


def _on(area_m2: float, force: HeadlineNumber | None) -> HeadlineNumber | None:
    """Return a force as the pressure on an area; None without an area."""
    if force is None or not area_m2:
        return None
    u95, ci95, se = (
        None if each is None else each / area_m2 for each in (force.u95, force.ci95, force.se)
    )
    return HeadlineNumber(force.value / area_m2, u95, ci95, se, force.basis)


def _longest_dwells(breakaways: Iterable[Breakaway]) -> dict[SeriesKey, Breakaway]:
    """Return the breakaway after the longest rest of each series, by its ``series_key``."""
    longest: dict[SeriesKey, Breakaway] = {}
    for each in sorted(breakaways, key=lambda each: each.dwell_s or 0.0):
        series = each.series
        longest[series.label, each.direction, series.f_load_n, series.p_lr_ref_pa] = each
    return longest


def _measured(breakaway: Breakaway) -> _AtRest:
    se = stdev(breakaway.trials_n) / math.sqrt(breakaway.n) if breakaway.n > 1 else None
    u95 = breakaway.u95_n or breakaway.ci95_n
    number = HeadlineNumber(breakaway.breakaway_n, u95, breakaway.ci95_n, se, "breakaway")
    return _AtRest(number, breakaway.dwell_s)


def _only_breakaway(breakaway: Breakaway) -> HeadlineSeries:
    number, dwell_s = _measured(breakaway)
    area = breakaway.breakaway_n / breakaway.breakaway_pa if breakaway.breakaway_pa else 0.0
    return HeadlineSeries(
        kind=breakaway.kind,
        label=breakaway.series.label,
        direction=breakaway.direction,
        f_load_n=breakaway.series.f_load_n,
        p_lr_ref_pa=breakaway.series.p_lr_ref_pa,
        a_ref_m_s2=None,
        v_m_s=None,
        friction_n=None,
        breakaway_n=number,
        breakaway_dwell_s=dwell_s,
        efficiency=None,
        breakaway_pa=_on(area, number),
    )


def _breakaway(curve: Curve, ramps: Iterable[Curve]) -> HeadlineNumber | None:
    """Return the fit's friction at rest, else that of the slowest ramp as the seals begin to slide.

    A ramp's first bin of speed is some 30 mm/s wide, where friction has fallen already.
    """
    for fit in curve.fits if KINDS[curve.kind].has_constant_speed else ():
        stiction = fit.parameters.get("f_stiction_n")
        if stiction is None or stiction.ci95 is None or not fit.converged:
            continue
        low, high = stiction.ci95
        half = max(stiction.value - low, high - stiction.value)
        slowest = min(curve.points, key=lambda point: abs(point.v_m_s))
        of_fit = StandardUncertainty(half / NORMAL_95)
        inputs = of_instruments(slowest) or StandardUncertainty(0.0)
        u95 = combined([of_fit, inputs]).expanded()
        return HeadlineNumber(stiction.value, u95, half, stiction.se, "extrapolated")
    same = [ramp for ramp in ramps if ramp.fits and series_key(ramp) == series_key(curve)]
    for ramp in sorted(same, key=lambda ramp: ramp.a_ref_m_s2 or math.inf):
        first = min((abs(v) for fit in ramp.fits for v, _ in fit.line), default=None)
        slid = [p for p in ramp.points if first is not None and abs(p.v_m_s) >= first - 1e-9]
        if slid:
            return replace(_friction(ramp, slid[0]), basis="ramp")
    return None


def _efficiency(
    curve: Curve, point: CurvePoint, efficiency: Iterable[EfficiencyCurve]
) -> HeadlineNumber | None:
    """Return the efficiency at the point; None without load, where it is not that of operation."""
    for same in efficiency if curve.f_load_n != 0 else ():
        if same.kind == curve.kind and series_key(same) == series_key(curve):
            at = min(same.points, key=lambda p: abs(p.v_m_s - point.v_m_s))
            if at.efficiency is not None:
                u95 = at.u95 or at.ci95
                return HeadlineNumber(at.efficiency, u95, at.ci95, at.sigma_trials, _basis(point))
    return None


def _basis(point: CurvePoint) -> Basis:
    return "one_trial" if point.n == 1 else "trials"
