"""Checks of the forces for errors with which friction still opposes the motion.

A load cell of the wrong sign turns a load that opposes the motion to one that helps it. Then both
the drive and the load supply the friction at every point, by a share of the load below 1/2:

    F' = F_T + |F| = F_f + 2 |F|,    |F| / F' < 1/2

An error of an area, or of the scale of a pressure or a force, adds a part of the load to friction,
in the same direction for extending and retracting. So the mean of both directions at one speed,
m = (F_extend + F_retract) / 2, changes with the load F that both have:

    s = sum x m / sum x^2,    x = F - F_speed,    U(s)^2 = sum x^2 U(m)^2 / (sum x^2)^2

over the loads of each speed, with the intervals of the trials. A change that is a small part of
friction does not matter. Friction that grows with the load in both directions leaves m as it is; if
it grows in one alone, by 6 % of the load, s is 3 %.

Where one direction alone was measured, s is that of its friction. Friction grows with the load, so
only a large s shows an error: where it is 50 %, a newton more at the rod costs the piston 1.5 N.

A force that is not measured, such as a weight on an upright cylinder, an error of a zero or one of
an area under a single load is in m too. Seals have more friction in one direction, but rarely twice
that of the other, which is |m| = h / 3 with h = (F_extend - F_retract) / 2. A smaller m is reported
if it is beyond its uncertainty and the same at all speeds and loads: a force is, friction rarely.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from statistics import fmean, median
from typing import NamedTuple

import numpy as np

from hbench.records import DIRECTION_WORDS, Curve, CurvePoint, Grade, Loop, QualityCheck

_SUPPLIED_GOOD = 5.0  # of the friction by the load, %
_CHANGE_GOOD, _CHANGE_POOR = 3.0, 10.0  # of the mean of both directions, % of the load
_SMALL = 5.0  # such a change, % of friction: it does not matter
_ONE_GOOD, _ONE_POOR = 50.0, 100.0  # of the friction of one direction, % of the load
_DIFFERENCE_GOOD = 100 / 3  # half the difference of the directions, % of their mean
_SAME_FORCE = 0.2  # largest distance of an m from their mean, as a share of it
_SAME_SPEED = 0.05  # relative difference of speeds with the same reference


class _Directions(NamedTuple):
    """Friction of both directions at one speed and load, or its mean."""

    load_n: float  # F_applied, mean
    middle_n: float  # m
    u_n: float  # U(m) of the trials
    u_all_n: float  # U(m) with the instruments, where they are known
    half_n: float  # h


class _Friction(NamedTuple):
    """What is compared over the loads: friction of one direction, or the mean of both."""

    load_n: float
    value_n: float
    u_n: float
    friction_n: float  # its size


class _Change(NamedTuple):
    """Change with the load, in % of it."""

    change: float
    half_width: float  # of its interval
    least: float  # end of the interval that is nearer to zero; 0 where it does not matter


def load_direction(curves: Iterable[Curve]) -> Iterator[QualityCheck]:
    """Yield the share of friction that the load supplies (median), if it helps at every point.

    Signs of friction, and points at which the load opposes the motion, show the rest.
    """
    shares = []
    for curve in curves:
        for point in curve.points:
            drive, load = (curve.against_motion * f for f in (point.f_test_n, point.f_applied_n))
            helps = drive > 0 > load
            shares.append(-100 * load / (drive - load) if helps else 0.0)
    if shares and min(shares) > _SUPPLIED_GOOD:
        yield QualityCheck(
            "load_direction", "with care", median(shares), "%", _SUPPLIED_GOOD, None, len(shares)
        )


def load_balance(curves: Iterable[Curve]) -> Iterator[QualityCheck]:
    """Yield the change of the mean of both directions with the load, % of it, where it is known.

    The grade is that of the end of its interval that is nearer to zero.
    """
    found = _change_with_load(curves)
    if found is None:
        return
    sure = found.least
    grade: Grade = (
        "good" if sure <= _CHANGE_GOOD else "poor" if sure > _CHANGE_POOR else "with care"
    )
    if grade != "good" or found.half_width <= _CHANGE_GOOD:
        yield QualityCheck("load_balance", grade, found.change, "%", _CHANGE_GOOD, _CHANGE_POOR)


def load_share(curves: Iterable[Curve]) -> Iterator[QualityCheck]:
    """Yield the change of friction with the load, % of it, where one direction was measured.

    Only a change that friction can't have is yielded.
    """
    curves = tuple(curves)
    if len({curve.direction for curve in curves if curve.points}) != 1:
        return
    found = _change(_one_direction(curves))
    if found is not None and found.least > _ONE_GOOD:
        grade: Grade = "poor" if found.least > _ONE_POOR else "with care"
        yield QualityCheck("load_share", grade, found.change, "%", _ONE_GOOD, _ONE_POOR)


def _one_direction(curves: Iterable[Curve]) -> Iterator[list[_Friction]]:
    """Yield what was measured in one direction: a list for each speed, an entry for each load."""
    series: dict[tuple, list[tuple[float, list[_Friction]]]] = defaultdict(list)
    for curve in curves:
        conditions = curve.kind, curve.label, curve.factors, curve.specimen, curve.a_ref_m_s2
        speeds = series[*conditions, curve.p_lr_ref_pa]
        for point in curve.points:
            friction_n, u_n = point.friction_n, point.ci95_n or 0.0
            row = _Friction(point.f_applied_n, friction_n, u_n, abs(friction_n))
            same = [rows for v_m_s, rows in speeds if _is_same(v_m_s, point.v_m_s)]
            if same:
                same[0].append(row)
            else:
                speeds.append((point.v_m_s, [row]))
    yield from (rows for speeds in series.values() for _, rows in speeds)


def _change_with_load(curves: Iterable[Curve]) -> _Change | None:
    """Return the change of the mean of both directions with the load; None if it is not known."""
    return _change(
        [_Friction(e.load_n, e.middle_n, e.u_n, abs(e.half_n)) for e in loads]
        for loads in _both_directions(curves)
    )


def _change(speeds: Iterable[Sequence[_Friction]]) -> _Change | None:
    """Return the change over the loads of all speeds; None where there is one load."""
    rows = []
    for loads in speeds:
        mean_n = fmean(each.load_n for each in loads)
        rows += [each._replace(load_n=each.load_n - mean_n) for each in loads]
    x, values, u, friction = np.array(rows).reshape(-1, 4).T
    square = float(x @ x)
    if square == 0.0:
        return None
    change = 100 * abs(float(x @ values)) / square
    half = 100 * float(np.linalg.norm(x * u)) / square
    least = max(change - half, 0.0)
    if least * np.ptp(x) < _SMALL * friction.mean():
        least = 0.0
    return _Change(change, half, least)


def equal_directions(curves: Iterable[Curve], loops: Iterable[Loop] = ()) -> Iterator[QualityCheck]:
    """Yield the largest difference of the directions, where one has over twice the friction.

    It is poor if friction drives one direction of most ``loops``, the means over whole strokes of
    triangles.
    """
    strokes = [_over_strokes(loop) for loop in loops]
    measured = [*_all_directions(curves), *strokes]
    driven = sum(abs(each.middle_n) > abs(each.half_n) for each in strokes)
    beyond = [
        each
        for each in measured
        if 100 * (abs(each.middle_n) - each.u_all_n) > _DIFFERENCE_GOOD * abs(each.half_n)
    ]
    if beyond:
        shares = (100 * abs(each.middle_n / each.half_n) for each in beyond if each.half_n)
        largest = max(shares, default=None)
        counts = len(beyond), len(measured)
        grade: Grade = "poor" if 2 * driven > len(measured) else "with care"
        yield QualityCheck("equal_directions", grade, largest, "%", _DIFFERENCE_GOOD, None, *counts)


def constant_force(curves: Iterable[Curve]) -> Iterator[QualityCheck]:
    """Yield a mean of both directions that is the same at all speeds and loads, % of friction."""
    mean = _constant_force(curves)
    if mean is not None:
        share = 100 * abs(mean.middle_n) / mean.half_n
        yield QualityCheck("constant_force", "with care", share, "%", _SMALL, None)


def direction_notes(curves: Iterable[Curve]) -> Iterator[str]:
    """Yield the size of that force with the friction that is free of it, or why none is known.

    Also friction of one direction that exceeds the load, and a change with the load that is small
    for the load, and not for friction.
    """
    curves = tuple(curves)
    directions = {curve.direction for curve in curves if curve.points}
    if len(directions) == 1:
        yield (
            f"directions: only {DIRECTION_WORDS[directions.pop()]} runs. A wrong diameter, a zero "
            "offset or a weight that is not measured is then a part of friction that no check "
            f"shows. {_beside_load(curves)}Measure both directions"
        )
    elif labels := _labels_of_one_direction(curves):
        names = " and ".join(f"'{label}'" for label in labels[:2])
        yield (
            "directions: each label has runs in one direction. Both directions are compared under "
            "one label alone, so a wrong diameter, a zero offset or a weight that is not measured "
            f"is a part of friction that no check shows. Give series such as {names} the same label"
        )
    elif (mean := _constant_force(curves)) is not None:
        yield (
            f"directions: the mean friction of both directions is {mean.middle_n:.3g} N (U "
            f"{mean.u_all_n:.2g} N) at all speeds and loads, as by a constant force that is not "
            "measured: the weight of an upright piston and rod, a zero offset, absolute pressures. "
            "Such a force is part of the friction of each direction; half the difference of both, "
            f"{mean.half_n:.3g} N, is free of it. Seals with more friction in one direction, as "
            "under the higher pressures there, do the same"
        )
    found = _change_with_load(curves)
    if found is not None and 0 < found.least <= _CHANGE_GOOD:
        yield (
            "directions: the mean friction of both directions changes by "
            f"{found.change:.2g} +- {found.half_width:.1g} % of the load, as by an error of this "
            "size in an area or in the scale of a force or pressure. Friction that depends on the "
            "load in one direction does the same. Half the difference of both directions is free "
            "of it"
        )


def _labels_of_one_direction(curves: Iterable[Curve]) -> list[str]:
    """Return the labels if both directions were measured, and none of them has both."""
    of_labels: dict[str, set[str]] = defaultdict(set)
    for curve in curves:
        if curve.points:
            of_labels[curve.label].add(curve.direction)
    measured = set().union(*of_labels.values())
    apart = len(measured) == 2 and all(len(each) == 1 for each in of_labels.values())
    return sorted(of_labels, key=lambda label: sorted(of_labels[label])) if apart else []


def _beside_load(curves: Iterable[Curve]) -> str:
    """Return a sentence on friction that is larger than the applied force at every point."""
    points = [point for curve in curves for point in curve.points]
    if any(abs(point.friction_n) <= abs(point.f_applied_n) for point in points):
        return ""
    if not all(point.f_applied_n for point in points):
        return ""  # no load
    times = median(abs(point.friction_n / point.f_applied_n) for point in points)
    return (
        f"Friction is {times:.2g} times the applied force (median): if the test was made under a "
        "load, check the units of the pressures and of the force. "
    )


def _constant_force(curves: Iterable[Curve]) -> _Directions | None:
    """Return the mean of all speeds and loads if their m is the same, and beyond its U."""
    measured = _all_directions(curves)
    if len(measured) < 2:
        return None
    mean = _Directions(*map(fmean, zip(*measured, strict=True)))
    mean = mean._replace(half_n=fmean(abs(each.half_n) for each in measured))
    furthest = max(abs(each.middle_n - mean.middle_n) for each in measured)
    beyond = abs(mean.middle_n) > max(mean.u_all_n, _SMALL / 100 * mean.half_n)
    return mean if beyond and furthest <= _SAME_FORCE * abs(mean.middle_n) else None


def _all_directions(curves: Iterable[Curve]) -> list[_Directions]:
    """Return what was measured in both directions at all speeds and loads."""
    return [each for loads in _both_directions(curves) for each in loads]


def _over_strokes(loop: Loop) -> _Directions:
    """Return both directions of a loop: the means of its friction over the distance.

    Their intervals are not known and are taken as 0.
    """
    _, v, friction = np.array(loop.trace).T
    extend, retract = (np.average(friction, weights=np.maximum(sign * v, 0)) for sign in (1, -1))
    load = loop.series.f_load_n or 0.0
    middle, half = (extend + retract) / 2, (extend - retract) / 2
    return _Directions(load, float(middle), 0.0, 0.0, float(half))


def _both_directions(curves: Iterable[Curve]) -> Iterator[list[_Directions]]:
    """Yield what was measured in both directions: a list for each speed, an entry for each load."""
    series: dict[tuple, dict[float | None, dict[str, Curve]]] = defaultdict(dict)
    for curve in curves:
        conditions = curve.kind, curve.label, curve.factors, curve.specimen, curve.a_ref_m_s2
        by_load = series[*conditions, curve.p_lr_ref_pa]
        by_load.setdefault(curve.f_load_n, {})[curve.direction] = curve
    for by_load in series.values():
        speeds: list[tuple[float, dict[float | None, _Directions]]] = []
        for load_n, pair in by_load.items():
            for v_m_s, directions in _paired(pair) if len(pair) == 2 else ():
                free = [(v, loads) for v, loads in speeds if load_n not in loads]
                same = [(v, loads) for v, loads in free if _is_same(v, v_m_s)]
                if same:
                    _, loads = min(same, key=lambda entry: abs(entry[0] - v_m_s))
                    loads[load_n] = directions
                else:
                    speeds.append((v_m_s, {load_n: directions}))
        yield from (list(loads.values()) for _, loads in speeds)


def _paired(pair: Mapping[str, Curve]) -> Iterator[tuple[float, _Directions]]:
    """Yield the speeds that a pair of curves has in both directions, with their friction."""
    for extend in pair["extend"].points:
        retract = _nearest(pair["retract"].points, extend.v_m_s)
        directions = None if retract is None else _of_points(extend, retract)
        if directions is not None:
            yield extend.v_m_s, directions


def _of_points(extend: CurvePoint, retract: CurvePoint) -> _Directions | None:
    """Return both directions together; None where one has a single trial."""
    if extend.ci95_n is None or retract.ci95_n is None:
        return None
    u95 = [point.u95_n or point.ci95_n or 0.0 for point in (extend, retract)]
    return _Directions(
        (extend.f_applied_n + retract.f_applied_n) / 2,
        (extend.friction_n + retract.friction_n) / 2,
        float(np.hypot(extend.ci95_n, retract.ci95_n)) / 2,
        fmean(u95),
        (extend.friction_n - retract.friction_n) / 2,
    )


def _nearest(points: Sequence[CurvePoint], v_m_s: float) -> CurvePoint | None:
    """Return the point whose speed is nearest; None where none is the same."""
    same = [point for point in points if _is_same(point.v_m_s, v_m_s)]
    return min(same, key=lambda point: abs(abs(point.v_m_s) - abs(v_m_s)), default=None)


def _is_same(a: float, b: float) -> bool:
    """Return whether two speeds are the same, in any direction."""
    return abs(abs(a) - abs(b)) <= _SAME_SPEED * max(abs(a), abs(b))
