"""What a fleet's table shows: read a column at a time, so that a million rows are no burden."""

import os
import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from hbench.analysis.comparison.population import FEWEST, Line, Standing, histogram, line, standing
from hbench.analysis.statistics.holm import holm
from hbench.analysis.uncertainty.budget import NORMAL_95
from hbench.records import (
    QUANTITIES,
    Block,
    Deviation,
    Direction,
    Fleet,
    Quantity,
    Spread,
    Suspect,
    Trend,
)
from hbench.store.fleet.table import TABLE, FleetTable, column_of, moment_of

_NAMED = 20  # campaigns that are named: of the worst, and of those that failed
_WORDS = 10  # of reasons and protocols
_SINGLE = 150  # campaigns that are drawn one by one; more are drawn in blocks
_BLOCKS = 60
_DAY_S = 86_400.0
_DIGITS = re.compile(r"\d+")


@dataclass(frozen=True)
class _Number:
    """One number of those judged campaigns that have it."""

    quantity: Quantity
    direction: Direction
    rows: np.ndarray  # (n,) of the table
    at: np.ndarray  # (n,)
    x: np.ndarray  # (n,)
    se: np.ndarray  # (n,)


def summarize(folder: Path) -> Fleet:
    """Return what the table in ``folder`` shows."""
    table = FleetTable(folder / TABLE)
    good = table.where("failed", "")
    protocols = [pair for pair in table.counts("protocol") if pair[0]]
    judged = good & table.where("protocol", protocols[0][0] if protocols else "")
    moments = table.moments()
    known = moments[judged]
    by_date = len(known) > 0 and bool(np.isfinite(known).all()) and bool(np.ptp(known) > 0)
    first, last = (float(known.min()), float(known.max())) if by_date else (0.0, 0.0)
    at = (moments - first) / _DAY_S if by_date else np.cumsum(judged).astype(float)

    lines = [line(one.at, one.x) for one in _numbers(table, judged, at)]
    sizes = [len(one.x) for one in _numbers(table, judged, at)]
    p_values = iter(holm([found.p for found in lines if found is not None]))
    worst: dict[int, list[Deviation]] = defaultdict(list)
    outlier = np.zeros(table.rows, dtype=bool)
    spreads: list[Spread] = []
    for one, found in zip(_numbers(table, judged, at), lines, strict=True):
        trend = None if found is None else _trend(one, found, float(next(p_values)))
        centre = _centre(one, found, trend)
        stands = standing(one.x, one.se, centre)
        spreads.append(_spread(one, stands, trend))
        if len(one.x) < FEWEST:
            continue
        p = np.minimum(sum(sizes) * stands.p, 1.0)
        outlier[one.rows] |= p < 0.05
        for i in np.argsort(-np.abs(stands.z), kind="stable")[:_NAMED]:
            x, m, z = float(one.x[i]), float(centre[i]), float(stands.z[i])
            deviation = Deviation(one.quantity, one.direction, x, m, z, float(p[i]))
            worst[int(one.rows[i])].append(deviation)
    failures = np.flatnonzero(~good)[:_NAMED]
    return Fleet(
        campaigns=table.rows,
        failed=int((~good).sum()),
        reasons=tuple(_kinds_of_failure(table)),
        failures=tuple(
            zip(table.words("path", failures), table.words("failed", failures), strict=True)
        ),
        qualities=tuple(pair for pair in table.counts("quality") if pair[0]),
        sources=tuple(pair for pair in table.counts("source") if pair[0]),
        protocols=tuple(protocols[:_WORDS]),
        judged=int(judged.sum()),
        by_date=by_date,
        first=moment_of(first) if by_date else None,
        last=moment_of(last) if by_date else None,
        spreads=tuple(spreads),
        outliers=int(outlier.sum()),
        worst=tuple(_suspects(folder, table, worst)),
    )


def _numbers(table: FleetTable, judged: np.ndarray, at: np.ndarray) -> Iterator[_Number]:
    directions: tuple[Direction, ...] = ("extend", "retract")
    for quantity in QUANTITIES:
        for direction in directions:
            name = column_of(quantity.name, direction)
            x = table.numbers(name)
            rows = np.flatnonzero(judged & np.isfinite(x))
            if len(rows):
                se = table.numbers(f"{name}_se")[rows]
                yield _Number(quantity, direction, rows, at[rows], x[rows], se)


def _trend(one: _Number, found: Line, p_holm: float) -> Trend:
    span = float(np.ptp(one.at))
    start = found.intercept + found.slope * float(one.at.min())
    return Trend(found.slope * span, found.low * span, found.high * span, start, p_holm)


def _centre(one: _Number, found: Line | None, trend: Trend | None) -> np.ndarray:
    if found is not None and trend is not None and trend.real:
        return found.intercept + found.slope * one.at
    return np.full(len(one.x), np.median(one.x))


def _spread(one: _Number, stands: Standing, trend: Trend | None) -> Spread:
    own = float(np.median(stands.own))
    low, median, high = map(float, np.percentile(one.x, [5, 50, 95]))
    edges, counts, below, above = histogram(one.x)
    return Spread(
        quantity=one.quantity,
        direction=one.direction,
        n=len(one.x),
        median=median,
        between=stands.between,
        own=own or None,
        low=low,
        high=high,
        edges=tuple(edges.tolist()),
        counts=tuple(counts.tolist()),
        below=below,
        above=above,
        blocks=tuple(_blocks(one)),
        trend=trend,
    )


def _blocks(one: _Number) -> Iterator[Block]:
    order = np.argsort(one.at, kind="stable")
    if len(order) <= _SINGLE:
        half = NORMAL_95 * np.nan_to_num(one.se, nan=0.0, posinf=0.0)
        for i in order:
            x = float(one.x[i])
            yield Block(float(one.at[i]), 1, x, x - float(half[i]), x + float(half[i]))
        return
    for part in np.array_split(order, _BLOCKS):
        low, median, high = map(float, np.percentile(one.x[part], [5, 50, 95]))
        yield Block(float(one.at[part].mean()), len(part), median, low, high)


def _suspects(
    folder: Path, table: FleetTable, worst: dict[int, list[Deviation]]
) -> Iterator[Suspect]:
    for found in worst.values():
        found.sort(key=lambda one: -abs(one.z))
    rows = sorted(worst, key=lambda row: (-abs(worst[row][0].z), row))[:_NAMED]
    told: dict[str, list[Any]] = {
        name: table.words(name, np.array(rows, dtype=int))
        for name in ("path", "name", "started", "quality")
    }
    for i, row in enumerate(rows):
        path, name, started, quality = (told[key][i] for key in told)
        page = _report_of(folder, path)
        yield Suspect(path, name, started, quality, page, tuple(worst[row]))


def _report_of(folder: Path, campaign: str) -> str:
    """Return the link from the fleet's page to a campaign's report; empty where there is none."""
    report = Path(campaign) / "results" / "report.html"
    if not os.path.isfile(report):
        return ""
    try:
        return quote(Path(os.path.relpath(report, folder.resolve())).as_posix())
    except ValueError:  # another drive
        return ""


def _kinds_of_failure(table: FleetTable) -> Iterator[tuple[str, int]]:
    """Yield reasons without their numbers, and how many have each."""
    counted: dict[str, int] = defaultdict(int)
    for words, count in table.counts("failed"):
        if words:
            counted[_DIGITS.sub("…", words)] += count
    yield from sorted(counted.items(), key=lambda pair: (-pair[1], pair[0]))[:_WORDS]
