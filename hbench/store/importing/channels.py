"""The channels of an imported file by its import map: units, zeros, times."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import datetime

import numpy as np

from hbench.channels import CHANNELS
from hbench.config.import_layout import ImportedCylinder
from hbench.config.import_map import ImportMap
from hbench.errors import DataError
from hbench.motion.rest import ZeroOffset, rest_before_motion
from hbench.store.campaign.run_csv import check_limits
from hbench.store.formats.table import Table
from hbench.store.formats.text import TextTable
from hbench.store.importing.alignment import aligned
from hbench.store.importing.clipping import clipped_samples, frozen_samples, suspected_samples
from hbench.store.importing.file_notes import FileNote
from hbench.store.importing.plausibility import below_vacuum, beyond_full_scale, forgotten_rod
from hbench.store.importing.resampling import held_position, interval_means, whole_intervals
from hbench.store.importing.time_bases import TimeBase, column_unit, read_time_bases
from hbench.store.importing.zeros import subtraction, zeroed
from hbench.units import from_si

_OF_FRICTION = ("p_tp_pa", "p_tr_pa", "f_applied_n", "f_drive_n")


@dataclass(frozen=True)
class FileChannels:
    """The channels of a whole file in SI."""

    channels: dict[str, np.ndarray]  # (n,) each
    lines: np.ndarray  # (n,) line of each sample in the file, from 1
    notes: tuple[FileNote, ...]  # the conversions applied
    units: dict[str, str]  # of the columns in the file
    zeros: dict[str, ZeroOffset]  # subtracted from channels
    rest: tuple[float, float] | None  # [s] the rest before the motion; None if there is none
    origin: datetime | None  # at t_s = 0; None if the file does not state it


def read_channels_by_map(
    table: Table,
    name: str,
    fields: Mapping[str, str],
    cylinder: ImportedCylinder,
    rules: ImportMap,
) -> FileChannels:
    """Return the channels of a file. ``fields`` are the values in its ``name``.

    Raises ``DataError`` naming the invalid line.
    """
    source, max_gap_s = table.source, rules.screening.max_gap
    bases, origin, omissions = read_time_bases(table, name, rules)
    omissions = [*omissions, *_sheets(table, name), *_empty_cells(bases, name)]
    bases, clipping = _with_clipping(bases, name)
    base, alignment = aligned(bases, max_gap_s, source, name)
    n = len(base.t_s)
    constants = {key: np.full(n, value) for key, value in _constants(source, fields, rules)}
    check_limits(constants, table)
    channels = {"t_s": base.t_s, **base.channels, **constants}
    if "f_drive_n" in channels:
        channels.setdefault("f_applied_n", np.zeros(n))
    if clipping:
        channels["sensor_saturated"] = base.clipped.astype(float)
    units = {key: column_unit(table, key, column, rules) for key, column in rules.columns.items()}
    rest = rest_before_motion(channels["t_s"], channels["x_m"], channels.get("v_ref_m_s"))
    at_rest_s = channels["t_s"][rest]
    channels, zeros = zeroed(channels, rest, source, cylinder, rules)
    implausible = (
        *below_vacuum(name, channels),
        *beyond_full_scale(name, channels, rules),
        *forgotten_rod(name, cylinder, rules),
    )
    lines = table.lines_of(base.rows)
    if rules.resample is None:
        implausible = (*implausible, *held_position(name, channels["t_s"], channels["x_m"]))
    channels, lines, resampling = _resampled(channels, lines, source, name, rules)
    subtracted = [subtraction(name, key, rules.unit(key), zero) for key, zero in zeros.items()]
    return FileChannels(
        channels=channels,
        lines=lines,
        notes=(*omissions, *clipping, *alignment, *subtracted, *implausible, *resampling),
        units=units,
        zeros=zeros,
        rest=(float(at_rest_s[0]), float(at_rest_s[-1])) if len(at_rest_s) > 1 else None,
        origin=origin,
    )


def _constants(
    source: str, fields: Mapping[str, str], rules: ImportMap
) -> Iterator[tuple[str, float]]:
    """Yield each channel of ``constants`` with its value in SI. Raises ``DataError``."""
    for key in rules.constants:
        try:
            yield key, rules.constant(key, fields)
        except ValueError as error:  # such as "{load}e308 N"
            raise DataError(f"{source}: {error}") from None


def _sheets(table: Table, name: str) -> Iterator[FileNote]:
    if isinstance(table, TextTable) and table.other_sheets:
        text = "sheets not read: {count}; format.sheet in the map chooses one"
        yield FileNote(name, text, {"count": len(table.other_sheets)})


def _empty_cells(bases: list[TimeBase], name: str) -> Iterator[FileNote]:
    """Yield a note for each channel of friction without a value in some samples."""
    for base in bases:
        for key in sorted(base.channels.keys() & set(_OF_FRICTION)):
            count = int(np.isnan(base.channels[key]).sum())
            if 0 < count < len(base.t_s):
                text = (
                    f"{key}: no value in {{count}} of {{samples}} samples; friction is computed "
                    "from the others"
                )
                yield FileNote(name, text, {"count": count, "samples": len(base.t_s)})


def _with_clipping(bases: list[TimeBase], name: str) -> tuple[list[TimeBase], list[FileNote]]:
    """Mark the clipped and frozen samples of each time base, with notes."""
    t_s, x_m = bases[0].t_s, bases[0].channels["x_m"]
    marked, notes = [], []
    for base in bases:
        # The position at the base's times shows whether the log has stopped.
        others = {"x_m": np.interp(base.t_s, t_s, x_m), **base.channels}
        clipped = clipped_samples(others)
        notes += [_clipping(name, key, others[key], at) for key, at in clipped.items()]
        frozen = frozen_samples(others, clipped)
        notes += [_freezing(name, key, others[key], at) for key, at in frozen.items()]
        suspected = suspected_samples(others, {**clipped, **frozen})
        notes += [_suspicion(name, key, others[key], at) for key, at in suspected.items()]
        marked.append(
            replace(
                base,
                clipped=np.logical_or.reduce([base.clipped, *clipped.values(), *frozen.values()]),
            )
        )
    return marked, notes


def _suspicion(name: str, key: str, values: np.ndarray, near: np.ndarray) -> FileNote:
    unit = "bar" if CHANNELS[key].unit == "Pa" else CHANNELS[key].unit
    inside = values[near]
    high = inside.max() == np.nanmax(values)
    end, limit = ("highest", inside.max()) if high else ("lowest", inside.min())
    text = (
        f"{key}: stays within 2 counts of its {end} value, {{limit}} {unit}, in {{count}} of "
        "{samples} samples, with less than half of the noise next to them: probably its "
        "amplifier is saturated; check the sensor's range, the runs are not rejected"
    )
    numbers = {"limit": from_si(float(limit), unit), "count": near.sum(), "samples": len(values)}
    return FileNote(name, text, numbers)


def _clipping(name: str, key: str, values: np.ndarray, samples: np.ndarray) -> FileNote:
    unit = "bar" if CHANNELS[key].unit == "Pa" else CHANNELS[key].unit
    text = (
        f"{key}: clipped at {{limit}} {unit} in {{count}} of {{samples}} samples: "
        "constant while other channels change"
    )
    limit = from_si(float(values[samples][0]), unit)
    return FileNote(name, text, {"limit": limit, "count": samples.sum(), "samples": len(samples)})


def _freezing(name: str, key: str, values: np.ndarray, frozen: np.ndarray) -> FileNote:
    unit = "bar" if CHANNELS[key].unit == "Pa" else CHANNELS[key].unit
    text = (
        f"{key}: repeats {{value}} {unit} exactly in {{count}} of {{samples}} samples, next to "
        "noise: the sensor or the logger's channel is frozen, and runs at constant speed that "
        "contain these samples are rejected"
    )
    value = from_si(float(values[frozen][0]), unit)
    numbers = {"value": value, "count": frozen.sum(), "samples": len(frozen)}
    return FileNote(name, text, numbers)


def _resampled(
    channels: dict[str, np.ndarray], lines: np.ndarray, source: str, name: str, rules: ImportMap
) -> tuple[dict[str, np.ndarray], np.ndarray, list[FileNote]]:
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
    text = f"resampled from {{samples}} samples to {{means}} means over 1/{rate:g} s"
    text += "; {lost} intervals with gaps left out" if lost else ""
    numbers = {"samples": len(t_s), "means": len(starts), "lost": lost}
    nearest = np.clip(np.searchsorted(t_s, middles), 0, len(lines) - 1)
    return out, lines[nearest], [FileNote(name, text, numbers)]
