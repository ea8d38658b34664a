"""The channels of an imported file by its import map: units, zeros, times."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from hbench.config.import_layout import ALWAYS, CHANNELS, DATE_TIME, Column
from hbench.config.import_map import ImportMap
from hbench.errors import DataError
from hbench.motion.rest import LEAST_REST_S, rest_before_motion, zero_offset
from hbench.store.campaign.run_csv import check_lengths, check_limits, check_time
from hbench.store.formats.opening import AnyTable
from hbench.store.formats.text import TextTable
from hbench.store.importing.clipping import clipped_samples
from hbench.store.importing.resampling import interval_means, whole_intervals
from hbench.units import parse_unit, to_si


@dataclass(frozen=True)
class FileChannels:
    """The channels of a whole file in SI."""

    channels: dict[str, np.ndarray]  # (n,) each
    lines: np.ndarray  # (n,) line of each sample in the file, from 1
    notes: tuple[str, ...]  # the conversions applied


def read_channels_by_map(
    table: AnyTable, name: str, fields: Mapping[str, str], rules: ImportMap
) -> FileChannels:
    """Return the channels of a file. ``fields`` are the values in its ``name``.

    Raises ``DataError`` naming the invalid line.
    """
    source = table.source
    channels = {key: _in_si(table, key, column, rules) for key, column in rules.columns.items()}
    check_lengths(channels, table)
    clipped = clipped_samples(channels)
    n = len(channels["t_s"])
    for key, constant in _constants(source, fields, rules):
        channels[key] = np.full(n, constant)
    check_limits(channels, table)
    if clipped:
        channels["sensor_saturated"] = np.logical_or.reduce(list(clipped.values())).astype(float)
    clipping = [_clipping(name, key, channels[key], samples) for key, samples in clipped.items()]
    channels, rows, repeats = _without_repeats(channels, name, rules)
    hint = "If the clock is too coarse, write 'repeated_times: drop' in the map."
    check_time(channels["t_s"], table, rows, hint)
    lines = table.lines[rows] if isinstance(table, TextTable) else rows + 1
    channels, zeros = _zeroed(channels, source, name, rules)
    channels, lines, resampling = _resampled(channels, lines, source, name, rules)
    return FileChannels(channels, lines, (*repeats, *clipping, *zeros, *resampling))


def _constants(
    source: str, fields: Mapping[str, str], rules: ImportMap
) -> Iterator[tuple[str, float]]:
    """Yield each channel of ``constants`` with its value in SI. Raises ``DataError``."""
    for key in rules.constants:
        try:
            yield key, rules.constant(key, fields)
        except ValueError as error:  # such as "{load}e308 N"
            raise DataError(f"{source}: {error}") from None


def _in_si(table: AnyTable, name: str, column: Column, rules: ImportMap) -> np.ndarray:
    unit = _unit(table, name, column, rules)
    if unit == DATE_TIME:
        return table.seconds(column.column)
    numbers = table.numbers(column.column, gaps=name not in ALWAYS)
    values = numbers * (parse_unit(unit).factor * column.scale)
    if name == "f_applied_n" and rules.load_cell is not None:  # C.6
        values = (values - rules.load_cell.level) / rules.load_cell.volts_per_newton
    return values if column.offset is None else values + to_si(column.offset, CHANNELS[name])


def _unit(table: AnyTable, name: str, column: Column, rules: ImportMap) -> str:
    """Return a column's unit: the map's, the file's own, or SI. Raises ``DataError``."""
    wanted, in_file = rules.wanted(name), table.unit(column.column)
    if in_file is None:
        return column.unit or wanted
    where = f"{table.source}: column {column.column}: unit in the file is {in_file!r}"
    try:
        unit = parse_unit(in_file) if in_file else None
    except ValueError:
        unit = None
    if column.unit is not None:
        if unit and column.unit != DATE_TIME and unit != parse_unit(column.unit):
            raise DataError(f"{where}; unit in the map is {column.unit!r}")
        return column.unit
    if unit is None:
        raise DataError(f"{where}, which is not a known unit", "Write the unit in the map.")
    if unit.dimension != parse_unit(wanted).dimension:
        raise DataError(f"{where}; {name} needs a unit such as {wanted}")
    return in_file


def _clipping(name: str, key: str, values: np.ndarray, samples: np.ndarray) -> str:
    limits = " and ".join(f"{limit:.6g}" for limit in np.unique(values[samples]))
    return (
        f"{name}: {key}: clipped at {limits} {CHANNELS[key]} in {samples.sum()} of {len(samples)} "
        "samples: constant while other channels change"
    )


def _without_repeats(
    channels: dict[str, np.ndarray], name: str, rules: ImportMap
) -> tuple[dict[str, np.ndarray], np.ndarray, list[str]]:
    again = np.concatenate(([False], np.diff(channels["t_s"]) == 0))
    if rules.repeated_times == "refuse" or not again.any():
        return channels, np.arange(len(again)), []
    note = f"{name}: {again.sum()} of {len(again)} samples dropped: same time as the one before"
    kept = {key: values[~again] for key, values in channels.items()}
    return kept, np.flatnonzero(~again), [note]


def _zeroed(
    channels: dict[str, np.ndarray], source: str, name: str, rules: ImportMap
) -> tuple[dict[str, np.ndarray], list[str]]:
    asked = [key for key, column in rules.columns.items() if column.zero == "rest"]
    if not asked:
        return channels, []
    t_s, out, notes = channels["t_s"], dict(channels), []
    rest = rest_before_motion(t_s, channels["x_m"], channels.get("v_ref_m_s"))
    for key in asked:
        zero = zero_offset(t_s[rest], channels[key][rest])
        if zero is None:
            raise DataError(
                f"{source}: {key}: no zero offset: less than {LEAST_REST_S:g} s at rest before the "
                "motion",
                "Remove 'zero: rest' from the map, or give the zero offset as 'offset'.",
            )
        out[key] = channels[key] - zero.mean
        offset = f"{zero.mean:.4g} {CHANNELS[key]} (standard error {zero.se:.2g} {CHANNELS[key]})"
        notes.append(
            f"{name}: {key}: zero offset {offset} subtracted, the mean over {zero.seconds:.2f} s "
            "at rest"
        )
    return out, notes


def _resampled(
    channels: dict[str, np.ndarray], lines: np.ndarray, source: str, name: str, rules: ImportMap
) -> tuple[dict[str, np.ndarray], np.ndarray, list[str]]:
    t_s, rate = channels["t_s"], rules.resample
    if rate is None:
        return channels, lines, []
    step = float(np.median(np.diff(t_s))) if len(t_s) > 1 else np.inf
    if rate * step > 1 + 1e-6:
        raise DataError(
            f"{source}: resample = {rate:g} Hz; limit {1 / step:.3g} Hz, its sampling rate",
            "Lower 'resample': each interval needs a sample, since none is interpolated.",
        )
    try:
        starts = whole_intervals(t_s, rate, rules.screening.max_gap)
    except ValueError as error:
        raise DataError(
            f"{source}: resample = {rate:g} Hz gives {error}",
            "Lower 'resample' or 'screening.max_gap'.",
        ) from None
    if not len(starts):
        raise DataError(
            f"{source}: resample = {rate:g} Hz: no interval of {1 / rate:g} s without a gap longer "
            f"than {rules.screening.max_gap:g} s",
            "Raise 'resample' or 'screening.max_gap'.",
        )
    middles = starts + 0.5 / rate
    out = {key: interval_means(t_s, y, starts, rate) for key, y in channels.items()}
    out["t_s"] = middles
    if "sensor_saturated" in out:  # a mean with a clipped sample counts as clipped
        out["sensor_saturated"] = (out["sensor_saturated"] > 0).astype(float)
    lost = int(np.floor((t_s[-1] - t_s[0]) * rate + 1e-9)) - len(starts)
    note = f"{name}: resampled from {len(t_s)} samples to {len(starts)} means over 1/{rate:g} s"
    if lost:
        note += f"; {lost} intervals with gaps left out"
    nearest = np.clip(np.searchsorted(t_s, middles), 0, len(lines) - 1)
    return out, lines[nearest], [note]
