"""Summary of a fleet's table: spreads, trends, outliers and reasons of failure.

The table is read one column at a time, so that a million rows fit into memory.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hbench.analysis.comparison.capability import capabilities, without_capability
from hbench.analysis.comparison.measurement_system import measurement_system
from hbench.analysis.comparison.population import (
    RobustDeviations,
    TrendLine,
    histogram,
    outlier_limit,
    robust_deviations,
    trend_line,
)
from hbench.analysis.comparison.precision import Tolerance
from hbench.analysis.statistics.holm import holm
from hbench.motion.reversals import SAME_STROKE_SPEED
from hbench.records import (
    FEWEST_CAMPAIGNS,
    QUANTITIES,
    Block,
    Deviation,
    Fleet,
    FleetCampaign,
    FleetNumber,
    Quantity,
    Side,
    Spread,
    Suspect,
    Trend,
)
from hbench.records.conformity.acceptance import ConformityCheck, Requirement
from hbench.records.numbers import NORMAL_95
from hbench.store.fleet.table import SUFFIXES, FleetTable, moment_of

_LISTED = 20  # campaigns: of the most deviating, and of the failed ones
_MOST_KINDS = 10  # of reasons and protocols
_MOST_ROWS = 500  # campaigns of a fleet that are listed one by one
_SINGLE = 150  # campaigns that are drawn one by one; more are drawn in blocks
_BLOCKS = 60
_DAY_S = 86_400.0
_ENDINGS = [f"_{suffix}" for suffix in SUFFIXES]
_DIGITS = re.compile(r"\d+")


@dataclass(frozen=True)
class _Sample:
    """Values of one quantity and direction over the compared campaigns."""

    quantity: Quantity
    direction: Side
    rows: np.ndarray  # (n,) of the table
    at: np.ndarray  # (n,) days since the first campaign, or number in the order of paths
    x: np.ndarray  # (n,)
    se: np.ndarray  # (n,)


def _no_decision(path: str) -> str:
    return ""


def _no_checks(path: str) -> Sequence[ConformityCheck]:
    return ()


def summarize(
    table: FleetTable,
    report_link: Callable[[str], str],
    tolerance: Tolerance | None = None,
    requirements: Sequence[Requirement] = (),
    decision: Callable[[str], str] = _no_decision,
    checks: Callable[[str], Sequence[ConformityCheck]] = _no_checks,
) -> Fleet:
    """Return the summary of a fleet's table.

    ``tolerance`` is that of friction or efficiency, ``requirements`` are limits. ``report_link``
    returns the link to the report of the campaign at a path, ``decision`` and ``checks`` those of
    its last acceptance; all may be empty.
    """
    good = table.equals("failed", "")
    protocols = [pair for pair in table.counts("protocol") if pair[0]]
    of_protocol = good & table.equals("protocol", protocols[0][0] if protocols else "")
    compared = of_protocol & _at_common_speed(table.numbers("v_m_s"), of_protocol)
    moments = table.moments()
    known = moments[compared]
    by_date = len(known) > 0 and bool(np.isfinite(known).all()) and bool(np.ptp(known) > 0)
    first, last = (float(known.min()), float(known.max())) if by_date else (0.0, 0.0)
    at = (moments - first) / _DAY_S if by_date else np.cumsum(compared).astype(float)

    days = (moments - np.min(known, initial=np.inf, where=np.isfinite(known))) / _DAY_S
    system = measurement_system(table, good, compared, days, tolerance)
    steps = {
        (chart.quantity, chart.direction): chart.step
        for chart in system.charts
        if chart.step is not None and chart.step.real and not chart.of_cylinders
    }
    lines = [trend_line(sample.at, sample.x) for sample in _samples(table, compared, at)]
    sizes = [len(sample.x) for sample in _samples(table, compared, at)]
    p_values = iter(holm([line.p for line in lines if line is not None]))
    worst: dict[int, list[Deviation]] = defaultdict(list)
    outlier = np.zeros(table.rows, dtype=bool)
    spreads: list[Spread] = []
    for sample, line in zip(_samples(table, compared, at), lines, strict=True):
        trend = None if line is None else _trend(sample, line, float(next(p_values)))
        step = steps.get((sample.quantity, sample.direction))
        centre = _centre(sample, line, trend, None if step is None else days >= step.at)
        deviations = robust_deviations(sample.x, sample.se, centre)
        spreads.append(_spread(sample, deviations, trend))
        if len(sample.x) < FEWEST_CAMPAIGNS:
            continue
        p = np.minimum(sum(sizes) * deviations.p, 1.0)
        limit = outlier_limit(len(sample.x), sum(sizes))
        outlier[sample.rows] |= p < 0.05
        for i in np.argsort(-np.abs(deviations.z), kind="stable")[:_LISTED]:
            x, m, z = float(sample.x[i]), float(centre[i]), float(deviations.z[i])
            deviation = Deviation(sample.quantity, sample.direction, x, m, z, float(p[i]), limit)
            worst[int(sample.rows[i])].append(deviation)
    failures = np.flatnonzero(~good)[:_LISTED]
    speeds = table.numbers("v_m_s")[compared]
    hidden = table.numbers("drift_possible")[good]
    speed = float(np.nanmedian(speeds)) if np.isfinite(speeds).any() else None

    def compared_values(quantity: Quantity, side: Side) -> np.ndarray:
        x = table.numbers(quantity.column(side))[in_order]
        return x[np.isfinite(x)]

    in_order = np.flatnonzero(compared)
    if by_date:
        in_order = in_order[np.argsort(at[in_order], kind="stable")]
    paths = table.values("path", in_order) if requirements else ()
    decided = [checks(path) for path in paths]
    decisions = Counter(map(decision, table.values("path", np.flatnonzero(good))))
    return Fleet(
        campaigns=table.rows,
        failed=int((~good).sum()),
        reasons=tuple(_kinds_of_failure(table)),
        failures=tuple(
            zip(table.values("path", failures), table.values("failed", failures), strict=True)
        ),
        qualities=tuple(pair for pair in table.counts("quality") if pair[0]),
        weak_checks=_weak_checks(table),
        drift_possible=float(np.nanmax(hidden)) if np.isfinite(hidden).any() else None,
        incomplete=int((good & ~table.equals("missing", "")).sum()),
        sources=tuple(pair for pair in table.counts("source") if pair[0]),
        protocols=tuple(protocols[:_MOST_KINDS]),
        compared=int(compared.sum()),
        other_speeds=int((of_protocol & ~compared).sum()),
        by_date=by_date,
        first=moment_of(first) if by_date else None,
        last=moment_of(last) if by_date else None,
        spreads=tuple(spreads),
        outliers=int(outlier.sum()),
        worst=tuple(_suspects(table, worst, report_link)),
        precision=system.precision,
        plan_notes=system.notes,
        charts=system.charts,
        wear=system.wear,
        capabilities=tuple(capabilities(compared_values, decided, requirements, speed, by_date)),
        without_capability=tuple(
            without_capability(decided, requirements, speed, int(compared.sum()))
        ),
        decisions=tuple(sorted((name, n) for name, n in decisions.items() if name)),
        rows=tuple(
            _campaigns(table, np.flatnonzero(good), compared, spreads, report_link, decision)
        ),
    )


def _at_common_speed(v_m_s: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Return which working speeds (rows,) are within 20 % of the median of the chosen ones.

    Set speeds are part of the protocol; speeds that were not set may differ.
    """
    known = v_m_s[chosen & np.isfinite(v_m_s)]
    if not len(known):
        return np.ones(len(v_m_s), dtype=bool)
    median = np.median(known)
    return ~(np.abs(v_m_s - median) > SAME_STROKE_SPEED * median)


def _campaigns(
    table: FleetTable,
    rows: np.ndarray,
    compared: np.ndarray,
    spreads: Sequence[Spread],
    report_link: Callable[[str], str],
    decision: Callable[[str], str],
) -> Iterator[FleetCampaign]:
    """Yield the campaigns of a small fleet with their numbers."""
    if len(rows) > _MOST_ROWS:
        return
    names = (
        "path",
        "name",
        "label",
        "quality",
        "missing",
        "v_m_s",
        "specimen",
        "started",
        "protocol",
    )
    texts = [table.values(name, rows) for name in names]
    columns = {
        name: [table.values(f"{name}{ending}", rows) for ending in ("", *_ENDINGS)]
        for name in (spread.quantity.column(spread.direction) for spread in spreads)
    }
    for i, about in enumerate(zip(*texts, strict=True)):
        path, name, label, quality, missing, v_m_s, specimen, started, protocol = about
        cells = {column: [values[i] for values in each] for column, each in columns.items()}
        numbers = {column: FleetNumber(*c) for column, c in cells.items() if c[0] is not None}
        yield FleetCampaign(
            path=path,
            compared=bool(compared[rows[i]]),
            name=name,
            label=label,
            quality=quality,
            missing=missing,
            report=report_link(path),
            decision=decision(path),
            v_m_s=v_m_s,
            numbers=numbers,
            specimen=specimen or "",
            started=started,
            protocol=protocol or "",
        )


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


def _weak_checks(table: FleetTable) -> tuple[tuple[str, int], ...]:
    """Return how many campaigns have their grade by each check of their data, most first."""
    counts: Counter[str] = Counter()
    for names, count in table.counts("weak"):
        counts.update(dict.fromkeys(filter(None, names.split(", ")), count))
    return tuple(counts.most_common())


def _suspects(
    table: FleetTable, worst: dict[int, list[Deviation]], report_link: Callable[[str], str]
) -> Iterator[Suspect]:
    for deviations in worst.values():
        deviations.sort(key=lambda deviation: -abs(deviation.z))
    rows = sorted(worst, key=lambda row: (-abs(worst[row][0].z), row))[:_LISTED]
    columns: list[list[Any]] = [
        table.values(name, np.array(rows, dtype=int))
        for name in ("path", "name", "started", "quality")
    ]
    for row, (path, name, started, quality) in zip(rows, zip(*columns, strict=True), strict=True):
        yield Suspect(path, name, started, quality, report_link(path), tuple(worst[row]))


def _kinds_of_failure(table: FleetTable) -> Iterator[tuple[str, int]]:
    """Yield the reasons of failure without their numbers, each with its frequency."""
    counted: dict[str, int] = defaultdict(int)
    for reason, count in table.counts("failed"):
        if reason:
            counted[_DIGITS.sub("…", reason)] += count
    yield from sorted(counted.items(), key=lambda pair: (-pair[1], pair[0]))[:_MOST_KINDS]
