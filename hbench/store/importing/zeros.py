"""Zero offsets: the mean of a sensor at rest before the motion, unless something acts on it."""

from collections.abc import Mapping

import numpy as np

from hbench.config.import_layout import ImportedCylinder
from hbench.config.import_map import ImportMap
from hbench.errors import DataError
from hbench.motion.rest import LEAST_REST_S, ZeroOffset, zero_offset
from hbench.store.importing.file_notes import FileNote
from hbench.units import from_si, to_si

_ZERO_TOLERANCE = 0.01  # of a channel's range in the file
_NO_ZERO = 0.02  # of a pressure's range in the file: a larger mean at rest is a pressure
# Zeros of load cells: mostly within 2 % of full scale; with the preload of a mounting within 10 %.
_USUAL_ZERO, _LARGEST_ZERO = 0.02, 0.1
_UNKNOWN_ZERO = 0.1  # of the largest force in the file, where the full scale is not known
_BY_FRICTION = 0.5  # of the pressures' force at rest, which friction may carry
_NO_REST = (
    "Write 'zero: none' in the map if the values have no offset, or give it as 'offset': a load "
    "may act on the sensor before the motion."
)


def zeroed(
    channels: Mapping[str, np.ndarray],
    rest: slice,
    source: str,
    cylinder: ImportedCylinder,
    rules: ImportMap,
) -> tuple[dict[str, np.ndarray], dict[str, ZeroOffset]]:
    """Subtract the zero offsets that the map asks for. Raises ``DataError`` without a true rest."""
    t_s, out, zeros = channels["t_s"], dict(channels), {}
    for key in (key for key, column in rules.columns.items() if column.zero == "rest"):
        zero = zero_offset(t_s[rest], channels[key][rest])
        if zero is None:
            raise DataError(
                f"{source}: {key}: no zero offset: less than {LEAST_REST_S:g} s at rest before the "
                "motion",
                _NO_REST,
            )
        tolerance = _zero_tolerance(channels[key], key, rules)
        if fault := _fault_of(zero, rules.unit(key), tolerance):
            raise DataError(f"{source}: {key}: no zero offset: {fault}", _NO_REST)
        if key.startswith("p_"):
            _refuse_pressure_at_rest(channels[key], zero, key, source, rules)
        out[key] = channels[key] - zero.mean
        zeros[key] = zero
    if "f_applied_n" in zeros:
        force = _pressure_force(out, cylinder)
        _refuse_load_at_rest(
            channels["f_applied_n"], force, rest, zeros["f_applied_n"], source, rules
        )
    return out, zeros


def _refuse_pressure_at_rest(
    values: np.ndarray, zero: ZeroOffset, key: str, source: str, rules: ImportMap
) -> None:
    """Raise ``DataError`` for a mean at rest beyond a sensor's error: a pressure may act there."""
    if rules.instruments is not None:
        limit, of = rules.instruments.pressure.largest, "the instrument's tolerance"
    else:
        limit = _NO_ZERO * float(max(np.nanmax(values), 0) - min(np.nanmin(values), 0))
        of = f"{100 * _NO_ZERO:g} % of its range"
    if abs(zero.mean) > limit:
        given = rules.columns[key].offset
        offset = (0.0 if given is None else to_si(given, "bar")) - zero.mean
        mean, most, needed = (from_si(value, "bar") for value in (zero.mean, limit, offset))
        raise DataError(
            f"{source}: {key}: no zero offset: at rest from {zero.start_s:.2f} to "
            f"{zero.stop_s:.2f} s it is {mean:.4g} bar; limit {most:.3g} bar, {of}",
            "Write 'zero: none' in the map if this pressure acts at rest; if the sensor is off by "
            f"it, give 'offset: {needed:.4g} bar' instead of 'zero: rest'.",
        )


def _pressure_force(
    channels: Mapping[str, np.ndarray], cylinder: ImportedCylinder
) -> np.ndarray | None:
    """Return P_Tp A_p - P_Tr A_r (n,), or None if a pressure or the cylinder is not known."""
    areas = {"p_tp_pa": cylinder.area_piston_m2, "p_tr_pa": -cylinder.area_rod_m2}
    acting = {key: area for key, area in areas.items() if area}
    if not acting or not acting.keys() <= channels.keys():
        return None
    return np.sum([area * channels[key] for key, area in acting.items()], axis=0)


def _refuse_load_at_rest(
    force_n: np.ndarray,
    pressure_force_n: np.ndarray | None,
    rest: slice,
    zero: ZeroOffset,
    source: str,
    rules: ImportMap,
) -> None:
    """Raise ``DataError`` if the load cell's mean at rest is a load rather than its zero offset.

    It is one beyond 10 % of the full scale. Beyond 2 % (without a full scale: 10 % of the largest
    force in the file) it is one if the pressures carry it but for friction, |F_T - F| <= |F_T| / 2.
    """
    unit, full = rules.unit("f_applied_n"), None
    carried = None if pressure_force_n is None else float(np.nanmean(pressure_force_n[rest]))
    if rules.instruments is not None:
        full = rules.instruments.force.full_scale
        suspect = _USUAL_ZERO * full
    else:
        both = [force_n] if pressure_force_n is None else [force_n, pressure_force_n]
        suspect = _UNKNOWN_ZERO * float(max(np.nanmax(np.abs(values)) for values in both))
    if full is not None and abs(zero.mean) > _LARGEST_ZERO * full:
        limit = f"limit {_LARGEST_ZERO * full:.4g} {unit}, {100 * _LARGEST_ZERO:g} %"
        reason = f"; {limit} of its full scale"
    elif (
        carried is not None
        and abs(zero.mean) > suspect
        and abs(carried - zero.mean) <= _BY_FRICTION * abs(carried)
    ):
        reason = f", and the pressures of the cylinder carry {carried:.4g} {unit}: a load acts"
    else:
        return
    given = rules.columns["f_applied_n"].offset
    offset = (0.0 if given is None else to_si(given, unit)) - zero.mean
    raise DataError(
        f"{source}: f_applied_n: no zero offset: at rest from {zero.start_s:.2f} to "
        f"{zero.stop_s:.2f} s it is {zero.mean:.4g} {unit}{reason}",
        "Write 'zero: none' in the map if this load acts at rest; if the load cell is off by it, "
        f"give 'offset: {offset:.4g} {unit}' instead of 'zero: rest'.",
    )


def subtraction(name: str, key: str, unit: str, zero: ZeroOffset) -> FileNote:
    """Return the note on a zero offset that was subtracted."""
    text = (
        f"{key}: zero offset {{mean}} {unit} subtracted (standard error {{se}} {unit}), the mean "
        "over a rest of {seconds} s"
    )
    numbers = {"mean": zero.mean, "se": zero.se, "seconds": round(zero.seconds, 2)}
    return FileNote(name, text, numbers)


def _zero_tolerance(values: np.ndarray, key: str, rules: ImportMap) -> float:
    """Return how far a sensor may change at rest: its tolerance, or else 1 % of its range here."""
    if rules.instruments is not None and key == "f_applied_n":
        return rules.instruments.force.largest
    if rules.instruments is not None and key.startswith("p_"):
        return rules.instruments.pressure.largest
    return _ZERO_TOLERANCE * float(np.nanmax(values) - np.nanmin(values))


def _fault_of(zero: ZeroOffset, unit: str, tolerance: float) -> str:
    """Return why a rest is none: a step, a trend or too much noise; empty if it is one."""
    limit = f"limit {tolerance:.3g} {unit}"
    when = f"at rest from {zero.start_s:.2f} to {zero.stop_s:.2f} s"
    if abs(zero.step) > tolerance:
        return f"{when} it steps by {zero.step:.4g} {unit} at {zero.step_at_s:.2f} s; {limit}"
    if abs(zero.trend) > tolerance:
        return f"{when} it drifts by {zero.trend:.4g} {unit}; {limit}"
    if zero.se > tolerance:
        return f"{when} its mean has a standard error of {zero.se:.3g} {unit}; {limit}"
    return ""
