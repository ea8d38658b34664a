"""Spread of each number over the campaigns of a fleet: distribution, trend and deviations."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from hbench.analysis.fleet.population import (
    RobustDeviations,
    TrendLine,
    histogram,
    outlier_limit,
    robust_deviations,
    trend_line,
)
from hbench.analysis.fleet.times import Times
from hbench.analysis.statistics.holm import holm
from hbench.records import (
    FEWEST_CAMPAIGNS,
    QUANTITIES,
    Block,
    ChartStep,
    ControlChart,
    Deviation,
    Quantity,
    Side,
    Spread,
    Trend,
)
from hbench.records.numbers import NORMAL_95, SIGNIFICANCE
from hbench.store.fleet.table import FleetTable

LISTED = 20  # most deviating campaigns
_SINGLE = 150  # campaigns that are drawn one by one; more are drawn in blocks
_BLOCKS = 60


@dataclass(frozen=True)
class _Sample:
    """Values of one quantity and direction over the compared campaigns."""

    quantity: Quantity
    direction: Side
    rows: np.ndarray  # (n,) of the table
    at: np.ndarray  # (n,) days since the first campaign, or number in the order of paths
    x: np.ndarray  # (n,)
    se: np.ndarray  # (n,)


def number_spreads(
    table: FleetTable, compared: np.ndarray, times: Times, charts: Sequence[ControlChart]
) -> tuple[tuple[Spread, ...], dict[int, list[Deviation]], int]:
    """Return the spread of each number, the largest deviations by row, and the count of outliers.

    The p-values of trends are corrected for the number of trends (Holm), those of deviations for
    the number of all compared values (Bonferroni). The samples are made twice rather than kept:
    a fleet may be large.
    """
    fits = [(trend_line(s.at, s.x), len(s.x)) for s in _samples(table, compared, times.at)]
    tests = sum(n for _, n in fits)
    p_of_trends = iter(holm([line.p for line, _ in fits if line is not None]))
    steps = _real_steps(charts)
    spreads: list[Spread] = []
    largest: dict[int, list[Deviation]] = defaultdict(list)
    is_outlier = np.zeros(table.rows, dtype=bool)
    for sample, (line, n) in zip(_samples(table, compared, times.at), fits, strict=True):
        trend = None if line is None else _trend(sample, line, float(next(p_of_trends)))
        step = steps.get((sample.quantity, sample.direction))
        centre = _centre(sample, line, trend, None if step is None else times.days >= step.at)
        robust = robust_deviations(sample.x, sample.se, centre)
        spreads.append(_spread(sample, robust, trend))
        if n < FEWEST_CAMPAIGNS:
            continue
        p = np.minimum(tests * robust.p, 1.0)
        is_outlier[sample.rows] |= p < SIGNIFICANCE
        limit = outlier_limit(n, tests)
        for i in np.argsort(-np.abs(robust.z), kind="stable")[:LISTED]:
            x, median, z = float(sample.x[i]), float(centre[i]), float(robust.z[i])
            number = sample.quantity, sample.direction
            largest[int(sample.rows[i])].append(
                Deviation(*number, x, median, z, float(p[i]), limit)
            )
    return tuple(spreads), largest, int(is_outlier.sum())


def _real_steps(charts: Sequence[ControlChart]) -> dict[tuple[Quantity, Side], ChartStep]:
    """Return the significant steps of the mean, which is that of all cylinders."""
    return {
        (chart.quantity, chart.direction): chart.step
        for chart in charts
        if chart.step is not None and chart.step.real and not chart.of_cylinders
    }


def _samples(table: FleetTable, compared: np.ndarray, at: np.ndarray) -> Iterator[_Sample]:
    for quantity in QUANTITIES:
        for direction in quantity.sides:
            name = quantity.column(direction)
            x = table.numbers(name)
            rows = np.flatnonzero(compared & np.isfinite(x))
            if len(rows):
                se = table.numbers(f"{name}_se")[rows]
                yield _Sample(quantity, direction, rows, at[rows], x[rows], se)


def _trend(sample: _Sample, line: TrendLine, p_holm: float) -> Trend:
    span = float(np.ptp(sample.at))
    start = line.intercept + line.slope * float(sample.at.min())
    return Trend(line.slope * span, line.low * span, line.high * span, start, p_holm)


def _centre(
    sample: _Sample, line: TrendLine | None, trend: Trend | None, after: np.ndarray | None
) -> np.ndarray:
    """Return the value that each campaign (n,) is compared with.

    It is the median of the campaigns before or ``after`` (rows,) a step of the mean, the trend's
    line, or the median of all.
    """
    if after is not None and not (later := after[sample.rows]).all():
        return np.where(later, np.median(sample.x[later]), np.median(sample.x[~later]))
    if line is not None and trend is not None and trend.real:
        return line.intercept + line.slope * sample.at
    return np.full(len(sample.x), np.median(sample.x))


def _spread(sample: _Sample, deviations: RobustDeviations, trend: Trend | None) -> Spread:
    within = float(np.median(deviations.within))
    ends = [0, 50, 100] if len(sample.x) < FEWEST_CAMPAIGNS else [5, 50, 95]
    low, median, high = map(float, np.percentile(sample.x, ends))
    edges, counts, below, above = histogram(sample.x)
    return Spread(
        quantity=sample.quantity,
        direction=sample.direction,
        n=len(sample.x),
        median=median,
        between=deviations.between,
        between_low=deviations.between_low,
        between_high=deviations.between_high,
        se_trials=within or None,
        low=low,
        high=high,
        edges=tuple(edges.tolist()),
        counts=tuple(counts.tolist()),
        below=below,
        above=above,
        blocks=tuple(_blocks(sample)),
        trend=trend,
    )


def _blocks(sample: _Sample) -> Iterator[Block]:
    order = np.argsort(sample.at, kind="stable")
    if len(order) <= _SINGLE:
        half = NORMAL_95 * np.nan_to_num(sample.se, nan=0.0, posinf=0.0)
        for i in order:
            x = float(sample.x[i])
            yield Block(float(sample.at[i]), 1, x, x - float(half[i]), x + float(half[i]))
        return
    for group in np.array_split(order, _BLOCKS):
        low, median, high = map(float, np.percentile(sample.x[group], [5, 50, 95]))
        yield Block(float(sample.at[group].mean()), len(group), median, low, high)
