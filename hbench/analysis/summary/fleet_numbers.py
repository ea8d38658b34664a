"""Means of a campaign's headline numbers, fitted parameters and friction bands, for a fleet."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from operator import attrgetter
from statistics import fmean, harmonic_mean, stdev

from hbench.analysis.curves.band_trends import band_series
from hbench.analysis.statistics.student import degrees_of_freedom, satterthwaite
from hbench.records import (
    DIRECTIONS,
    KINDS,
    SERIES_FIELDS,
    Band,
    Curve,
    Direction,
    FleetNumber,
    HeadlineNumber,
    HeadlineSeries,
    Results,
    RunPlan,
    Side,
)

_FITTED = {
    "breakaway_fit_n": "f_stiction_n",
    "f_coulomb_n": "f_coulomb_n",
    "v_stribeck_m_s": "v_stribeck_m_s",
    "b_viscous_n_s_m": "b_viscous_n_s_m",
}


def fleet_numbers(results: Results) -> dict[tuple[str, Side], FleetNumber]:
    """Return the mean of each quantity over the loads of a direction, or over the series of bands.

    A quantity that one of the planned loads does not have is left out.
    """
    plans = [run.run.plan for run in results.runs]
    numbers: dict[tuple[str, Side], FleetNumber] = dict(_of_bands(results))
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


def _of_bands(results: Results) -> Iterator[tuple[tuple[str, Side], FleetNumber]]:
    """Yield half band, middle and energy at the median of the planned loads, and the slope.

    Where a load has bands at two speeds, they are those at the working speed.
    """
    series = _at_working_speed(results)
    columns: dict[str, list[FleetNumber]] = {}
    for bands in series:
        loads = _loads_of_both(results, bands[0])
        known = [band for band in bands if band.f_load_n in loads]
        if len({band.f_load_n for band in known}) < len(loads):
            continue
        middle = sorted(known, key=lambda band: band.p_tp_pa or band.f_load_n or 0.0)
        band = middle[(len(middle) - 1) // 2]
        for name, value, ci95, trials in (
            ("half_band_n", band.half_n, band.half_ci95_n, band.trials_half_n),
            ("middle_n", band.middle_n, band.middle_ci95_n, band.trials_middle_n),
            ("cycle_energy_j", band.energy_j, band.energy_ci95_j, band.trials_energy_j),
        ):
            if value is not None:
                se = stdev(trials) / math.sqrt(len(trials)) if len(trials) > 1 else None
                number = _with_half_width(value, ci95, se)
                if se is not None:
                    n = float(len(trials))
                    number = replace(number, trials=n, dof=n - 1)
                columns.setdefault(name, []).append(number)
        for trend in results.band_trends:
            if band in trend.bands:
                line = trend.half
                slope = _with_half_width(line.slope_n_pa, line.slope_ci95_n_pa, line.slope_se_n_pa)
                columns.setdefault("half_band_slope_n_pa", []).append(slope)
    for name, column in columns.items():
        if len(column) == len(series):
            yield (name, None), _mean(column)


def _at_working_speed(results: Results) -> tuple[list[Band], ...]:
    """Return of series that differ in their speed the one nearest to the working speed."""
    speed = results.headline.v_m_s
    all_series = band_series(results.bands)
    if speed is None:
        return all_series

    def distance(bands: list[Band]) -> float:
        return abs(fmean(band.v_m_s for band in bands) - speed)

    nearest: dict[tuple, list[Band]] = {}
    for bands in all_series:
        key = bands[0].kind, bands[0].label, bands[0].specimen, bands[0].p_lr_ref_pa
        nearest[key] = min(nearest.get(key, bands), bands, key=distance)
    return tuple(nearest.values())


def _loads_of_both(results: Results, band: Band) -> set[float | None]:
    """Return the loads that both directions of a band's series were planned at."""
    plans = [
        run.run.plan
        for run in results.runs
        if (run.run.plan.kind, run.run.plan.label, run.run.plan.specimen, run.run.plan.p_lr_ref_pa)
        == (band.kind, band.label, band.specimen, band.p_lr_ref_pa)
    ]
    extend, retract = (
        {plan.f_load_n for plan in plans if plan.direction == direction} for direction in DIRECTIONS
    )
    return extend & retract


def _with_half_width(value: float, half: float | None, se: float | None) -> FleetNumber:
    if half is None:
        return FleetNumber(value, se=se)
    return FleetNumber(value, value - half, value + half, se)


def _planned_loads(plans: list[RunPlan], direction: Direction) -> int:
    steady = [plan for plan in plans if KINDS[plan.kind].has_constant_speed]
    ramps = [plan for plan in plans if KINDS[plan.kind].is_ramp]
    chosen = steady or ramps or [plan for plan in plans if KINDS[plan.kind].raises_force]
    of_direction = [plan for plan in chosen if plan.direction == direction]
    return len({(p.label, p.f_load_n, p.p_lr_ref_pa) for p in of_direction})


def _curve(results: Results, series: HeadlineSeries) -> Curve | None:
    """Return the curve of the headline numbers; None where breakaway alone was measured."""
    key = attrgetter(*SERIES_FIELDS)
    return next((curve for curve in results.curves if key(curve) == key(series)), None)


def _number(number: HeadlineNumber | None) -> FleetNumber | None:
    if number is None:
        return None
    found = _with_half_width(number.value, number.u95, number.se)
    if number.basis == "extrapolated" or not number.se or number.ci95 is None:
        return found
    dof = round(degrees_of_freedom(number.ci95 / number.se))  # n - 1 of the trials
    return replace(found, trials=dof + 1.0, dof=float(dof))


def _measured(number: HeadlineNumber | None) -> FleetNumber | None:
    measured = number is not None and number.basis in ("ramp", "breakaway")
    return _number(number) if measured else None


def _fitted(curve: Curve | None, name: str) -> FleetNumber | None:
    """Return a fitted parameter; None where the curve does not determine it, as at a bound."""
    for fit in curve.fits if curve else ():
        parameter = fit.parameters.get(name)
        if parameter is None or not fit.converged or parameter.determination == "not determined":
            continue
        if parameter.ci95 and parameter.se is not None:
            low, high = parameter.ci95
            return FleetNumber(parameter.value, low, high, parameter.se)
    return None


def _mean(numbers: list[FleetNumber]) -> FleetNumber:
    def over(values: list[float | None], mean: Callable[[list[float]], float]) -> float | None:
        known = [value for value in values if value is not None]
        return mean(known) if len(known) == len(values) else None

    trials = over([number.trials for number in numbers], harmonic_mean)
    errors = [number.se for number in numbers if number.se is not None]
    dofs = [number.dof for number in numbers if number.dof is not None]
    known = trials is not None and len(errors) == len(dofs) == len(numbers)
    return FleetNumber(
        fmean(number.value for number in numbers),
        over([number.low for number in numbers], fmean),
        over([number.high for number in numbers], fmean),
        over([number.se for number in numbers], lambda each: math.hypot(*each) / len(each)),
        trials,
        satterthwaite([se**2 for se in errors], dofs)[1] if known else None,
    )
