"""The columns of position, velocity, pressures and force among those of some files."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from hbench.channels import CHANNELS
from hbench.config.import_layout import LEAST, LIMITS
from hbench.store.suggesting.choice import GUESS, LIKELY, SURE, Choice
from hbench.store.suggesting.nominal_values import Fields, unit_of_levels, unit_of_travel
from hbench.store.suggesting.quantities import Quantity, is_numbered, quantity_of
from hbench.store.suggesting.samples import SampleColumn
from hbench.store.suggesting.signals import (
    are_proportional,
    is_constant,
    roughness,
    velocity_factor,
)
from hbench.store.suggesting.time_base import TimeChoice
from hbench.units import ANGLES, parse_unit

_QUANTITIES: dict[str, Quantity] = {
    "x_m": "position",
    "v_m_s": "velocity",
    "p_tp_pa": "pressure",
    "p_tr_pa": "pressure",
    "f_applied_n": "force",
    "f_drive_n": "force",
    "p_s_pa": "pressure",
    "p_lp_pa": "pressure",
    "p_lr_pa": "pressure",
    "v_ref_m_s": "velocity",
    "u_t_v": "valve",
    "temp_tank_k": "temperature",
    "temp_port_k": "temperature",
    "temp_seal_k": "temperature",
}
_EXACT, _NAMED, _SUGGESTED = 10.0, 3.0, 1.5  # points of a name for a channel
_STATED, _SAME_GROUP, _OTHER_GROUP, _WEAKER, _CONSTANT = 1.0, 1.0, -1.5, -1.0, -2.5
_UNKNOWN_WORD = 0.2
_FEW, _MANY = 12, 100  # at most as many values in at least as many samples are set values
# Of channels of which the volts of a sensor are logged.
_USUAL_UNITS: dict[Quantity, str] = {
    "position": "mm",
    "velocity": "mm/s",
    "pressure": "bar",
    "force": "N",
    "valve": "V",
    "temperature": "degC",
}
_SMOOTH = 0.1  # roughness of a position
_HOT_DEGC, _COLD_K = 90.0, 230.0  # hydraulic oil is colder, and warmer
_BORES_M = (0.004, 1.0)  # of cylinders, to choose the unit of a force


def choose_channels(
    columns: Sequence[SampleColumn],
    time: TimeChoice,
    fields: Fields,
) -> dict[str, Choice]:
    """Return the column of each channel that is found.

    ``fields`` are the values in SI in the name of each file: a column without a name that has
    these values is that quantity, and one without a unit has that in which it has these values.
    """
    free = [c for c in columns if not c.is_date_time]
    if time.choice is not None:
        free = [c for c in free if c.key != time.choice.column.key]
    named = _by_name(free)
    chosen = dict(named)
    if "x_m" not in chosen:
        taken = {choice.column.key for choice in chosen.values()}
        unknown = [c for c in free if c.key not in taken and not c.meaning.quantity]
        chosen |= _by_data(_one_each(unknown), time, fields, chosen)
    taken = {choice.column.key for choice in chosen.values()}
    unnamed = [c for c in free if c.key not in taken and not c.name]
    if not _one_each(unnamed):  # else they may be pressures
        chosen = _with_drive(chosen, fields)
    return _with_units(chosen, time, fields)


def _with_drive(chosen: dict[str, Choice], fields: Fields) -> dict[str, Choice]:
    """Take a force as that of the drive where there is no pressure, and only there."""
    out = dict(chosen)
    is_rotary = "x_m" in chosen and chosen["x_m"].unit in ANGLES
    if is_rotary or any(channel in chosen for channel in ("p_tp_pa", "p_tr_pa")):
        if "f_drive_n" in out and out["f_drive_n"].column.name != "f_drive_n":
            drive = out.pop("f_drive_n")  # of a drive that loads the cylinder
            out.setdefault("f_applied_n", drive)
        return out
    has_pressure = any("pressure" in values for values in fields)
    if "f_drive_n" not in out and "f_applied_n" in out and not has_pressure:
        force = out.pop("f_applied_n")
        reason = (
            f"{force.reason}, since no pressure is logged; a load cell is f_applied_n, with the "
            "pressures under constants"
        )
        out["f_drive_n"] = replace(force, certainty=GUESS, reason=reason)
    return out


def _by_name(columns: Sequence[SampleColumn]) -> dict[str, Choice]:
    chosen: dict[str, Choice] = {}
    group: frozenset[str] = frozenset()
    for channel in _QUANTITIES:
        taken = {choice.column.key for choice in chosen.values()}
        rated = [(_points(c, channel, group), c) for c in columns if c.key not in taken]
        rated = [(points, c) for points, c in rated if points > 0]
        if not rated:
            continue
        best = max(points for points, _ in rated)
        equals = [c for points, c in rated if points > best - 0.1]
        column = max(equals, key=_travel) if channel == "x_m" else equals[0]
        if channel == "x_m":
            group = column.meaning.group
        chosen[channel] = _named_choice(column, channel, len(equals))
    return chosen | dict(_of_several_numbers(columns, chosen))


def _of_several_numbers(
    columns: Sequence[SampleColumn], chosen: Mapping[str, Choice]
) -> Iterator[tuple[str, Choice]]:
    """Yield the pressures whose side is a number, such as P1, where there are more than two."""
    numbered = [c for c in columns if c.meaning.quantity == "pressure" and is_numbered(c.name)]
    for channel in ("p_tp_pa", "p_tr_pa"):
        choice = chosen.get(channel)
        if len(numbered) > 2 and choice is not None and choice.column in numbered:
            others = ", ".join(c.name for c in numbered if c is not choice.column)
            reason = f"by its number; check, as there are also {others}"
            yield channel, replace(choice, certainty=GUESS, reason=reason)


def _points(column: SampleColumn, channel: str, group: frozenset[str]) -> float:
    means = column.meaning
    if column.name == channel:
        return _EXACT
    if means.channel == channel:
        points = _NAMED if means.is_sure else _SUGGESTED
    elif channel in ("p_tp_pa", "p_tr_pa") and means.quantity == "pressure" and not means.side:
        points = 1.0 if not means.is_reference else 0.0
    else:
        points = 0.0
    if not points:
        return 0.0
    points += _STATED * (column.unit is not None) + _WEAKER * means.is_weaker
    is_set = len(column.known) >= _MANY and len(np.unique(column.known)) <= _FEW
    if channel == "v_m_s" and is_set:
        return 0.0  # the nominal speeds of several runs
    if channel == "f_applied_n":
        points += _CONSTANT * is_set
    if channel == "u_t_v" and quantity_of(column.unit) != "valve":
        return 0.0  # a command in percent is no voltage
    if _QUANTITIES[channel] == "temperature" and not _is_plausible(column):
        return 0.0
    if channel not in ("p_tr_pa", "p_s_pa") and _QUANTITIES[channel] != "temperature":
        points += _CONSTANT * is_constant(column.known)
    if means.group and group:
        points += _SAME_GROUP if means.group & group else _OTHER_GROUP
    return points - _UNKNOWN_WORD * len(means.group - group)


def _is_plausible(column: SampleColumn) -> bool:
    """Return whether all values are possible temperatures of an oil."""
    known = parse_unit(column.unit or _temperature_unit(column)).to_si(column.known)
    return len(known) > 0 and LEAST["K"] <= known.min() and known.max() <= LIMITS["K"]


def _temperature_unit(column: SampleColumn) -> str:
    """Return the unit in which the values are usual temperatures of an oil."""
    median = float(np.median(column.known)) if len(column.known) else 0.0
    return "K" if median > _COLD_K else "degF" if median > _HOT_DEGC else "degC"


def _travel(column: SampleColumn) -> float:
    return max(float(np.nanmax(v) - np.nanmin(v)) for v in column.values)


def _named_choice(column: SampleColumn, channel: str, equals: int) -> Choice:
    certainty = SURE if column.meaning.is_sure and column.unit is not None else LIKELY
    reason = "by its unit" if column.meaning.by_unit else "by its name"
    if column.meaning.channel != channel and column.name != channel:
        certainty, reason = GUESS, f"{reason}, in the order of the columns"
    elif column.meaning.by_unit and _QUANTITIES[channel] == "pressure":
        certainty, reason = GUESS, "by its unit and the side in its name"
    elif not column.meaning.is_sure and column.name != channel:
        certainty = LIKELY if column.unit is not None else GUESS
    elif equals > 1:
        certainty = LIKELY
        reason += "; it moves most" if channel == "x_m" else ", the first of several"
    return Choice(column, column.unit or "", column.in_file, certainty, reason)


def _one_each(columns: Sequence[SampleColumn]) -> list[SampleColumn]:
    """Leave out constants, and all but the last column of each sensor, such as its volts."""
    kept: list[SampleColumn] = []
    for column in columns:
        if is_constant(column.known):
            continue
        kept = [
            other
            for other in kept
            if not all(map(are_proportional, other.values, column.values))
            or _travel(other) > _travel(column)
        ]
        if not any(all(map(are_proportional, o.values, column.values)) for o in kept):
            kept.append(column)
    return kept


def _by_data(
    columns: list[SampleColumn],
    time: TimeChoice,
    fields: Fields,
    chosen: Mapping[str, Choice],
) -> dict[str, Choice]:
    """Choose columns without a known name by what they do."""
    found: dict[str, Choice] = {}
    for channel, field in (("p_tp_pa", "pressure"), ("f_applied_n", "load")):
        for column in columns if channel not in chosen else []:
            unit = unit_of_levels(column, _QUANTITIES[channel], field, fields)
            if unit and len({values[field] for values in fields}) > 1:
                reason = f"has the {field} in the file names"
                found[channel] = Choice(column, unit, False, LIKELY, reason)
    rest = [c for c in columns if c.key not in {choice.column.key for choice in found.values()}]
    rest.sort(key=lambda c: max(map(roughness, time.t_s, c.values)))
    if rest and max(map(roughness, time.t_s, rest[0].values)) < _SMOOTH:
        found["x_m"] = Choice(rest.pop(0), "", False, GUESS, "the smoothest signal")
        x = found["x_m"].column
        for column in rest if "v_m_s" not in chosen else []:
            if all(map(velocity_factor, time.t_s, x.values, column.values)):
                found["v_m_s"] = Choice(column, "", False, LIKELY, "position is its integral")
                rest.remove(column)
                break
    known = {**chosen, **found}
    if len(rest) == 1 and "p_tp_pa" in known and "f_applied_n" not in known:
        found["f_applied_n"] = Choice(rest[0], "", False, GUESS, "the only column left")
    return found


def _with_units(chosen: dict[str, Choice], time: TimeChoice, fields: Fields) -> dict[str, Choice]:
    """Assume a unit where none is stated."""
    out = dict(chosen)
    for channel in ("x_m", *(c for c in chosen if c != "x_m")):
        choice = chosen.get(channel)
        if choice is None:
            continue
        if choice.column.name == channel and choice.column.unit is None:
            out[channel] = replace(choice, unit=CHANNELS[channel].unit)
        elif stated := _unusable_unit(channel, choice):
            unit = _USUAL_UNITS[_QUANTITIES[channel]]
            reason = f"{choice.reason}; {stated} in the file: give {unit} for each {stated}"
            out[channel] = replace(choice, unit=unit, scale=None, reason=reason)
        elif not choice.unit:
            unit, why = _assumed(channel, choice.column, out, time, fields)
            certainty = GUESS if choice.certainty == GUESS else LIKELY
            out[channel] = replace(
                choice, unit=unit, certainty=certainty, reason=f"{choice.reason}; {unit} {why}"
            )
    return out


def _unusable_unit(channel: str, choice: Choice) -> str:
    """Return the stated unit if it is unknown or of another quantity, such as a sensor's volts."""
    if choice.unit and quantity_of(choice.unit) != _QUANTITIES[channel]:
        return choice.unit
    return choice.column.unknown_unit


def _assumed(
    channel: str,
    column: SampleColumn,
    chosen: Mapping[str, Choice],
    time: TimeChoice,
    fields: Fields,
) -> tuple[str, str]:
    """Return a plausible unit and the reason."""
    largest = float(np.abs(column.known).max())
    if channel == "x_m":
        if unit := unit_of_travel(column, time.t_s, fields):
            return unit, "since it has the speed in the file names"
        return ("mm" if _travel(column) > 2 else "m"), "assumed from its range"
    if _QUANTITIES[channel] == "velocity" and "x_m" in chosen:
        for factor in _velocity_factors(column, chosen["x_m"], time):
            si = abs(factor) * parse_unit(chosen["x_m"].unit).factor
            unit = min(("m/s", "mm/s"), key=lambda u: abs(np.log(si / parse_unit(u).factor)))
            return unit, "since the position is its integral"
        return ("mm/s" if largest > 5 else "m/s"), "assumed from its range"
    for name in {"p_tp_pa": ["pressure"], "f_applied_n": ["load"]}.get(channel, []):
        if unit := unit_of_levels(column, _QUANTITIES[channel], name, fields):
            return unit, f"since it has the {name} in the file names"
    if _QUANTITIES[channel] == "pressure":
        if "x_m" in chosen and chosen["x_m"].unit == "in":
            return "psi", "assumed, with a position in inches"
        return ("Pa" if largest > 2e4 else "bar"), "assumed from its range"
    if _QUANTITIES[channel] == "force":
        if "x_m" in chosen and chosen["x_m"].unit in ANGLES:
            return "N m", "assumed, with an angle as position"
        pressures = [chosen[c] for c in ("p_tp_pa", "p_tr_pa") if c in chosen and chosen[c].unit]
        highest = max((_largest_si(choice) for choice in pressures), default=0.0)
        smallest_n = np.pi / 4 * _BORES_M[0] ** 2 * highest
        return ("kN" if largest < smallest_n else "N"), "assumed from its range"
    if _QUANTITIES[channel] == "temperature":
        return _temperature_unit(column), "assumed from its range"
    return _USUAL_UNITS[_QUANTITIES[channel]], "assumed"


def _velocity_factors(column: SampleColumn, position: Choice, time: TimeChoice) -> Iterator[float]:
    for t_s, x, v in zip(time.t_s, position.column.values, column.values, strict=True):
        if factor := velocity_factor(t_s, x, v):
            yield factor


def _largest_si(choice: Choice) -> float:
    return float(np.abs(choice.column.known).max()) * parse_unit(choice.unit).factor
