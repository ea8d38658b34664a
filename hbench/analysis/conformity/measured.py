"""Measured values of the quantities that limits are stated for.

A requirement that names no speed applies to all measured speeds, one that names no series to all
series. Nothing is interpolated: a speed, a load or a pressure counts as measured within
``TOLERANCE``.
"""

import math
from collections.abc import Callable, Iterable, Iterator
from statistics import mean, stdev
from typing import TypeVar

from hbench.analysis.statistics.student import degrees_of_freedom, student_factor
from hbench.analysis.uncertainty.budget import combined_n
from hbench.records import (
    KINDS,
    Breakaway,
    Curve,
    EfficiencyCurve,
    EfficiencyPoint,
    Leakage,
    Results,
    RunPlan,
    ScreenedRun,
)
from hbench.records.conformity.acceptance import LimitQuantity, Measurement, Requirement
from hbench.records.rod_pressure import series_key
from hbench.records.runs import Direction, Series

TOLERANCE = 0.05  # relative difference from the stated speed, load or pressure
_UNSTEADY = "not_steady"  # reason for rejection
_SteadyCurve = TypeVar("_SteadyCurve", Curve, EfficiencyCurve)


def measurements(results: Results, requirement: Requirement) -> tuple[Measurement, ...]:
    """Return the measured values that a requirement applies to, one for each series and speed."""
    return tuple(_MEASURED[requirement.quantity](results, requirement))


def _friction(results: Results, requirement: Requirement) -> Iterable[Measurement]:
    for curve in _steady(results.curves, requirement):
        area = curve.specimen.driving_area_m2(curve.direction) or None
        per = (area or 0.0) if requirement.is_pressure else 1.0
        for point in curve.points if per else ():
            if near(abs(point.v_m_s), requirement.v_m_s):
                u95, u = point.u95_n or point.ci95_n, combined_n(point)
                yield Measurement(
                    value=curve.against_motion * point.friction_n / per,
                    u95=None if u95 is None else u95 / per,
                    dof=point.u95_dof if point.u95_n else point.n - 1,
                    u=None if u is None else u / per,
                    label=curve.label,
                    direction=curve.direction,
                    f_load_n=curve.f_load_n,
                    p_lr_ref_pa=curve.p_lr_ref_pa,
                    v_m_s=abs(point.v_m_s),
                    runs=point.runs,
                    without_instruments=point.sigma_instruments_n is None,
                    area_m2=area,
                )


def _efficiency(results: Results, requirement: Requirement) -> Iterable[Measurement]:
    for curve in _steady(results.efficiency, requirement):
        for point in curve.points:
            if point.efficiency is not None and near(abs(point.v_m_s), requirement.v_m_s):
                yield Measurement(
                    value=point.efficiency,
                    u95=point.u95 or point.ci95,
                    dof=point.u95_dof if point.u95 else _trials_dof(point),
                    u=point.sigma_combined if point.u95 else point.sigma_trials,
                    label=curve.label,
                    direction=curve.direction,
                    f_load_n=curve.f_load_n,
                    p_lr_ref_pa=curve.p_lr_ref_pa,
                    v_m_s=abs(point.v_m_s),
                    without_instruments=point.sigma is None,
                )


def _trials_dof(point: EfficiencyPoint) -> float | None:
    """Return the degrees of freedom of the trials' interval, by its factor to their error."""
    if not point.ci95 or not point.sigma_trials:
        return None
    return degrees_of_freedom(point.ci95 / point.sigma_trials)


def _breakaway(results: Results, requirement: Requirement) -> Iterable[Measurement]:
    longest: dict[tuple, Breakaway] = {}
    for each in results.motions.breakaways:
        series, stated = each.series, requirement.dwell_s
        if applies(each, series, requirement) and near(each.dwell_s, stated):
            key = series, each.direction
            if key not in longest or (each.dwell_s or 0.0) > (longest[key].dwell_s or 0.0):
                longest[key] = each
    for each in longest.values():
        area = each.breakaway_n / each.breakaway_pa if each.breakaway_pa else None
        per = (area or 0.0) if requirement.is_pressure else 1.0
        if not per:
            continue
        u95, u = each.u95_n or each.ci95_n, combined_n(each)
        yield Measurement(
            value=each.breakaway_n / per,
            u95=None if u95 is None else u95 / per,
            dof=each.u95_dof if each.u95_n else each.n - 1,
            u=None if u is None else u / per,
            label=each.series.label,
            direction=each.direction,
            f_load_n=each.series.f_load_n,
            p_lr_ref_pa=each.series.p_lr_ref_pa,
            dwell_s=each.dwell_s,
            runs=each.runs,
            without_instruments=each.u95_n is None,
            area_m2=area,
        )


def _leakage(results: Results, requirement: Requirement) -> Iterable[Measurement]:
    """Yield the flow at the required pressure, if it is not above those of the holds."""
    for leakage in leaks_measured(results, requirement):
        pressure = requirement.pressure_pa or 0.0
        loads = [d.series.f_load_n for d in leakage.decays if d.series.f_load_n is not None]
        for leak in leakage.coefficients:
            flow = leakage.flow_m3_s(leak, pressure) if leak.name == requirement.leak else None
            if flow and pressure <= (1 + TOLERANCE) * leakage.highest_pa(leak.name):
                yield Measurement(
                    value=flow[0],
                    u95=flow[1],
                    dof=len(leakage.decays) - 1,
                    label=leakage.label,
                    runs=tuple(decay.run for decay in leakage.decays),
                    step_pa=leakage.step_pa,
                    lowest_load_n=min(loads, default=None),
                    highest_load_n=max(loads, default=None),
                )


def leaks_measured(results: Results, requirement: Requirement) -> Iterator[Leakage]:
    """Yield the leakages of the required label, whatever the pressures of their holds."""
    for leakage in results.motions.leakages:
        if requirement.label in (None, leakage.label):
            yield leakage


def _speed_ripple(results: Results, requirement: Requirement) -> Iterable[Measurement]:
    """Yield the ripple of each steady point, relative to its speed; stick-slip is no reason not to.

    Its uncertainty is that of the trials alone.
    """
    trials: dict[tuple, list[ScreenedRun]] = {}
    for each in results.runs:
        plan = each.run.plan
        only_unsteady = all(reason.startswith(_UNSTEADY) for reason in each.reasons)
        if KINDS[plan.kind].has_constant_speed and only_unsteady and _ripple_of(each) is not None:
            if applies(plan, plan, requirement) and near(abs(plan.v_ref_m_s), requirement.v_m_s):
                trials.setdefault((*series_key(plan), abs(plan.v_ref_m_s)), []).append(each)
    for (label, direction, f_load_n, p_lr_ref_pa, v_m_s), runs in trials.items():
        ripples = [ripple for ripple in map(_ripple_of, runs) if ripple is not None]
        dof = len(ripples) - 1
        yield Measurement(
            value=mean(ripples),
            u95=student_factor(dof) * stdev(ripples) / math.sqrt(dof + 1) if dof else None,
            dof=dof or None,
            label=label,
            direction=direction,
            f_load_n=f_load_n,
            p_lr_ref_pa=p_lr_ref_pa,
            v_m_s=v_m_s,
            runs=tuple(each.run.plan.run for each in runs),
        )


def _ripple_of(screened: ScreenedRun) -> float | None:
    """Return the standard deviation of the speed as a share of the reference."""
    if screened.means is None or screened.means.v_ripple_m_s is None:
        return None
    return screened.means.v_ripple_m_s / abs(screened.run.plan.v_ref_m_s)


def _drift(results: Results, requirement: Requirement) -> Iterable[Measurement]:
    drift = results.drift
    if drift is not None and not drift.of_unknown_size:
        yield Measurement(
            value=drift.change_percent / 100,
            u95=drift.change_percent_ci95 / 100,
            dof=drift.dof,
        )


_MEASURED: dict[LimitQuantity, Callable[[Results, Requirement], Iterable[Measurement]]] = {
    "friction": _friction,
    "breakaway": _breakaway,
    "efficiency": _efficiency,
    "leakage": _leakage,
    "speed_ripple": _speed_ripple,
    "drift": _drift,
}


def _steady(curves: Iterable[_SteadyCurve], requirement: Requirement) -> Iterator[_SteadyCurve]:
    for curve in curves:
        if KINDS[curve.kind].has_constant_speed and applies(curve, curve, requirement):
            yield curve


def applies(
    directed: Curve | EfficiencyCurve | Breakaway | RunPlan,
    series: Curve | EfficiencyCurve | Series | RunPlan,
    requirement: Requirement,
) -> bool:
    """Whether a requirement applies to a series in its direction."""
    return (
        requirement.label in (None, series.label)
        and requirement.direction in (None, directed.direction)
        and near(series.f_load_n, requirement.f_load_n)
        and near(series.p_lr_ref_pa, requirement.p_lr_ref_pa)
    )


def near(value: float | None, stated: float | None) -> bool:
    """Whether a value is the stated one, within the tolerance; anything is where none is stated."""
    if stated is None:
        return True
    return value is not None and abs(value - stated) <= TOLERANCE * abs(stated)


def undriven_directions(results: Results, requirement: Requirement) -> tuple[Direction, ...]:
    """Return the directions of measured series that have no driving area for a limit in bar."""
    if not requirement.is_pressure:
        return ()
    if requirement.quantity == "breakaway":
        return _undriven_breakaways(results, requirement) if has_areas(results) else ()
    directions = (
        curve.direction
        for curve in _steady(results.curves, requirement)
        if curve.specimen.area_piston_m2 and not curve.specimen.driving_area_m2(curve.direction)
        if any(near(abs(point.v_m_s), requirement.v_m_s) for point in curve.points)
    )
    return tuple(dict.fromkeys(directions))


def _undriven_breakaways(results: Results, requirement: Requirement) -> tuple[Direction, ...]:
    directions = (
        each.direction
        for each in results.motions.breakaways
        if not each.breakaway_pa
        and applies(each, each.series, requirement)
        and near(each.dwell_s, requirement.dwell_s)
    )
    return tuple(dict.fromkeys(directions))


def has_areas(results: Results) -> bool:
    """Return whether a driving area is known: a drive without hydraulics has none."""
    return any(each.run.plan.specimen.area_piston_m2 > 0 for each in results.runs)
