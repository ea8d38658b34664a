"""Section of a suggested map on the columns, and the table of all columns of the files."""

import json
from collections.abc import Iterator

import numpy as np

from hbench.channels import CHANNELS
from hbench.config.import_map import UNFILLED
from hbench.store.importing.plausibility import ATMOSPHERE, is_absolute_pressure
from hbench.store.suggesting.choice import SURE, Choice
from hbench.store.suggesting.map_yaml.commented_yaml import comment_lines, entry, line, scalar
from hbench.store.suggesting.map_yaml.suggested_map import SuggestedMap
from hbench.store.suggesting.quantities import Quantity
from hbench.store.suggesting.time_base import TimeChoice
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
_OF_LOAD: tuple[tuple[Quantity, str, dict[str, str]], ...] = (
    ("pressure", "unit: bar", {"p_lp_pa": "piston side", "p_lr_pa": "rod side"}),
    (
        "valve",
        f"unit: V, scale: {_ASKED}",
        {"u_l1_v": "valve on the rod side", "u_l2_v": "valve on the piston side"},
    ),
)
_SPLIT = "if it contains several runs, write each to a file (hbench/store/README.md)"


def column_lines(suggested: SuggestedMap) -> Iterator[str]:
    """Yield the section of the columns: the chosen ones, and comments on those not found."""
    yield from comment_lines(_SIGNS)
    yield "columns:"
    time = suggested.time
    if time.choice is not None:
        yield line(f"  t_s: {_column(suggested, 't_s', time.choice)}", _time_comment(time))
    elif time.stated:
        yield line("  # t_s:", f"{SURE}: the file states times; {_rate(time)}")
    else:
        yield line(f"  t_s: {{column: {_ASKED}, unit: s}}", _no_time(suggested))
    for channel in ("x_m", *(c for c in CHANNELS if c != "x_m")):
        choice = suggested.choices.get(channel)
        if channel == "x_m" and choice is None:
            yield line(f"  x_m: {{column: {_ASKED}, unit: mm}}", "position; which column is it?")
        elif choice is not None:
            text = f"  {channel}: {_column(suggested, channel, choice)}"
            if channel == "v_ref_m_s":
                why = "only if it is constant while a run counts as steady"
                yield from entry(f"  # {text.strip()}", f"{choice.reason}; {why}")
            else:
                yield from entry(text, _choice_comment(suggested, channel, choice))
    yield from _missing(suggested)


def _missing(suggested: SuggestedMap) -> Iterator[str]:
    if suggested.is_driven:
        if "f_applied_n" not in suggested.choices:
            yield from entry(
                f"  # f_applied_n: {{column: {_ASKED}, unit: N}}",
                "load cell; without one the applied force is 0",
            )
        return
    yield from _valve(suggested)
    if suggested.is_rotary and not any(name.startswith("p_") for name in suggested.choices):
        yield from entry(
            f"  # f_drive_n: {{column: {_ASKED}, unit: N m, scale: {_ASKED}}}",
            "torque of a drive without hydraulics, such as N m per ampere of its motor; then remove"
            " 'cylinder'",
        )
        return
    unit = next((c.unit for name, c in suggested.choices.items() if name.startswith("p_")), "bar")
    for channel, what in (
        ("p_tp_pa", f"pressure on the piston side, {unit}"),
        ("p_tr_pa", "pressure on the rod side"),
        ("f_applied_n", "force of the load cell"),
    ):
        if channel not in suggested.choices:
            units = unit if channel.startswith("p_") else "N"
            yield from entry(
                f"  # {channel}: {{column: {_ASKED}, unit: {units}}}",
                f"not found: {what}; see also constants",
            )
    yield from _load_cylinder(suggested)


def _load_cylinder(suggested: SuggestedMap) -> Iterator[str]:
    """Yield channels of a load cylinder where further columns may be these."""
    used = {choice.column.key for choice in suggested.choices.values()}
    out = {name for names in suggested.left_out.values() for name in names}
    for quantity, unit, channels in _OF_LOAD:
        asked = [name for name in channels if name not in suggested.choices]
        free = [
            column.name
            for column in suggested.columns
            if column.meaning.quantity == quantity
            and not (column.meaning.is_reference or column.key in used or column.name in out)
        ]
        of_test = quantity == "valve" and "u_t_v" not in suggested.choices  # is among the free
        if not asked or len(free) - of_test < len(asked):
            continue
        columns = f"for hbench reconcile; further columns: {', '.join(free)}"
        for name, where in channels.items():
            if name in asked:
                why = f"{where} of a load cylinder"
                text = f"  # {name}: {{column: {_ASKED}, {unit}}}"
                yield from entry(text, f"{why}, {columns}" if name == asked[0] else why)


def _valve(suggested: SuggestedMap) -> Iterator[str]:
    """Yield the command of a valve in another unit than volts, which the user must convert."""
    if "u_t_v" in suggested.choices:
        return
    for column in suggested.columns:
        if column.meaning.quantity == "valve" and not column.is_date_time:
            text = f"column: {scalar(str(column.key), flow=True)}, unit: V, scale: {_ASKED}"
            yield from entry(
                f"  # u_t_v: {{{text}}}",
                "command of the test valve, for hbench reconcile; scale: volts for one of its unit"
                " (0.1 for percent of 10 V), and offset, such as -15 V for 4 to 20 mA at 1.25 V/mA",
            )
            return


def table_lines(suggested: SuggestedMap) -> Iterator[str]:
    """Yield a comment with all columns of the files and their ranges."""
    sizes = {len(column.values[0]) for column in suggested.columns}
    alike = f" ({sizes.pop()} samples)" if len(sizes) == 1 else ""
    yield from comment_lines(
        f"All columns of {suggested.files[0]}{alike}; ranges in all files read:"
    )
    for number, column in enumerate(suggested.columns, start=1):
        name = column.name or f"column {column.key}"
        unit = f" {column.unit}" if column.unit else ""
        known = column.known
        values = f"{known.min():.5g} to {known.max():.5g}{unit}" if len(known) else "date-times"
        values += "" if alike else f" ({len(column.values[0])} samples)"
        yield printable(f"#   {number:<3} {name[:40]:<24} {values}").rstrip()


def _column(suggested: SuggestedMap, channel: str, choice: Choice) -> str:
    key = choice.column.key
    parts = [f"column: {key if isinstance(key, int) else scalar(key, flow=True)}"]
    if not (
        _is_stated(suggested, choice) or (key == channel and choice.unit == CHANNELS[channel].unit)
    ):
        parts.append(f"unit: {scalar(choice.unit, flow=True)}")
    if choice.time is not None:
        key = choice.time.key
        parts.append(f"time: {key if isinstance(key, int) else scalar(key, flow=True)}")
    if choice.scale is None:
        parts.append(f"scale: {_ASKED}")
    elif choice.scale != 1.0:
        parts.append(f"scale: {choice.scale:g}")
    stated = suggested.units_in_file.get(choice.column.key, "")
    if is_absolute_pressure(channel, choice.column.name, stated):
        parts.append(f"offset: -{ATMOSPHERE}")
    return f"{{{', '.join(parts)}}}"


def _is_stated(suggested: SuggestedMap, choice: Choice) -> bool:
    """Return whether the import reads the unit in a row of units."""
    if suggested.layout is None or not suggested.layout.units_row:
        return False
    try:
        stated = parse_unit(suggested.units_in_file.get(choice.column.key, UNFILLED))
    except ValueError:
        return False
    return stated == parse_unit(choice.unit)


def _choice_comment(suggested: SuggestedMap, channel: str, choice: Choice) -> str:
    parts = [f"{choice.certainty}: {choice.reason}"]
    if _is_stated(suggested, choice):
        parts.append(f"{choice.unit} in the file")
    if channel in suggested.left_out:
        parts.append(f"left out: {', '.join(suggested.left_out[channel])}")
    if isinstance(choice.column.key, int) and choice.column.name:
        parts.insert(0, repr(choice.column.name))
    return _SIDES.get(channel, "") + "; ".join(parts)


def _time_comment(time: TimeChoice) -> str:
    assert time.choice is not None
    name = time.choice.column.name
    named = f"{name!r}; " if name and isinstance(time.choice.column.key, int) else ""
    rate = "" if time.choice.scale is None else f"; {_rate(time)}"
    return f"{named}{time.choice.certainty}: {time.choice.reason}{rate}"


def _no_time(suggested: SuggestedMap) -> str:
    for column in suggested.columns:
        for file, t in zip(suggested.files, column.values, strict=True):
            if column.meaning.channel == "t_s" and len(back := np.flatnonzero(t[1:] < t[:-1])):
                before, after = (
                    str(value) if column.is_date_time else f"{value:.10g}"
                    for value in t[back[0] : back[0] + 2]
                )
                return f"{column.name!r} goes back from {before} to {after} in {file}; {_SPLIT}"
    if suggested.unread:
        few = ", ".join(list(suggested.unread)[:5])
        return f"no times; neither numbers nor date-times such as 2024-12-24 18:30:00: {few}"
    return "no times: no column increases evenly"


def _rate(time: TimeChoice) -> str:
    return f"{time.rate_hz:.4g} Hz"
