"""Means over the loads of a campaign's headline numbers and fitted parameters, for a fleet."""

import math
from collections.abc import Callable
from statistics import fmean

from hbench.records import (
    DIRECTIONS,
    KINDS,
    Curve,
    Direction,
    FleetNumber,
    HeadlineNumber,
    HeadlineSeries,
    Results,
    RunPlan,
)

_FITTED = {
    "breakaway_fit_n": "f_stiction_n",
    "f_coulomb_n": "f_coulomb_n",
    "v_stribeck_m_s": "v_stribeck_m_s",
    "b_viscous_n_s_m": "b_viscous_n_s_m",
}


def fleet_numbers(results: Results) -> dict[tuple[str, Direction], FleetNumber]:
    """Return the mean of each quantity over the loads of a direction.

    A quantity that one of the planned loads does not have is left out.
    """
    plans = [run.run.plan for run in results.runs]
    numbers = {}
    for direction in DIRECTIONS:
        series = [each for each in results.headline.series if each.direction == direction]
        loads = _planned_loads(plans, direction)
        columns: dict[str, list[FleetNumber | None]] = {
            "friction_n": [_number(each.friction_n) for each in series],
            "breakaway_n": [_measured(each.breakaway_n) for each in series],
            "efficiency": [_number(each.efficiency) for each in series],
        }
        curves = [_curve(results, each) for each in series]
        for name, parameter in _FITTED.items():
            columns[name] = [_fitted(curve, parameter) for curve in curves]
        for name, column in columns.items():
            known = [number for number in column if number is not None]
            if known and len(known) == loads:  # else it is no mean over the same loads
                numbers[name, direction] = _mean(known)
    return numbers


def _planned_loads(plans: list[RunPlan], direction: Direction) -> int:
    steady = [plan for plan in plans if KINDS[plan.kind].has_constant_speed]
    chosen = steady or [plan for plan in plans if KINDS[plan.kind].is_ramp]
    of_direction = [plan for plan in chosen if plan.direction == direction]
    return len({(p.label, p.f_load_n, p.p_lr_ref_pa) for p in of_direction})


def _curve(results: Results, series: HeadlineSeries) -> Curve:
    """Return the curve that the headline numbers are of."""
    names = ("kind", "label", "direction", "f_load_n", "p_lr_ref_pa", "a_ref_m_s2")
    key = [getattr(series, name) for name in names]
    return next(c for c in results.curves if [getattr(c, name) for name in names] == key)


def _number(number: HeadlineNumber | None) -> FleetNumber | None:
    if number is None:
        return None
    value, u95 = number.value, number.u95
    if u95 is None:
        return FleetNumber(value, se=number.se)
    return FleetNumber(value, value - u95, value + u95, number.se)


def _measured(number: HeadlineNumber | None) -> FleetNumber | None:
    return _number(number) if number is not None and number.basis == "trials" else None


def _fitted(curve: Curve, name: str) -> FleetNumber | None:
    for fit in curve.fits:
        parameter = fit.parameters.get(name)
        if fit.converged and parameter is not None and parameter.ci95 is not None:
            low, high = parameter.ci95
            return FleetNumber(parameter.value, low, high, parameter.se)
    return None


def _mean(numbers: list[FleetNumber]) -> FleetNumber:
    def over(values: list[float | None], mean: Callable[[list[float]], float]) -> float | None:
        known = [value for value in values if value is not None]
        return mean(known) if len(known) == len(values) else None

    return FleetNumber(
        fmean(number.value for number in numbers),
        over([number.low for number in numbers], fmean),
        over([number.high for number in numbers], fmean),
        over([number.se for number in numbers], lambda each: math.hypot(*each) / len(each)),
    )
