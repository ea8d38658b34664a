"""A suggested import map as YAML text, with a comment on each guess."""

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from hbench.channels import CHANNELS
from hbench.config.import_layout import Format
from hbench.config.import_map import UNFILLED
from hbench.config.schedule import Screening
from hbench.store.importing.absolute_pressure import ATMOSPHERE, is_absolute_pressure
from hbench.store.suggesting.choice import GUESS, LIKELY, SURE, Choice
from hbench.store.suggesting.commented_yaml import comment_lines, entry, line, scalar
from hbench.store.suggesting.factors import ColumnFactor
from hbench.store.suggesting.file_names import NamePattern
from hbench.store.suggesting.motion import Motion
from hbench.store.suggesting.samples import SampleColumn
from hbench.store.suggesting.time_base import TimeChoice
from hbench.store.suggesting.units import ANGLES
from hbench.units import parse_unit
from hbench.untrusted_text import printable

_ASKED = json.dumps(UNFILLED)  # within braces
_SIGNS = (
    "Value = number * scale in the unit, plus offset. x_m must increase when the cylinder extends, "
    "and f_applied_n must be positive when it opposes extension: otherwise add scale: -1."
)
_SIDES = {
    "p_tp_pa": "piston side; ",
    "p_tr_pa": "rod side; ",
    "f_drive_n": "force of the drive, positive when it extends; ",
}
_SPLIT = "if it contains several runs, write each to a file (hbench/store/README.md)"
_PNEUMATIC_PA = 1.2e6  # a higher pressure is hydraulic
_SETTLE_M = Screening().settle_travel


@dataclass(frozen=True)
class SuggestedSeries:
    """Files of one pattern."""

    pattern: NamePattern
    bore_m: float | None = None  # by the balance of forces
    fault: str = ""  # why the map can't read them
    # Factors with their values in the files that were read.
    factors: Mapping[ColumnFactor, tuple[float, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class SuggestedMap:
    """Content of a suggested map."""

    folder: str
    files: tuple[str, ...]  # that were read
    count: int  # of all files
    format_name: str
    layout: Format | None
    time: TimeChoice
    choices: Mapping[str, Choice]
    units_in_file: Mapping[int | str, str]
    columns: Sequence[SampleColumn]
    motion: Motion | None
    series: tuple[SuggestedSeries, ...]
    unread: Mapping[str, str]  # columns that are no numbers: name, and file with the first fault
    left_out: Mapping[str, tuple[str, ...]]  # other columns of a chosen channel

    @property
    def is_rotary(self) -> bool:
        """Whether the position is an angle."""
        return "x_m" in self.choices and self.choices["x_m"].unit in ANGLES

    @property
    def is_driven(self) -> bool:
        """Whether a drive without hydraulics moves the specimen, which has no cylinder then."""
        return "f_drive_n" in self.choices


def map_text(found: SuggestedMap) -> str:
    """Return the map as YAML."""
    parts = (_head(found), _format(found), _columns(found), _constants(found), _series(found))
    sections = ["\n".join(part) for part in map(list, (*parts, _motion(found), _table(found)))]
    return "\n\n".join(filter(None, sections)) + "\n"


def _head(found: SuggestedMap) -> Iterator[str]:
    yield from comment_lines(
        f"Import map suggested from {len(found.files)} of {found.count} files in {found.folder}. "
        f"Replace each {UNFILLED} by a value. {SURE.capitalize()}, {LIKELY} and {GUESS} say how "
        "well a choice is founded: check what is not sure, then look at the result of "
        "`hbench import FOLDER --map FILE --preview DIR`."
    )
    yield f"name: {scalar(found.folder)}"
    if found.motion is not None and found.motion.has_constant_speed:
        yield line("kind: steady", f"{LIKELY}: the files contain sections of constant speed")
    elif found.motion is not None and found.motion.reverses:
        yield line(
            "kind: triangle",
            f"{GUESS}: reversals without constant speed; if it is nearly constant, write kind: "
            "steady and cut: reversals",
        )
    else:
        few = "few sections of constant speed; or ramp, triangle, steps, hold"
        yield line("kind: steady", f"{GUESS}: {few}")


def _format(found: SuggestedMap) -> Iterator[str]:
    if found.layout is None:
        yield line("", f"{found.format_name} files need no section 'format'.").strip()
        return
    given = found.layout.model_dump(exclude_defaults=True)
    if found.format_name != "text":
        given.pop("separator", None)
    else:
        given = {"separator": found.layout.separator, **given}
    if not given:
        return
    comments = {
        "separator": f"{SURE}: all rows have the same number of columns",
        "sheet": "the first with a table of numbers",
        "preamble": "lines before the header",
        "units_row": "the row below the header has units",
        "header": "columns are numbered from 1",
        "comment": "lines that begin with this are skipped",
        "skip_rows": "rows between header and data",
        "decimal": "decimal mark",
        "thousands": "groups of three digits",
    }
    yield "format:"
    for key, value in given.items():
        text = json.dumps(value) if not isinstance(value, str) else scalar(value)
        yield line(f"  {key}: {text}", comments.get(key, ""))


def _columns(found: SuggestedMap) -> Iterator[str]:
    yield from comment_lines(_SIGNS)
    yield "columns:"
    time = found.time
    if time.choice is not None:
        yield line(f"  t_s: {_column(found, 't_s', time.choice)}", _time_comment(time))
    elif time.stated:
        yield line("  # t_s:", f"{SURE}: the file states times; {_rate(time)}")
    else:
        yield line(f"  t_s: {{column: {_ASKED}, unit: s}}", _no_time(found))
    for channel in ("x_m", *(c for c in CHANNELS if c != "x_m")):
        choice = found.choices.get(channel)
        if channel == "x_m" and choice is None:
            yield line(f"  x_m: {{column: {_ASKED}, unit: mm}}", "position; which column is it?")
        elif choice is not None:
            text = f"  {channel}: {_column(found, channel, choice)}"
            if channel == "v_ref_m_s":
                why = "only if it is constant while a run counts as steady"
                yield from entry(f"  # {text.strip()}", f"{choice.reason}; {why}")
            else:
                yield from entry(text, _choice_comment(found, channel, choice))
    yield from _missing(found)


def _missing(found: SuggestedMap) -> Iterator[str]:
    if found.is_driven:
        if "f_applied_n" not in found.choices:
            yield from entry(
                f"  # f_applied_n: {{column: {_ASKED}, unit: N}}",
                "load cell; without one the applied force is 0",
            )
        return
    yield from _valve(found)
    if found.is_rotary and not any(name.startswith("p_") for name in found.choices):
        yield from entry(
            f"  # f_drive_n: {{column: {_ASKED}, unit: N m, scale: {_ASKED}}}",
            "torque of a drive without hydraulics, such as N m per ampere of its motor; then remove"
            " 'cylinder'",
        )
        return
    unit = next((c.unit for name, c in found.choices.items() if name.startswith("p_")), "bar")
    for channel, what in (
        ("p_tp_pa", f"pressure on the piston side, {unit}"),
        ("p_tr_pa", "pressure on the rod side"),
        ("f_applied_n", "force of the load cell"),
    ):
        if channel not in found.choices:
            units = unit if channel.startswith("p_") else "N"
            yield from entry(
                f"  # {channel}: {{column: {_ASKED}, unit: {units}}}",
                f"not found: {what}; see also constants",
            )


def _valve(found: SuggestedMap) -> Iterator[str]:
    """Yield the command of a valve in another unit than volts, which the user must convert."""
    if "u_t_v" in found.choices:
        return
    for column in found.columns:
        if column.meaning.quantity == "valve" and not column.is_date_time:
            text = f"column: {scalar(str(column.key), flow=True)}, unit: V, scale: {_ASKED}"
            yield from entry(
                f"  # u_t_v: {{{text}}}",
                "command of the test valve, for hbench reconcile; scale: volts for one of its unit"
                " (0.1 for percent of 10 V), and offset, such as -15 V for 4 to 20 mA at 1.25 V/mA",
            )
            return


def _constants(found: SuggestedMap) -> Iterator[str]:
    lines = {
        "p_tr_pa": ("0 bar", "if the rod side is open to the air"),
        "p_tp_pa": ("0 bar", "if the piston side is open to the air"),
        "f_applied_n": (
            '"{load} N"',
            "a known load, such as a weight; 0 N without a load or if it is unknown",
        ),
    }
    if found.is_driven:
        return
    missing = {channel: line for channel, line in lines.items() if channel not in found.choices}
    for channel in constants_of(found.choices):
        value, when = missing.pop(channel)
        yield "constants:"
        yield line(
            f"  {channel}: {value}", f"{GUESS}: not logged; remove it unless open to the air"
        )
    if missing:
        yield line("# constants:", "known values that are not logged; remove the sign #")
        for channel, (value, when) in missing.items():
            yield line(f"#   {channel}: {value}", when)


def constants_of(choices: Mapping[str, Choice]) -> tuple[str, ...]:
    """Return the channels with an assumed constant: the open side of a pneumatic cylinder."""
    pressures = [channel for channel in ("p_tp_pa", "p_tr_pa") if channel in choices]
    if pressures != ["p_tp_pa"]:
        return ()
    choice = choices["p_tp_pa"]
    highest = max(abs(choice.column.known)) * parse_unit(choice.unit).factor
    return ("p_tr_pa",) if highest < _PNEUMATIC_PA else ()


def _series(found: SuggestedMap) -> Iterator[str]:
    yield line("series:", "{...}: a number in the file name; *: any characters")
    anchor: SuggestedSeries | None = None
    usable = [series for series in found.series if not series.fault]
    shown = usable or list(found.series)
    for series in shown:
        pattern = series.pattern
        count = len(pattern.names)
        label = pattern.label or found.folder
        yield line(f"  - label: {scalar(label)}", f"{count} file{'s' * (count > 1)}")
        yield f"    files: {scalar(pattern.files)}"
        for name, unit in pattern.units.items():
            if name in pattern.assumed:
                yield line(f"    {name}_unit: {unit}", f"{GUESS}: no unit in the names")
            elif unit != {"speed": "mm/s", "load": "N", "pressure": "bar"}[name]:
                yield line(f"    {name}_unit: {unit}", f"{SURE}: in the names")
        yield from _factors(series)
        if found.is_driven:
            continue
        if anchor is None or _other_bore(anchor.bore_m, series.bore_m):
            several = anchor is None and len(shown) > 1
            yield "    cylinder: &cylinder" if several else "    cylinder:"
            yield from _sizes(found, series)
            anchor = anchor or series
        else:
            yield line("    cylinder: *cylinder", "assumed to be the same")
    for series in found.series if usable else ():
        if series.fault:
            yield from comment_lines(f"- files: {series.pattern.files}: {series.fault}", "  # ")


def _factors(series: SuggestedSeries) -> Iterator[str]:
    """Yield the factors: fields of the names, and columns with one value in a series."""
    units = series.pattern.factors
    alone = {f: values[0] for f, values in series.factors.items() if len(values) == 1}
    given = [f"{name}: {scalar(unit, flow=True)}" for name, unit in units.items()]
    given += [f"{f.name}: {scalar(f.text(value), flow=True)}" for f, value in alone.items()]
    if given:
        why = [f"{LIKELY}: fields of the names"] if units else []
        why += [
            f"{f.column} is about {f.text(value)} in the files read" for f, value in alone.items()
        ]
        yield from entry(f"    factors: {{{', '.join(given)}}}", "; ".join(why))
    for factor, values in series.factors.items():
        if factor not in alone:
            several = ", ".join(map(factor.text, sorted(values)))
            yield from comment_lines(
                f"factors: {factor.column} has the values {several} in these files; to separate "
                f"their curves write a series for each, with factors: {{{factor.name}: VALUE}}",
                "    # ",
            )


def _sizes(found: SuggestedMap, series: SuggestedSeries) -> Iterator[str]:
    if found.is_rotary:
        yield line(f"      displacement: {UNFILLED} cm^3", "volume for one radian")
        return
    about = "the bore"
    if series.bore_m is not None:
        about += f"; the balance of forces gives {1e3 * series.bore_m:.1f} mm"
    yield line(f"      piston_diameter: {UNFILLED} mm", about)
    yield line(
        f"      rod_diameter: {UNFILLED} mm", "0 mm if the chamber has no rod; with a rod on"
    )
    yield line("", "both sides write piston_area and rod_area instead")


def _other_bore(a: float | None, b: float | None) -> bool:
    return a is not None and b is not None and abs(a - b) > 0.015 * a


def _motion(found: SuggestedMap) -> Iterator[str]:
    motion, time = found.motion, found.time
    if time.repeats:
        yield line("repeated_times: drop", "the clock is coarse: some times are equal")
    if motion is None:
        return
    yield line(f"cut: {motion.cut}", f"{LIKELY}: {motion.reason}; {_about(found, motion)}")
    if motion.min_stroke_m is not None:
        text = f"min_stroke: {1e3 * motion.min_stroke_m:g} mm"
        yield line(text, "a quarter of the travel; shorter strokes are left out")
    if motion.stroke_m < 2 * _SETTLE_M:
        yield "screening:"
        text = f"  settle_travel: {1e3 * motion.stroke_m / 4:.2g} mm"
        yield line(text, f"{GUESS}: a quarter of a stroke; default {1e3 * _SETTLE_M:g} mm")
    if motion.rest_s:
        yield from comment_lines(
            f"The files begin with at least {motion.rest_s:.1f} s at rest. If no load or pressure "
            "acts there, add zero: rest to force and pressures: the mean at rest is subtracted."
        )


def _about(found: SuggestedMap, motion: Motion) -> str:
    """Return the usual length and the speeds of the strokes."""
    factor, unit = (1.0, "rad") if found.is_rotary else (1e3, "mm")
    speeds = dict.fromkeys(f"{factor * speed:.3g}" for speed in motion.speeds_m_s)
    about = f"about {factor * motion.stroke_m:.3g} {unit}"
    is_timed = found.time.choice is None or found.time.choice.scale is not None
    return f"{about}, {' to '.join(speeds)} {unit}/s" if is_timed else about


def _table(found: SuggestedMap) -> Iterator[str]:
    sizes = {len(column.values[0]) for column in found.columns}
    alike = f" ({sizes.pop()} samples)" if len(sizes) == 1 else ""
    yield from comment_lines(f"All columns of {found.files[0]}{alike}; ranges in all files read:")
    for number, column in enumerate(found.columns, start=1):
        name = column.name or f"column {column.key}"
        unit = f" {column.unit}" if column.unit else ""
        known = column.known
        values = f"{known.min():.5g} to {known.max():.5g}{unit}" if len(known) else "date-times"
        values += "" if alike else f" ({len(column.values[0])} samples)"
        yield printable(f"#   {number:<3} {name[:40]:<24} {values}").rstrip()


def _column(found: SuggestedMap, channel: str, choice: Choice) -> str:
    key = choice.column.key
    parts = [f"column: {key if isinstance(key, int) else scalar(key, flow=True)}"]
    if not (
        _is_stated(found, choice) or (key == channel and choice.unit == CHANNELS[channel].unit)
    ):
        parts.append(f"unit: {scalar(choice.unit, flow=True)}")
    if choice.scale is None:
        parts.append(f"scale: {_ASKED}")
    elif choice.scale != 1.0:
        parts.append(f"scale: {choice.scale:g}")
    stated = found.units_in_file.get(choice.column.key, "")
    if is_absolute_pressure(channel, choice.column.name, stated):
        parts.append(f"offset: -{ATMOSPHERE}")
    return f"{{{', '.join(parts)}}}"


def _is_stated(found: SuggestedMap, choice: Choice) -> bool:
    """Return whether the import reads the unit in a row of units."""
    if found.layout is None or not found.layout.units_row:
        return False
    try:
        stated = parse_unit(found.units_in_file.get(choice.column.key, UNFILLED))
    except ValueError:
        return False
    return stated == parse_unit(choice.unit)


def _choice_comment(found: SuggestedMap, channel: str, choice: Choice) -> str:
    parts = [f"{choice.certainty}: {choice.reason}"]
    if _is_stated(found, choice):
        parts.append(f"{choice.unit} in the file")
    if channel in found.left_out:
        parts.append(f"left out: {', '.join(found.left_out[channel])}")
    if isinstance(choice.column.key, int) and choice.column.name:
        parts.insert(0, repr(choice.column.name))
    return _SIDES.get(channel, "") + "; ".join(parts)


def _time_comment(time: TimeChoice) -> str:
    assert time.choice is not None
    name = time.choice.column.name
    named = f"{name!r}; " if name and isinstance(time.choice.column.key, int) else ""
    rate = "" if time.choice.scale is None else f"; {_rate(time)}"
    return f"{named}{time.choice.certainty}: {time.choice.reason}{rate}"


def _no_time(found: SuggestedMap) -> str:
    for column in found.columns:
        for file, t in zip(found.files, column.values, strict=True):
            if column.meaning.channel == "t_s" and len(back := np.flatnonzero(t[1:] < t[:-1])):
                before, after = (
                    str(value) if column.is_date_time else f"{value:.10g}"
                    for value in t[back[0] : back[0] + 2]
                )
                return f"{column.name!r} goes back from {before} to {after} in {file}; {_SPLIT}"
    if found.unread:
        few = ", ".join(list(found.unread)[:5])
        return f"no times; neither numbers nor date-times such as 2024-12-24 18:30:00: {few}"
    return "no times: no column increases evenly"


def _rate(time: TimeChoice) -> str:
    return f"{time.rate_hz:.4g} Hz"
