"""Rod-side pressure of the load cylinder, as a mark of series that differ in nothing else."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import replace
from typing import TypeVar

from hbench.records.flow import Band, Curve, EfficiencyCurve, RunPlan
from hbench.records.summary import HeadlineSeries

SeriesRecord = TypeVar("SeriesRecord", Band, Curve, EfficiencyCurve, RunPlan, HeadlineSeries)


def differs_in_rod_pressure(series: Iterable[SeriesRecord]) -> bool:
    """Return whether one kind, label, direction and load was measured at several pressures."""
    pressures = defaultdict(set)
    for each in series:
        direction = None if isinstance(each, Band) else each.direction
        acceleration = None if isinstance(each, Band) else each.a_ref_m_s2
        key = each.kind, each.label, direction, each.f_load_n, acceleration
        pressures[key].add(each.p_lr_ref_pa)
    return any(len(values) > 1 for values in pressures.values())


def without_common_rod_pressure(series: Iterable[SeriesRecord]) -> tuple[SeriesRecord, ...]:
    """Return ``series`` with ``p_lr_ref_pa`` None in all of them, unless they differ in it."""
    series = tuple(series)
    return series if differs_in_rod_pressure(series) else without_rod_pressure(series)


def without_rod_pressure(series: Iterable[SeriesRecord]) -> tuple[SeriesRecord, ...]:
    """Return ``series`` with ``p_lr_ref_pa`` None."""
    return tuple(replace(each, p_lr_ref_pa=None) for each in series)
