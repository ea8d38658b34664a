"""Why a measured breakaway can be below the friction of slow steady motion, in words."""

from math import hypot

from hbench.records import KINDS, Breakaway, CurvePoint, Results
from hbench.report.campaign.series_words import TITLES
from hbench.report.render.numbers import number, short, span


def creep_facts(results: Results) -> tuple[tuple[str, str], ...]:
    """Explain a breakaway below the friction of a slower steady run of its direction and load.

    The piston creeps faster then: friction at a higher steady speed is lower. A difference within
    the intervals of the trials is stated as one. Empty elsewhere.
    """
    below: list[tuple[Breakaway, CurvePoint, CurvePoint]] = []
    equal: list[tuple[Breakaway, CurvePoint]] = []
    for each in results.motions.breakaways:
        if (around := _around(results, each)) is None:
            continue
        slow, fast = around
        if not abs(fast.friction_n) < each.breakaway_n < abs(slow.friction_n):
            continue
        trials = hypot(each.ci95_n or 0.0, slow.ci95_n or 0.0)
        if abs(slow.friction_n) - each.breakaway_n > trials:
            below.append((each, slow, fast))
        else:
            equal.append((each, slow))
    sentences = [*_below(below), *_equal(equal)]
    title = "Breakaway below friction" if below else "Breakaway and friction"
    return ((title, " ".join(sentences)),) if sentences else ()


def _around(results: Results, each: Breakaway) -> tuple[CurvePoint, CurvePoint] | None:
    """Return the steady points next below and above the speed of the creep; None without them."""
    points = [
        point
        for curve in results.curves
        if KINDS[curve.kind].has_constant_speed
        and (curve.direction, curve.f_load_n, curve.p_lr_ref_pa)
        == (each.direction, each.series.f_load_n, each.series.p_lr_ref_pa)
        for point in curve.points
    ]
    creep = each.v_m_s or 0.0
    slower = [point for point in points if abs(point.v_m_s) < creep]
    faster = [point for point in points if abs(point.v_m_s) > creep]
    if not slower or not faster:
        return None
    return max(slower, key=_speed), min(faster, key=_speed)


def _speed(point: CurvePoint) -> float:
    return abs(point.v_m_s)


def _below(found: list[tuple[Breakaway, CurvePoint, CurvePoint]]) -> list[str]:
    """State each breakaway below friction, and once why it can be."""
    sentences = [
        f"{TITLES[each.direction]}, breakaway ({number(each.breakaway_n, 0)} N) is below the "
        f"friction of steady runs at {short(1e3 * _speed(slow))} mm/s "
        f"({number(abs(slow.friction_n), 0)} N)."
        for each, slow, _ in found
    ]
    if found:
        travel = span([1e3 * each.displacement_m for each, *_ in found])
        creep = span([1e3 * (each.v_m_s or 0.0) for each, *_ in found])
        falls = span([abs(fast.friction_n) for *_, fast in found])
        at = span([1e3 * _speed(fast) for *_, fast in found])
        sentences.append(
            f"Up to the largest friction of the ramp, the piston creeps {travel} mm and reaches "
            f"{creep} mm/s: friction takes some travel to build up, and is lower at higher speeds "
            f"({falls} N at {at} mm/s)."
        )
    return sentences


def _equal(found: list[tuple[Breakaway, CurvePoint]]) -> list[str]:
    return [
        f"{TITLES[each.direction]}, breakaway ({number(each.breakaway_n, 0)} N) and the friction "
        f"at {short(1e3 * _speed(slow))} mm/s ({number(abs(slow.friction_n), 0)} N) are equal "
        "within their trials."
        for each, slow in found
    ]
