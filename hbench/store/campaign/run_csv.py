"""A run in SI as a CSV file with a named column per channel: the layout of imported runs."""

from collections.abc import Iterator, Mapping
from dataclasses import fields
from typing import Any

import numpy as np

from hbench.channels import CHANNELS
from hbench.config.import_layout import ALWAYS, LEAST, LIMITS, LONGEST_S, Format
from hbench.errors import DataError
from hbench.records import RUN_FLAGS, Run, RunPlan
from hbench.store.files.number_columns import formatted_rows
from hbench.store.formats.table import Table
from hbench.store.formats.text import parse_table

RUN_CHANNELS = tuple(f.name for f in fields(Run) if f.name in CHANNELS)
# Tolerance between a logged reference and the plan's: a count of 1e-5 m/s, or 0.1 %.
_SAME_SPEED_M_S, _SAME_SPEED = 1e-5, 1e-3
SEVERAL_RUNS = (
    "If the file contains several runs, write each to a file of its own; if its clock wraps or "
    "was set back, as at the end of summer time, make the times rise: hbench/store/README.md has "
    "recipes."
)


def format_run(channels: Mapping[str, np.ndarray]) -> Iterator[bytes]:
    """Yield ``channels``, each (n,), as CSV from which the same floats are read."""
    yield f"{','.join(channels)}\n".encode()
    yield from formatted_rows(tuple(channels.values()))


def read_channels(table: Table) -> tuple[dict[str, np.ndarray], tuple[str, ...]]:
    """Return the known channels of a table in SI, and the names of its other columns.

    Empty cells are NaN. Raises ``DataError`` naming the line: for short lines, cells that are not
    numbers, for time that does not increase, for gaps in ``t_s`` or ``x_m``, and if one of these is
    missing.
    """
    check_complete(table)
    for name in ALWAYS:
        table.position(name)
    known = [name for name in table.names if name in CHANNELS or name in RUN_FLAGS]
    table.prefetch(known)
    channels = {name: table.numbers(name, gaps=name not in ALWAYS) for name in known}
    check_lengths(channels, table)
    check_limits(channels, table)
    _check_flags(channels, table)
    check_time(channels["t_s"], table)
    return channels, tuple(name for name in table.names if name not in channels)


def check_complete(table: Table) -> None:
    """Raise ``DataError`` naming the first line that was left out since cells are missing."""
    for line in table.short_lines:
        raise DataError(
            f"{table.source}: line {line}: found fewer columns than in the header; expected "
            f"{len(table.names)}"
        )


def check_lengths(channels: Mapping[str, np.ndarray], table: Table) -> None:
    """Raise ``DataError`` unless all channels have as many samples as the time."""
    n = len(channels["t_s"])
    if n == 0:
        raise DataError(f"{table.source}: contains no samples")
    for name, values in channels.items():
        if len(values) != n:
            raise DataError(
                f"{table.source}: {name} has {len(values)} samples and t_s has {n}",
                "In a map, state the column of its own times with 'time'; otherwise resample the "
                "channels to one time base first.",
            )


def check_limits(channels: Mapping[str, np.ndarray], table: Table) -> None:
    """Raise ``DataError`` naming the line of a value beyond any physical range."""
    for name, (unit, *_) in CHANNELS.items():
        values = channels.get(name, np.zeros(0))
        least = LEAST.get(unit, -LIMITS[unit])
        beyond = np.flatnonzero((values > LIMITS[unit]) | (values < least))
        if len(beyond):
            row = beyond[0]
            limit = LIMITS[unit] if values[row] > LIMITS[unit] else LEAST.get(unit, LIMITS[unit])
            raise DataError(
                f"{table.source}: {table.where(row)}: {name} is {values[row]:.6g} {unit}; "
                f"limit {limit:g} {unit}",
                "Check the unit.",
            )


def _check_flags(channels: Mapping[str, np.ndarray], table: Table) -> None:
    """Raise ``DataError`` naming the line of a flag that is not between 0 and 1, a mean of both."""
    for name in RUN_FLAGS:
        values = channels.get(name, np.zeros(0))
        beyond = np.flatnonzero((values < 0) | (values > 1))
        if len(beyond):
            row = beyond[0]
            raise DataError(
                f"{table.source}: {table.where(row)}: {name} is {values[row]:.6g}; expected 0 or 1"
            )


def _hint_on_time(t_s: np.ndarray, row: int, hint: str) -> str:
    if t_s[row] == t_s[row - 1]:
        return hint
    newest_first = row == 1 and bool(np.all(np.diff(t_s) <= 0))
    return "The rows are in reverse order: sort them by time." if newest_first else SEVERAL_RUNS


def check_time(
    t_s: np.ndarray, table: Table, rows: np.ndarray | None = None, hint: str = ""
) -> None:
    """Raise ``DataError`` naming the line at which time does not increase.

    ``rows`` (n,) are the samples' rows in the table, if some were dropped; ``hint`` is given for
    equal times.
    """
    stuck = np.flatnonzero(np.diff(t_s) <= 0)
    if len(stuck):
        row = stuck[0] + 1
        position = table.where(row if rows is None else rows[row])
        raise DataError(
            f"{table.source}: {position}: time goes from {t_s[row - 1]:.6g} s to {t_s[row]:.6g} s; "
            "expected increasing time",
            _hint_on_time(t_s, row, hint),
        )
    if t_s[-1] - t_s[0] > LONGEST_S:
        raise DataError(
            f"{table.source}: lasts {t_s[-1] - t_s[0]:.6g} s; limit {LONGEST_S:g} s",
            "Check the unit of time.",
        )


def parse_run(data: bytes, plan: RunPlan, source: str) -> Run:
    """Return the run in a CSV in SI. Raises ``DataError``."""
    channels, _ = read_channels(parse_table(data, source, Format()))
    return run_of(channels, plan)


def run_of(channels: Mapping[str, np.ndarray], plan: RunPlan) -> Run:
    """Return the run with ``channels``, each (n,) in SI.

    Samples at the reference speed are marked by ``at_reference``, or else by a logged reference.
    """
    run: dict[str, Any] = {
        name: values for name, values in channels.items() if name in RUN_CHANNELS
    }
    run |= {name: channels[name] > 0 for name in RUN_FLAGS if name in channels}
    if "at_reference" not in run and (v_ref := run.get("v_ref_m_s")) is not None:
        margin = max(_SAME_SPEED_M_S, _SAME_SPEED * abs(plan.v_ref_m_s))
        run["at_reference"] = np.abs(v_ref - plan.v_ref_m_s) <= margin
    return Run(plan=plan, **run)
