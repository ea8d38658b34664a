"""What a certificate states of a campaign, and why a campaign is not certified.

The coverage factor of a value is Student's factor for its effective degrees of freedom (JCGM 100,
G.6.4), or 2 where the instruments' file says so (``expansion: k_2``).
"""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from statistics import median_low
from typing import Literal

from hbench.analysis.conformity.measured import measurements
from hbench.analysis.statistics.student import student_factor
from hbench.config.sensors import Instruments
from hbench.records import Results, Specimen
from hbench.records.conformity.acceptance import ConformityCheck, Measurement, Requirement
from hbench.records.conformity.certified import Certified
from hbench.records.rod_pressure import series_key

MOST_POINTS = 16  # steady points on a certificate; of more, three speeds of each series


def certified_values(
    results: Results, instruments: Instruments | None, decided: Iterable[Measurement] = ()
) -> tuple[tuple[Certified, ...], bool]:
    """Return the values of a certificate, and whether all measured speeds are among them.

    Of more than ``MOST_POINTS`` steady points, each series keeps its lowest and highest speed, the
    one next to the working speed, and those of the ``decided`` measurements. Errors of the
    instruments are in the uncertainty only where ``instruments`` are known. An efficiency without
    load is no value of a cylinder in operation, and is not among them.
    """
    forces = [_force("friction", each, instruments) for each in _all(results, "friction")]
    kept = _fewer(forces, results.headline.v_m_s, {_point(each) for each in decided})
    speeds = {_point(each.measurement) for each in kept}
    efficiencies = [
        Certified("efficiency", each, _factor(each, instruments) if instruments else None)
        for each in _all(results, "efficiency")
        if (_point(each) in speeds or not forces) and each.f_load_n != 0
    ]
    breakaways = (_force("breakaway", each, instruments) for each in _all(results, "breakaway"))
    values = (*kept, *efficiencies, *breakaways, *_leaks(results))
    return values, len(kept) == len(forces)


def certified_trials(checks: Iterable[ConformityCheck]) -> Iterator[Certified]:
    """Yield the decided speed ripples and drifts, whose U is that of the trials alone."""
    for check in checks:
        quantity, measured = check.requirement.quantity, check.measurement
        if measured is not None and (quantity == "speed_ripple" or quantity == "drift"):
            yield Certified(quantity, measured, _factor(measured, None))


def why_not_certified(results: Results) -> tuple[str, ...]:
    """Return the reasons why a campaign gets no certificate; empty if it gets one."""
    complete = results.quality.completeness
    reasons = []
    if complete.not_completed:
        count = len(complete.not_completed)
        reasons.append(f"{count} of {complete.planned} planned runs were not completed")
    unmeasured = sum(point.accepted == 0 for point in complete.short_points)
    if unmeasured:
        reasons.append(f"{unmeasured} of {complete.points} points have no accepted trial")
    if results.quality.grade == "poor":
        reasons.append("the quality of the data is 'poor'")
    if not any(run.accepted for run in results.runs):
        reasons.append("no run was accepted")
    sizes = {(each.area_piston_m2, each.area_rod_m2) for each in _cylinders(results)}
    if len(sizes) > 1:
        reasons.append(f"its runs are of {len(sizes)} sizes of cylinders, and a certificate of one")
    return tuple(reasons)


def _cylinders(results: Results) -> Iterator[Specimen]:
    for each in results.runs:
        yield each.run.plan.specimen


def _all(
    results: Results, quantity: Literal["friction", "efficiency", "breakaway"]
) -> tuple[Measurement, ...]:
    return measurements(results, Requirement(quantity, "N", None, None))


def _force(
    quantity: Literal["friction", "breakaway"],
    measured: Measurement,
    instruments: Instruments | None,
) -> Certified:
    """Return a force, also as the pressure on the driving area where that is known."""
    area = measured.area_m2
    certified = Certified(quantity, measured, _factor(measured, instruments))
    if not area:
        return certified
    half = None if measured.u95 is None else measured.u95 / area
    return replace(certified, pressure_pa=measured.value / area, pressure_u95_pa=half)


def _factor(measured: Measurement, instruments: Instruments | None) -> float | None:
    if measured.u95 is None:
        return None
    if instruments is not None and instruments.expansion == "k_2":
        return 2.0
    if measured.u:
        return measured.u95 / measured.u
    return student_factor(float("inf") if measured.dof is None else measured.dof)


def _leaks(results: Results) -> Iterator[Certified]:
    """Yield the leak coefficients, at the reference pressure where leaks are not laminar.

    No factor is stated: the assumed errors in U are limits without degrees of freedom.
    """
    for leakage in results.motions.leakages:
        for leak in leakage.coefficients:
            at = leakage.reference_pa or 1.0
            if flow := leakage.flow_m3_s(leak, at):
                runs = tuple(decay.run for decay in leakage.decays)
                measured = Measurement(
                    flow[0] / at, flow[1] / at, len(runs) - 1, leakage.label, runs=runs
                )
                yield Certified("leakage", measured, None, leak=leak.name)


def _fewer(points: list[Certified], working_m_s: float | None, kept: set[tuple]) -> list[Certified]:
    if len(points) <= MOST_POINTS:
        return points
    of_series: dict[tuple, list[float]] = {}
    for each in points:
        of_series.setdefault(series_key(each.measurement), []).append(each.measurement.v_m_s or 0.0)
    for series, speeds in of_series.items():
        working = median_low(speeds) if working_m_s is None else working_m_s
        nearest = min(speeds, key=lambda speed: abs(speed - working))
        kept = kept | {(*series, speed) for speed in (min(speeds), nearest, max(speeds))}
    return [each for each in points if _point(each.measurement) in kept]


def _point(measured: Measurement) -> tuple:
    return *series_key(measured), measured.v_m_s or 0.0
