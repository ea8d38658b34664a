"""Acceptance of a cylinder: each requirement decided for each series that it applies to."""

from collections.abc import Iterable, Iterator
from dataclasses import replace

from hbench.analysis.conformity.decision import decide
from hbench.analysis.conformity.measured import (
    TOLERANCE,
    has_areas,
    leaks_measured,
    measurements,
    near,
    undriven_directions,
)
from hbench.analysis.conformity.rejected import rejected_points
from hbench.records import DIRECTION_WORDS, Results
from hbench.records.conformity.acceptance import (
    ConformityCheck,
    Measurement,
    Requirement,
    Rule,
    UntestedCause,
)
from hbench.records.rod_pressure import SeriesKey, series_key
from hbench.units import from_si

_LISTED = 4  # series of a reason
_Reason = tuple[str, tuple[UntestedCause, ...]]  # in words and as codes
_NOT_MEASURED = {
    "friction": "no accepted steady runs",
    "breakaway": "no accepted runs of kind breakaway",
    "efficiency": "no accepted steady runs with an efficiency",
    "leakage": "no accepted runs of kind hold that determine it",
    "speed_ripple": "no steady runs",
    "drift": "no operating point was measured twice at times that are known",
}


def conformity_checks(
    results: Results,
    requirements: Iterable[Requirement],
    rule: Rule,
    largest_uncertainty: float | None,
) -> tuple[ConformityCheck, ...]:
    """Return the decisions, in the order of the requirements, of each by speed and series.

    Of several speeds of a series, the one with the smallest probability of conformity decides.
    """
    return tuple(
        check
        for requirement in requirements
        for check in _checks(results, requirement, rule, largest_uncertainty)
    )


def _checks(
    results: Results, requirement: Requirement, rule: Rule, largest_uncertainty: float | None
) -> Iterator[ConformityCheck]:
    worst: dict[SeriesKey, ConformityCheck] = {}
    for measured in measurements(results, requirement):
        decided = decide(requirement, measured, rule, largest_uncertainty)
        check = ConformityCheck(
            *(requirement, measured, decided.probability, decided.decision),
            *(decided.reason, decided.causes),
        )
        key = series_key(measured)
        if key not in worst or _goodness(check) < _goodness(worst[key]):
            worst[key] = check
    yield from sorted(worst.values(), key=_place)
    missing: list[_Reason] = [
        (words, ("rejected",)) for words in rejected_points(results, requirement)
    ]
    for direction in undriven_directions(results, requirement):
        words = (
            f"no oil drives the {DIRECTION_WORDS[direction]} plunger: limit its force in N, and "
            "give the limit in bar 'direction: extend'"
        )
        missing.append((words, ("undriven",)))
    if not worst and not missing:
        missing = [_why_not(results, requirement)]
    for words, causes in missing:
        yield ConformityCheck(requirement, None, None, "NOT TESTED", words, causes)


def _why_not(results: Results, requirement: Requirement) -> _Reason:
    """Return the reason for which nothing was measured: what is required and was not measured."""
    if requirement.leak and (leakages := tuple(leaks_measured(results, requirement))):
        highest = max(leakage.highest_pa(requirement.leak) for leakage in leakages)
        if requirement.pressure_pa and requirement.pressure_pa > (1 + TOLERANCE) * highest:
            bar = from_si(highest, "bar")
            return f"the highest mean pressure of a hold is {bar:.3g} bar", ("pressure",)
    if requirement.quantity == "drift" and results.drift is not None:
        words = (
            "the times of the runs are not known, and the order of their files does not separate a "
            "drift from speed: map a column of date-times as t_s if the files have one"
        )
        return words, ("times",)
    if requirement.is_pressure and not has_areas(results):
        return "the driving area, on which a pressure is limited, is not known", ("area",)
    anywhere = replace(
        requirement, label=None, direction=None, f_load_n=None, p_lr_ref_pa=None, v_m_s=None
    )
    others = measurements(results, replace(anywhere, dwell_s=None))
    if not others:
        return _NOT_MEASURED[requirement.quantity], ("quantity",)
    asked: list[tuple[float | None, str, UntestedCause, str, list[float | None]]] = [
        (requirement.v_m_s, "speed", "speed", "mm/s", [each.v_m_s for each in others]),
        (requirement.f_load_n, "load", "load", "N", [each.f_load_n for each in others]),
        (
            *(requirement.p_lr_ref_pa, "rod-side pressure", "back_pressure", "bar"),
            [each.p_lr_ref_pa for each in others],
        ),
        (requirement.dwell_s, "rest", "rest", "s", [each.dwell_s for each in others]),
    ]
    absent = [
        (
            f"no {name} within {100 * TOLERANCE:g} % of {_written(limit, unit)} was measured; "
            f"{_nearest(limit, known, unit)}",
            cause,
        )
        for limit, name, cause, unit, values in asked
        if limit is not None
        and (known := [value for value in values if value is not None])
        and not any(near(value, limit) for value in known)
    ]
    if absent:
        return "; ".join(words for words, _ in absent), tuple(cause for _, cause in absent)
    stated = [name for limit, name, *_ in asked if limit is not None]
    if len(stated) > 1 and requirement.label is None and requirement.direction is None:
        return f"{' and '.join(stated)} were measured, but not together", ("combination",)
    series = dict.fromkeys(_series(each) for each in others)
    few = [*list(series)[:_LISTED], *["..."] * (len(series) > _LISTED)]
    return f"only other series were measured: {', '.join(few)}", ("series",)


def _series(measured: Measurement) -> str:
    """Return the label and the direction of a measurement."""
    direction = DIRECTION_WORDS[measured.direction] if measured.direction else ""
    return f"{measured.label} {direction}".strip()


def _nearest(limit: float, values: list[float], unit: str) -> str:
    """Write the measured values next to that of a limit, on either side."""
    below = [value for value in values if value < limit]
    above = [value for value in values if value > limit]
    sides = ([max(below)] if below else []) + ([min(above)] if above else [])
    return f"nearest: {' and '.join(_written(value, unit) for value in sides)}"


def _written(value: float, unit: str) -> str:
    return f"{float(f'{from_si(value, unit):.3g}'):.15g} {unit}".replace("-", "\N{MINUS SIGN}")


def _place(check: ConformityCheck) -> tuple[float, str, float, float]:
    """Return what checks of one requirement are ordered by; speeds equal as printed are equal."""
    measured = check.measurement
    assert measured is not None
    speed = float(f"{measured.v_m_s or 0.0:.3g}")
    load, back = abs(measured.f_load_n or 0.0), measured.p_lr_ref_pa or 0.0
    return speed, measured.direction or "", load, back


def _goodness(check: ConformityCheck) -> tuple[bool, float, float]:
    """Return what is smaller for the worse of two checks of one requirement."""
    measured, requirement = check.measurement, check.requirement
    assert measured is not None
    known = 1.0 if check.probability is None else check.probability
    inside = requirement.margin(measured.value)
    return check.decision not in ("FAIL", "NOT TESTED"), known, inside
