"""Friction, breakaway and leakage over the distance that the piston has travelled in a campaign.

The distance of a run's log and of the way back to the next run's start are cumulated in the order
of the runs. A value has the distance at the middle of its steady run or cycle, or at the beginning
of its push or hold. The friction of a triangle's cycle is the work against it over its distance,

    F = integral of (F_T - F_applied) dx / integral of |dx|

from rest to rest, so that the inertia does no work. Two questions are answered by straight lines:
whether a quantity changes over the whole distance (endurance), and whether it still changes over
the last half of the values (run-in). It has settled where the 95 % interval of that last change
lies within ``SETTLED_WITHIN`` of the mean.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np

from hbench.analysis.rounding import is_constant
from hbench.analysis.screening.friction_channels import (
    friction_with_inertia,
    missing_friction_channels,
)
from hbench.analysis.screening.reference_sections import whole_cycles
from hbench.analysis.statistics.holm import holm
from hbench.analysis.statistics.line import straight_line
from hbench.motion.reversals import travel
from hbench.records import (
    KINDS,
    Breakaway,
    Curve,
    Direction,
    DistanceTrend,
    Leakage,
    ScreenedRun,
    Series,
)

SETTLED_WITHIN = 0.05  # of the mean
_FEWEST = 5  # values of a trend
_FEWEST_LAST = 4  # and of its last half


class _Span(NamedTuple):
    """Distance [m] travelled in the campaign before a run and after it."""

    begin_m: float
    end_m: float

    @property
    def middle_m(self) -> float:
        return 0.5 * (self.begin_m + self.end_m)


def distance_trends(
    screened: Sequence[ScreenedRun],
    steady: Iterable[Curve],
    breakaways: Iterable[Breakaway],
    leakages: Iterable[Leakage],
) -> tuple[DistanceTrend, ...]:
    """Return a trend for each quantity and series that was measured often enough.

    Imported logs have none: their order and the motion between them are not known.
    """
    if any(each.run.plan.motion is None for each in screened):
        return ()
    spans = _spans(screened)
    trends = [
        *_of_cycles(screened, spans),
        *_of_steady(steady, spans),
        *_of_breakaways(breakaways, spans),
        *_of_leakages(leakages, spans),
    ]
    p_holm = holm([trend.p for trend in trends]).tolist()
    return tuple(replace(trend, p_holm=p) for trend, p in zip(trends, p_holm, strict=True))


def _spans(screened: Iterable[ScreenedRun]) -> dict[str, _Span]:
    spans: dict[str, _Span] = {}
    total, x_m = 0.0, None
    for each in screened:
        if each.ends_m is not None:
            total += 0.0 if x_m is None else abs(each.ends_m[0] - x_m)
            x_m = each.ends_m[1]
        begin = total
        total += each.travel_m or 0.0
        spans[each.run.plan.run] = _Span(begin, total)
    return spans


def _of_cycles(
    screened: Iterable[ScreenedRun], spans: Mapping[str, _Span]
) -> Iterator[DistanceTrend]:
    groups: dict[tuple, list[tuple[float, float]]] = {}
    for each in screened:
        run, plan = each.run, each.run.plan
        is_triangle = KINDS[plan.kind].analysis == "hysteresis"
        if not (each.accepted and is_triangle) or missing_friction_channels(run):
            continue
        friction = friction_with_inertia(run)
        at = spans[plan.run].begin_m
        key = plan.kind, plan.series, abs(plan.v_ref_m_s)
        for window in whole_cycles(run.channel("v_ref_m_s")):
            x, force = run.x_m[window], friction[window]
            length = travel(run.t_s[window], x)
            work = float((force[1:] + force[:-1]) @ np.diff(x) / 2)
            groups.setdefault(key, []).append((at + 0.5 * length, work / length))
            at += length
    for (kind, series, v), points in groups.items():
        yield from _trend("friction_n", kind, series, None, points, v_m_s=v)


def _of_steady(curves: Iterable[Curve], spans: Mapping[str, _Span]) -> Iterator[DistanceTrend]:
    for curve in curves:
        for point in curve.points:
            if len(point.runs) == len(point.trials_n):
                values = [curve.against_motion * value for value in point.trials_n]
                middles = [spans[run].middle_m for run in point.runs]
                points = list(zip(middles, values, strict=True))
                of_curve = curve.kind, curve.series, curve.direction
                yield from _trend("friction_n", *of_curve, points, v_m_s=abs(point.v_m_s))


def _of_breakaways(
    breakaways: Iterable[Breakaway], spans: Mapping[str, _Span]
) -> Iterator[DistanceTrend]:
    for each in breakaways:
        if len(each.runs) == len(each.trials_n):
            begins = [spans[run].begin_m for run in each.runs]
            points = list(zip(begins, each.trials_n, strict=True))
            series, direction, rest = each.series, each.direction, each.dwell_s
            yield from _trend("breakaway_n", each.kind, series, direction, points, dwell_s=rest)


def _of_leakages(
    leakages: Iterable[Leakage], spans: Mapping[str, _Span]
) -> Iterator[DistanceTrend]:
    """Yield the oil that left the chamber of the higher pressure in each hold."""
    for leakage in leakages:
        groups: dict[Series, list[tuple[float, float]]] = {}
        for decay in leakage.decays:
            out = decay.out_p_m3_s if decay.p_p_pa > decay.p_r_pa else decay.out_r_m3_s
            groups.setdefault(decay.series, []).append((spans[decay.run].begin_m, out))
        for series, points in groups.items():
            yield from _trend("leakage_m3_s", leakage.kind, series, None, points)


def _trend(
    quantity: Literal["friction_n", "breakaway_n", "leakage_m3_s"],
    kind: str,
    series: Series,
    direction: Direction | None,
    points: Sequence[tuple[float, float]],
    v_m_s: float | None = None,
    dwell_s: float | None = None,
) -> Iterator[DistanceTrend]:
    """Yield the trend through ``points`` of distance [m] and value, if there are enough."""
    x, y = np.array(sorted(points)).reshape(-1, 2).T
    last = slice(-max(_FEWEST_LAST, (len(x) + 1) // 2), None)
    if len(x) < _FEWEST or is_constant(x[last]):
        return
    line, of_last = straight_line(x, y), straight_line(x[last], y[last])
    length, mean = float(x[-1] - x[last][0]), float(y[last].mean())
    change, half = of_last.slope * length, of_last.half * length
    if abs(change) + half <= SETTLED_WITHIN * abs(mean):
        verdict: Literal["settled", "changing", "not determined"] = "settled"
    else:
        verdict = "changing" if abs(change) > half else "not determined"
    yield DistanceTrend(
        quantity=quantity,
        series=series,
        direction=direction,
        v_m_s=v_m_s,
        dwell_s=dwell_s,
        distance_m=tuple(x.tolist()),
        values=tuple(y.tolist()),
        slope=line.slope,
        slope_ci95=line.half,
        intercept=line.intercept,
        p=line.p,
        p_holm=line.p,
        last_from_m=float(x[last][0]),
        last_mean=mean,
        last_change=change,
        last_change_ci95=half,
        verdict=verdict,
        kind=kind,
    )
