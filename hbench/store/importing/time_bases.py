"""Time bases of a file: the channels of an import map, grouped by their times."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from hbench.config.import_layout import DATE_TIME, Column
from hbench.config.import_map import ImportMap
from hbench.errors import DataError
from hbench.store.campaign.run_csv import check_lengths, check_limits, check_time
from hbench.store.files.number_columns import rounded_to_decimals
from hbench.store.formats.date_times import on_date, utc
from hbench.store.formats.table import Table
from hbench.store.formats.text import TextTable
from hbench.store.importing.file_notes import FileNote
from hbench.store.importing.plausibility import ATMOSPHERE, is_absolute_pressure
from hbench.units import UNITS, parse_unit, to_si, unit_in

_IN_BRACKETS = re.compile(r"[(\[]\s*([^()\[\]]{1,20}?)\s*[)\]]\s*$")


@dataclass(frozen=True)
class TimeBase:
    """Channels in SI with the same times."""

    t_s: np.ndarray  # (n,) increasing
    channels: dict[str, np.ndarray]  # (n,) each, without t_s
    rows: np.ndarray  # (n,) row of each sample in the table, from 0
    clipped: np.ndarray  # (n,) True where a sensor is at a limit of its converter


def read_time_bases(
    table: Table, name: str, rules: ImportMap
) -> tuple[list[TimeBase], datetime | None, list[FileNote]]:
    """Return the time bases of a file, that of ``x_m`` first, and notes on omitted rows.

    In between is the date-time of ``t_s = 0``; None if the file does not state it. Raises
    ``DataError`` naming the invalid line.
    """
    table.prefetch(_columns_of_numbers(rules))
    times, origin = _times(table, rules)
    groups: list[tuple[np.ndarray, dict[str, np.ndarray]]] = []
    for key, t_s in times.items():
        values = _in_si(table, key, rules.columns[key], rules, gaps=True)
        check_lengths({"t_s": t_s, key: values}, table)
        for other, channels in groups:
            if np.array_equal(other, t_s, equal_nan=True):
                channels[key] = values
                break
        else:
            groups.append((t_s, {key: values}))
    omitted: set[int] = set(table.short_lines)
    bases, notes = [], []
    for t_s, channels in groups:
        check_limits({"t_s": t_s, **channels}, table)
        rows = np.flatnonzero(_complete(table, t_s, channels, omitted))
        if not len(rows):
            raise DataError(f"{table.source}: {', '.join(channels)}: no samples")
        kept = {key: values[rows] for key, values in channels.items()}
        base = TimeBase(t_s[rows], kept, rows, np.zeros(len(rows), dtype=bool))
        base, repeats = _without_repeats(base, name, rules)
        hint = "If the clock is too coarse, write 'repeated_times: drop' in the map."
        check_time(base.t_s, table, base.rows, hint)
        bases.append(base)
        notes += repeats
    bases.sort(key=lambda base: "x_m" not in base.channels)
    return bases, origin, [*_omissions(name, omitted), *notes]


def _columns_of_numbers(rules: ImportMap) -> Iterator[int | str]:
    times = rules.columns.get("t_s")
    for column in rules.columns.values():
        if column.unit != DATE_TIME:
            yield column.column
        if column.time is not None and times is not None and times.unit != DATE_TIME:
            yield column.time


def _times(table: Table, rules: ImportMap) -> tuple[dict[str, np.ndarray], datetime | None]:
    """Return the times [s] of each channel's samples from a common instant, and that instant.

    The instant is known of date-times, and of a file's own times if it states their start.
    """
    keys = [key for key in rules.columns if key != "t_s"]
    default = rules.columns.get("t_s")
    if default is None:
        own = dict(_own_times(table, {key: rules.columns[key] for key in keys}))
        return own, table.started
    sources = {key: rules.columns[key].time or default.column for key in keys}
    gaps = table.leaves_out_rows or any(rules.columns[key].time for key in keys)
    columns = {
        source: default.model_copy(update={"column": source}) for source in set(sources.values())
    }
    instant = None
    if default.unit == DATE_TIME:
        stamps = {source: table.date_times(source, gaps=gaps) for source in columns}
        known = [stamp[~np.isnat(stamp)] for stamp in stamps.values()]
        origin = min((stamp[0] for stamp in known if len(stamp)), default=np.datetime64(0, "s"))
        instant = on_date(utc(origin), rules.test.date)
        seconds = {
            source: (stamp - origin) / np.timedelta64(1, "ns") * 1e-9
            for source, stamp in stamps.items()
        }
    else:
        seconds = {
            source: _in_si(table, "t_s", column, rules, gaps=gaps)
            for source, column in columns.items()
        }
    return {key: seconds[source] for key, source in sources.items()}, instant


def _own_times(table: Table, columns: Mapping[str, Column]) -> Iterator[tuple[str, np.ndarray]]:
    for key, column in columns.items():
        times = table.own_times(column.column)
        if times is None:
            raise DataError(
                f"{table.source}: column {column.column}: the file states no times for it",
                "Add columns.t_s to the map.",
            )
        yield key, times


def _in_si(table: Table, name: str, column: Column, rules: ImportMap, *, gaps: bool) -> np.ndarray:
    unit = column_unit(table, name, column, rules)
    _refuse_absolute(table, name, column)
    numbers = table.numbers(column.column, gaps=gaps)
    factor, zero = parse_unit(unit).factor * column.scale, parse_unit(unit).zero
    as_it_is = factor == 1 and zero == 0
    with np.errstate(over="ignore"):  # check_limits refuses infinity
        values = numbers if as_it_is else rounded_to_decimals(numbers * factor + zero)
    if name == "f_applied_n" and rules.load_cell is not None:  # C.6
        values = (values - rules.load_cell.level) / rules.load_cell.volts_per_newton
    return values if column.offset is None else values + to_si(column.offset, rules.unit(name))


def _refuse_absolute(table: Table, name: str, column: Column) -> None:
    """Raise ``DataError`` for an absolute pressure of which no atmosphere is subtracted."""
    known = (column.offset is not None) or column.zero == "rest"
    stated = table.unit(column.column) or ""
    if not known and is_absolute_pressure(name, _name(table, column.column), stated):
        raise DataError(
            f"{table.source}: column {column.column}: is an absolute pressure by its name or unit; "
            f"{name} is the pressure above the atmosphere",
            f"Write 'offset: -{ATMOSPHERE}' at columns.{name} in the map; 'offset: 0 bar' if it is "
            "not absolute.",
        )


def column_unit(table: Table, name: str, column: Column, rules: ImportMap) -> str:
    """Return a column's unit: the map's, the file's own, or SI. Raises ``DataError``."""
    wanted, in_file = rules.wanted(name), table.unit(column.column)
    if in_file is None and column.scale in (1.0, -1.0):  # another scale converts units
        in_file = _unit_in_name(_name(table, column.column))
    if in_file is None:
        return column.unit or wanted
    where = f"{table.source}: column {column.column}: unit in the file is {in_file!r}"
    spelled = unit_in(in_file) or in_file  # such as bar for Bar or bar(g)
    try:
        unit = parse_unit(spelled) if spelled else None
    except ValueError:
        unit = None
    if column.unit is not None:
        if unit and column.unit != DATE_TIME and unit != parse_unit(column.unit):
            if unit.dimension == parse_unit(column.unit).dimension:
                raise DataError(f"{where}; unit in the map is {column.unit!r}")
            if column.scale in (1.0, -1.0):  # another scale converts a signal
                hint = _scale_hint(name, column.unit, in_file)
                raise DataError(f"{where}; unit in the map is {column.unit!r}", hint)
        return column.unit
    if unit is None:
        raise DataError(f"{where}, which is not a known unit", "Write the unit in the map.")
    if unit.dimension != parse_unit(wanted).dimension:
        message = f"{where}; {name} needs a unit such as {wanted}"
        raise DataError(message, _scale_hint(name, wanted, in_file))
    return spelled


def _scale_hint(name: str, unit: str, in_file: str) -> str:
    return (
        f"If the column is a signal of {name}, write 'unit: {unit}' and 'scale: ' with the number "
        f"of {unit} for 1 {in_file} in the map; if it is another quantity, name another column."
    )


def _name(table: Table, column: int | str) -> str:
    """Return the name of a column, also of one that a map gives by its number; empty if none."""
    if isinstance(column, str):
        return column
    named = isinstance(table, TextTable) and table.names
    return table.names[table.position(column)] if named else ""


def _unit_in_name(name: str) -> str | None:
    """Return the unit in brackets at the end of a column's name, if it is a known one."""
    match = _IN_BRACKETS.search(name)
    if match is None:
        return None
    text = match[1]
    if len(text) == 1 and text.islower() and text not in UNITS:  # a symbol: v is not the volt
        return None
    return text if text == "%" or unit_in(text) is not None else None


def _complete(
    table: Table, t_s: np.ndarray, channels: Mapping[str, np.ndarray], omitted: set[int]
) -> np.ndarray:
    """Return the samples (n,) with a time and a position; with all values if the format omits rows.

    Rows without a time and without values follow the end of a slower channel. Lines with one of
    them only are added to ``omitted``, or refused if they have a value without a time.
    """
    timed = np.isfinite(t_s)
    known = np.isfinite(np.stack(list(channels.values())))
    if table.leaves_out_rows:
        complete = timed & known.all(axis=0)
        partial = np.flatnonzero(~complete & (timed | known.any(axis=0)))
        omitted.update(table.lines_of(partial).tolist())
        return complete
    for key, values in channels.items():
        wrong = np.flatnonzero(np.isfinite(values) & ~timed)
        if len(wrong):
            raise DataError(f"{table.source}: {table.where(int(wrong[0]))}: {key} without a time")
    if "x_m" not in channels:
        return timed
    complete = timed & np.isfinite(channels["x_m"])
    omitted.update(table.lines_of(np.flatnonzero(timed & ~complete)).tolist())
    return complete


def _omissions(name: str, lines: set[int]) -> Iterator[FileNote]:
    if lines:
        text = "{count} rows left out: short or without a position (the first is line {first})"
        yield FileNote(name, text, {"count": len(lines), "first": min(lines)})


def _without_repeats(
    base: TimeBase, name: str, rules: ImportMap
) -> tuple[TimeBase, list[FileNote]]:
    again = np.concatenate(([False], np.diff(base.t_s) == 0))
    if rules.repeated_times == "refuse" or not again.any():
        return base, []
    text = "{count} of {samples} samples dropped: same time as the one before"
    note = FileNote(name, text, {"count": again.sum(), "samples": len(again)})
    kept = {key: values[~again] for key, values in base.channels.items()}
    return TimeBase(base.t_s[~again], kept, base.rows[~again], base.clipped[~again]), [note]
