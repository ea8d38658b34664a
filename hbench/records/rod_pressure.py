"""Key of a series of runs; the rod-side pressure of series that differ in nothing else."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from typing import TypeVar

from hbench.records.conformity.acceptance import Measurement
from hbench.records.curves import Band, BandTrend, Curve, EfficiencyCurve
from hbench.records.runs import Direction, RunPlan
from hbench.records.summary import HeadlineSeries, ImplausiblePoint, PointTrials

SeriesRecord = TypeVar(
    "SeriesRecord",
    Band,
    BandTrend,
    Curve,
    EfficiencyCurve,
    RunPlan,
    HeadlineSeries,
    ImplausiblePoint,
    PointTrials,
    Measurement,
)
SeriesKey = tuple[str, Direction | None, float | None, float | None]


def series_key(record: Curve | EfficiencyCurve | Measurement | RunPlan) -> SeriesKey:
    """Return label, direction, load F_L (N) and rod-side pressure (Pa), which make a series."""
    return record.label, record.direction, record.f_load_n, record.p_lr_ref_pa


def differs_in_rod_pressure(series: Iterable[SeriesRecord]) -> bool:
    """Return whether one kind, label, direction and load was measured at several pressures."""
    pressures = defaultdict(set)
    for each in series:
        if isinstance(each, BandTrend):
            key: tuple = each.kind, each.label
        elif isinstance(each, Band):
            key = each.kind, each.label, each.f_load_n
        elif isinstance(each, Measurement):
            key = each.label, each.direction, each.f_load_n
        else:
            key = each.kind, each.label, each.direction, each.f_load_n, each.a_ref_m_s2
        pressures[key].add(each.p_lr_ref_pa)
    return any(len(values) > 1 for values in pressures.values())


def without_common_rod_pressure(series: Iterable[SeriesRecord]) -> tuple[SeriesRecord, ...]:
    """Return ``series`` with ``p_lr_ref_pa`` None in all of them, unless they differ in it."""
    series = tuple(series)
    return series if differs_in_rod_pressure(series) else without_rod_pressure(series)


def without_rod_pressure(series: Iterable[SeriesRecord]) -> tuple[SeriesRecord, ...]:
    """Return ``series`` with ``p_lr_ref_pa`` None."""
    return tuple(replace(each, p_lr_ref_pa=None) for each in series)
