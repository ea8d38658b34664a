"""A row of the catalogue of effects, and the rows that a user adds to it.

``HBENCH_EFFECTS=my_effects.py`` in the environment names a Python file with a table ``EFFECTS`` of
rows like those of ``catalogue.py``, where an example stands. They follow the catalogue's own, in
the table's order. The file's compiled functions, and those of files beside it, are compiled anew
when one of these files changes; what it imports from elsewhere must not have any.
"""

import importlib.util
import inspect
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from hbench.config.effects import Coefficient
from hbench.errors import ConfigError
from hbench.model.compiled import OWN_EFFECTS
from hbench.units import parse_unit

MOVING = ("openings", "oil", "flows", "friction")  # places in the equations of motion
_ARGUMENTS = {  # of a law, by its place
    **dict.fromkeys(MOVING, ("what", "c", "state", "at", "rates", "par")),
    **dict.fromkeys(("sensors", "board"), ("parameters", "c")),
}
HINT = "HBENCH_EFFECTS names this file; hbench/model/effects/catalogue.py begins with an example."


class Effect(NamedTuple):
    """A row of the catalogue."""

    says: str  # the law in words
    coefficients: dict[str, Coefficient]
    balances: tuple[str, ...]  # of reconcile/measured/balances.py, in which it shows
    laws: dict[str, Callable]  # by place
    states: int = 0
    builds_up: bool = False  # over many runs, so that a trial is not like the one before

    @property
    def of_sensor(self) -> bool:
        """Whether it is an error of what measures, not of the plant."""
        return not {"sensors", "board"}.isdisjoint(self.laws)


def own_effects(catalogue: Mapping[str, Effect]) -> dict[str, Effect]:
    """Return the user's rows; none without ``HBENCH_EFFECTS``. Raises ``ConfigError``."""
    if not OWN_EFFECTS:
        return {}
    rows = getattr(_imported(Path(OWN_EFFECTS)), "EFFECTS", None)
    if not isinstance(rows, dict) or not rows:
        raise ConfigError(f"{OWN_EFFECTS}: has no table EFFECTS = {{name: Effect(...)}}", HINT)
    balances = {name for row in catalogue.values() for name in row.balances}
    faults = []
    for name, row in rows.items():
        if not isinstance(name, str) or not name.isidentifier():
            faults.append(f"{name!r} can't name an effect")
        elif name in catalogue:
            faults.append(f"{name}: the catalogue has an effect of that name")
        else:
            faults += [f"{name}: {fault}" for fault in _faults(row, balances)]
    if faults:
        raise ConfigError("\n".join(f"{OWN_EFFECTS}: {fault}" for fault in faults), HINT)
    return rows


def _imported(path: Path) -> Any:
    if not path.is_file():
        raise ConfigError(f"{path}: no such file", HINT)
    spec = importlib.util.spec_from_file_location("hbench_own_effects", path)
    if spec is None or spec.loader is None:
        raise ConfigError(f"{path}: not a Python file; its name must end in .py", HINT)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise ConfigError(f"{path}: {type(error).__name__}: {error}", HINT) from error
    return module


def _faults(row: Any, balances: set[str]) -> list[str]:
    """Tell what is wrong with a row."""
    if not isinstance(row, Effect):
        return [f"is a {type(row).__name__}, not an Effect(...)"]
    faults = []
    if not isinstance(row.says, str):
        faults.append("its first field is the law in words")
    if not _is_mapping(row.coefficients, Coefficient):
        faults.append("its coefficients are a mapping {name: Coefficient(...)}")
    else:
        faults += [f"{key}: {f}" for key, c in row.coefficients.items() for f in _of(c)]
    if not isinstance(row.balances, tuple) or not row.balances or set(row.balances) - balances:
        faults.append(f"its balances are a tuple of some of {', '.join(sorted(balances))}")
    if not _is_mapping(row.laws, Callable):
        faults.append("its laws are a mapping {place: function}")
    else:
        faults += [f"{place}: {f}" for place, law in row.laws.items() for f in _at(place, law)]
    if type(row.states) is not int or row.states < 0:
        faults.append(f"states = {row.states!r}: a number of states is 0 or more")
    return faults


def _is_mapping(table: Any, kind: Any) -> bool:
    return (
        isinstance(table, dict)
        and bool(table)
        and all(isinstance(key, str) and isinstance(one, kind) for key, one in table.items())
    )


def _of(one: Coefficient) -> list[str]:
    try:
        parse_unit(one.unit)
        if one.low <= one.high and (one.typical == 0 or one.low <= one.typical <= one.high):
            return []
        return [f"typical = {one.typical:g} must be in low to high, {one.low:g} to {one.high:g}"]
    except (ValueError, TypeError, AttributeError) as error:
        return [str(error)]


def _at(place: str, law: Callable) -> list[str]:
    if place not in _ARGUMENTS:
        return [f"no such place; there are {', '.join(_ARGUMENTS)}"]
    if place in MOVING and not hasattr(law, "py_func"):
        return ["its function needs @compiled"]
    try:
        inspect.signature(getattr(law, "py_func", law)).bind(*_ARGUMENTS[place])
    except TypeError as error:
        return [f"its function is called with ({', '.join(_ARGUMENTS[place])}): {error}"]
    return []
