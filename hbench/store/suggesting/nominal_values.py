"""Units of columns that have the nominal speed, load or pressure of the file names."""

from collections.abc import Mapping, Sequence

import numpy as np

from hbench.motion.plateaus import plateaus
from hbench.store.suggesting.quantities import Quantity, quantity_of
from hbench.store.suggesting.samples import SampleColumn
from hbench.units import parse_unit

Fields = Sequence[Mapping[str, float]]  # values in SI in the name of each file

_NEAR_NOMINAL = 0.15  # of a nominal value in a file's name
_MOST_FILES = 4  # whose speeds are determined
_OF_LEVELS = ("bar", "MPa", "kPa", "Pa", "psi", "N", "kN", "kgf", "lbf")
_OF_TRAVEL = ("mm", "m", "cm", "in")


def unit_of_levels(
    column: SampleColumn, quantity: Quantity, field: str, fields: Fields
) -> str | None:
    """Return the unit in which the medians of a column have the size of ``field``, or None."""
    nominal = np.array([values.get(field, np.nan) for values in fields])
    if not np.isfinite(nominal).all():
        return None
    medians = np.array([abs(float(np.nanmedian(v))) for v in column.values])
    for unit in _OF_LEVELS:
        if quantity_of(unit) == quantity:
            away = np.abs(medians * parse_unit(unit).factor - np.abs(nominal))
            if np.mean(away < _NEAR_NOMINAL * np.abs(nominal)) > 0.7:
                return unit
    return None


def unit_of_travel(column: SampleColumn, t_s: Sequence[np.ndarray], fields: Fields) -> str | None:
    """Return the unit in which a position moves at the speeds of the file names, or None."""
    files = [i for i, values in enumerate(fields) if values.get("speed")][:_MOST_FILES]
    for unit in _OF_TRAVEL if files else ():
        factor = parse_unit(unit).factor
        if all(_has_speed(t_s[i], column.values[i] * factor, fields[i]["speed"]) for i in files):
            return unit
    return None


def _has_speed(t_s: np.ndarray, x_m: np.ndarray, v_m_s: float) -> bool:
    """Return whether a motion has a section of the constant speed ``v_m_s``, either way."""
    if len(t_s) != len(x_m):
        return False
    known = np.isfinite(t_s) & np.isfinite(x_m)
    t, x = t_s[known], x_m[known]
    later = np.concatenate(([True], np.diff(t) > 0)) if len(t) else known[known]
    speeds = (abs(plateau.v_m_s) for plateau in plateaus(t[later], x[later]))
    return any(abs(speed - abs(v_m_s)) < _NEAR_NOMINAL * abs(v_m_s) for speed in speeds)
