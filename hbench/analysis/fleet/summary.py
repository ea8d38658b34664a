"""Summary of a fleet's table.

The table is read one column at a time, so that a million rows fit into memory.
"""

import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hbench.analysis.fleet.capability import capabilities, without_capability
from hbench.analysis.fleet.measurement_system import measurement_system
from hbench.analysis.fleet.precision import Tolerance
from hbench.analysis.fleet.spreads import LISTED, number_spreads
from hbench.analysis.fleet.times import Times, times_of
from hbench.motion.reversals import SAME_STROKE_SPEED
from hbench.records import (
    Capability,
    Deviation,
    Fleet,
    FleetCampaign,
    FleetNumber,
    Quantity,
    Side,
    Spread,
    Suspect,
)
from hbench.records.conformity.acceptance import ConformityCheck, Requirement
from hbench.store.fleet.table import SUFFIXES, FleetTable, moment_of

_MOST_KINDS = 10  # of reasons and protocols
_MOST_ROWS = 500  # campaigns of a fleet that are listed one by one
_ENDINGS = [f"_{suffix}" for suffix in SUFFIXES]
_DIGITS = re.compile(r"\d+")


def summarize(
    table: FleetTable,
    report_link: Callable[[str], str],
    tolerance: Tolerance | None,
    requirements: Sequence[Requirement],
    decision: Callable[[str], str],
    checks: Callable[[str], Sequence[ConformityCheck]],
) -> Fleet:
    """Return the summary of a fleet's table.

    ``tolerance`` is that of friction or efficiency, ``requirements`` are limits. ``report_link``
    returns the link to the report of the campaign at a path, ``decision`` and ``checks`` those of
    its last acceptance; all may be empty.
    """
    selection = _selection(table)
    good, compared = selection.good, selection.compared
    times = times_of(table.moments(), compared)
    system = measurement_system(table, good & ~selection.copies, compared, times.days, tolerance)
    spreads, deviations, outliers = number_spreads(table, compared, times, system.charts)
    failed = np.flatnonzero(~good)[:LISTED]
    failures = zip(table.values("path", failed), table.values("failed", failed), strict=True)
    hidden = table.numbers("drift_possible")[good]
    analysed = np.flatnonzero(good)
    decisions = Counter(map(decision, table.values("path", analysed)))
    ppk, without_ppk = _capability(table, compared, times, requirements, checks)
    return Fleet(
        campaigns=table.rows,
        failed=int((~good).sum()),
        reasons=tuple(_kinds_of_failure(table)),
        failures=tuple(failures),
        qualities=tuple(pair for pair in table.counts("quality") if pair[0]),
        weak_checks=_weak_checks(table),
        drift_possible=float(np.nanmax(hidden)) if np.isfinite(hidden).any() else None,
        incomplete=int((good & ~table.equals("missing", "")).sum()),
        sources=tuple(pair for pair in table.counts("source") if pair[0]),
        protocols=selection.protocols[:_MOST_KINDS],
        compared=int(compared.sum()),
        other_speeds=int((selection.of_protocol & ~compared & ~selection.copies).sum()),
        copies=int(selection.copies.sum()),
        by_date=times.by_date,
        first=moment_of(times.first) if times.by_date else None,
        last=moment_of(times.last) if times.by_date else None,
        spreads=spreads,
        outliers=outliers,
        worst=tuple(_suspects(table, deviations, report_link)),
        precision=system.precision,
        plan_notes=system.notes,
        charts=system.charts,
        wear=system.wear,
        capabilities=ppk,
        without_capability=without_ppk,
        decisions=tuple(sorted((name, n) for name, n in decisions.items() if name)),
        rows=tuple(
            sorted(
                _campaigns(table, analysed, selection, spreads, report_link, decision),
                key=lambda campaign: _by_number(campaign.path),
            )
        ),
    )


def _by_number(path: str) -> list[str | int]:
    """Return the key that sorts numbers in names by their value: 2 before 10."""
    pieces = re.split(r"(\d+)", path)
    return [int(piece) if at % 2 else piece for at, piece in enumerate(pieces)]


@dataclass(frozen=True)
class _Selection:
    """Campaigns by their part in the comparison; arrays (rows,) of bool."""

    protocols: tuple[tuple[str, int], ...]  # with their numbers of campaigns, most frequent first
    good: np.ndarray  # analysed without a fault
    of_protocol: np.ndarray  # of the most frequent protocol
    compared: np.ndarray  # of these, at the common working speed, each measurement once
    original: np.ndarray  # int: row of the first campaign with the same logs, itself if unique

    @property
    def copies(self) -> np.ndarray:
        """Campaigns whose logs are those of one above: no measurement of their own."""
        return self.original != np.arange(len(self.original))


def _selection(table: FleetTable) -> _Selection:
    good = table.equals("failed", "")
    protocols = tuple(pair for pair in table.counts("protocol") if pair[0])
    of_protocol = good & table.equals("protocol", protocols[0][0] if protocols else "")
    original = _first_with_the_same_logs(table, good)
    measured_once = of_protocol & (original == np.arange(len(original)))
    compared = measured_once & _at_common_speed(table.numbers("v_m_s"), measured_once)
    return _Selection(protocols, good, of_protocol, compared, original)


def _first_with_the_same_logs(table: FleetTable, good: np.ndarray) -> np.ndarray:
    """Return the first analysed row with the logs of each row (rows,)."""
    original = np.arange(len(good))
    first: dict[str, int] = {}
    for row, logs in enumerate(table.column("logs_sha256").to_pylist()):
        if logs and good[row]:
            original[row] = first.setdefault(logs, row)
    return original


def _at_common_speed(v_m_s: np.ndarray, chosen: np.ndarray) -> np.ndarray:
    """Return which working speeds (rows,) are within 20 % of the median of the chosen ones.

    Set speeds are part of the protocol; speeds that were not set may differ.
    """
    known = v_m_s[chosen & np.isfinite(v_m_s)]
    if not len(known):
        return np.ones(len(v_m_s), dtype=bool)
    median = np.median(known)
    return ~(np.abs(v_m_s - median) > SAME_STROKE_SPEED * median)


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
    rows = sorted(worst, key=lambda row: (-abs(worst[row][0].z), row))[:LISTED]
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


def _capability(
    table: FleetTable,
    compared: np.ndarray,
    times: Times,
    requirements: Sequence[Requirement],
    checks: Callable[[str], Sequence[ConformityCheck]],
) -> tuple[tuple[Capability, ...], tuple[tuple[Requirement, str], ...]]:
    """Return the capability of each limited quantity, and the limits without one with a reason."""
    in_order = np.flatnonzero(compared)
    if times.by_date:
        in_order = in_order[np.argsort(times.at[in_order], kind="stable")]

    def compared_values(quantity: Quantity, side: Side) -> np.ndarray:
        x = table.numbers(quantity.column(side))[in_order]
        return x[np.isfinite(x)]

    speeds = table.numbers("v_m_s")[compared]
    speed = float(np.nanmedian(speeds)) if np.isfinite(speeds).any() else None
    decided = [checks(path) for path in table.values("path", in_order)] if requirements else []
    return (
        tuple(capabilities(compared_values, decided, requirements, speed, times.by_date)),
        tuple(without_capability(decided, requirements, speed, len(in_order))),
    )


def _campaigns(
    table: FleetTable,
    rows: np.ndarray,
    selection: _Selection,
    spreads: Sequence[Spread],
    report_link: Callable[[str], str],
    decision: Callable[[str], str],
) -> Iterator[FleetCampaign]:
    """Yield the campaigns of a small fleet with their numbers."""
    if len(rows) > _MOST_ROWS:
        return
    names = "path name label quality missing v_m_s specimen started protocol".split()
    texts = [table.values(name, rows) for name in names]
    originals = table.values("path", selection.original[rows])
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
            compared=bool(selection.compared[rows[i]]),
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
            copy_of=originals[i] if selection.copies[rows[i]] else "",
        )
