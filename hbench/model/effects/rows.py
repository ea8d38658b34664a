"""Rows of the catalogue of effects, and the rows that a user adds to it.

``HBENCH_EFFECTS=my_effects.py`` in the environment names a Python file with a table ``EFFECTS`` of
rows like those of ``catalogue.py``, whose docstring has an example. They follow the catalogue's
rows, in the order of their table. The compiled functions of that file and of files beside it are
compiled anew when one of these files changes; modules from elsewhere must contain none.
"""

import importlib.util
import inspect
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from hbench.config.effects import Coefficient
from hbench.errors import ConfigError
from hbench.model.compiled import OWN_EFFECTS
from hbench.model.effects.couplings import (
    ChamberFlows,
    FrictionTerms,
    OilProperties,
    Openings,
    PortFlows,
)
from hbench.model.parameters import PlantParameters
from hbench.units import parse_unit

FLOWS = ("flow_tp", "flow_tr", "flow_lp", "flow_lr")  # balances
FORCES = ("force_test", "force_load")
# Places in the equations of motion.
MOVING = ("openings", "oil", "ports", "flows", "friction")
_ARGUMENTS = {  # of a law, by its place
    **dict.fromkeys(MOVING, ("terms", "c", "state", "at", "rates", "par")),
    **dict.fromkeys(("sensors", "board"), ("parameters", "c")),
}
_STATES = 64  # more than a plant with all effects has
_FIRST = 20  # index of an effect's first state in a check, after the plant's own
# Terms of a check: no number is zero, so that a lost one shows.
_OPENED, _FLOWS = Openings(1.0, -2.0, 3.0), ChamberFlows(1e-4, -6e-5, 5e-5, -8e-5, 2e-4, 1e-4, 1.0)
_TERMS: dict[str, Any] = {
    "openings": _OPENED,
    "oil": OilProperties(2e5, 7e7, 6e7, 5e7, 4e7),
    "ports": PortFlows(_FLOWS, _OPENED, 1e5),
    "flows": _FLOWS,
    "friction": FrictionTerms(100.0, 200.0, 1.0, 2.0, 3.0, 4.0),
}
HINT = "HBENCH_EFFECTS names this file; hbench/model/effects/catalogue.py begins with an example."


class Separation(NamedTuple):
    """Run that separates two effects that look alike."""

    kind: str  # of experiment; see records/kinds.py
    why: str


class Effect(NamedTuple):
    """Row of the catalogue.

    The texts after ``builds_up`` are for the reader of a diagnosis and of the catalogue's page. An
    effect without them has only its description there.
    """

    description: str  # the law in words
    coefficients: dict[str, Coefficient]  # unit, typical size and bounds of each
    # Of reconcile/measured/balances.py that it changes; empty: reconcile does not look for it.
    balances: tuple[str, ...]
    laws: dict[str, Callable]  # by place
    states: int = 0
    builds_up: bool = False  # over many runs, so that trials differ
    alone: bool = False  # one coefficient is beyond its tolerance, the others are within theirs
    deflects: bool = False  # states: deflections of the test cylinder's seals, -1 to 1 in sliding
    law: str = ""  # formula, in the names of the coefficients
    signals: str = ""  # which move, and how: a sentence
    # Effects that look alike. Each pair is in one of its rows; ``lookalikes`` returns both ways.
    confused_with: Mapping[str, Separation] = MappingProxyType({})
    inspect: str = ""  # what confirms it at the bench: a noun phrase
    repair: str = ""  # what to do then: a sentence
    source: str = ""  # of the law

    @property
    def of_sensor(self) -> bool:
        """Whether it is an error of the instruments, not of the plant."""
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
            faults.append(f"{name!r} is no name of an effect")
        elif name in catalogue:
            faults.append(f"{name}: the catalogue already has an effect of this name")
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


def call_own(name: str, law: Callable, terms: Any, *arguments: Any) -> Any:
    """Call a user's law, uncompiled. Raises ``ConfigError`` where it fails."""
    where = f"{OWN_EFFECTS}: {name}: "
    try:
        changed = law(terms, *arguments)
    except Exception as error:
        raise ConfigError(f"{where}{type(error).__name__}: {error}", HINT) from None
    if type(changed) is not type(terms):
        wanted = type(terms).__name__
        raise ConfigError(f"{where}returns a {type(changed).__name__}; expected {wanted}", HINT)
    return changed


def check_neutral(rows: Mapping[str, Effect], par: PlantParameters) -> None:
    """Check that each law of ``rows`` changes nothing with its default coefficients.

    ``par`` is a plant with effects. Raises ``ConfigError``.
    """
    for name, row in rows.items():
        c = tuple(float(c.to_si(c.default)) for c in row.coefficients.values())
        for place in set(MOVING) & set(row.laws):
            terms, state, rates = _TERMS[place], np.zeros(_STATES), np.zeros(_STATES)
            where = f"{name}: {place}"
            after = call_own(where, row.laws[place], terms, c, state, _FIRST, rates, par)
            wrong = [f for f, a, b in zip(terms._fields, after, terms, strict=True) if a != b]
            if wrong:
                fault = f"changes {', '.join(wrong)} with its default coefficients"
                raise ConfigError(f"{OWN_EFFECTS}: {where}: {fault}", HINT)


def _faults(row: Any, balances: set[str]) -> list[str]:
    """Return the faults of a row."""
    if not isinstance(row, Effect):
        return [f"is a {type(row).__name__}, not an Effect(...)"]
    faults = []
    if not isinstance(row.description, str):
        faults.append("its first field, the description, is not a string")
    if not _is_mapping(row.coefficients, Coefficient):
        faults.append("its coefficients are no mapping {name: Coefficient(...)}")
    else:
        faults += [
            f"{key}: {f}" for key, c in row.coefficients.items() for f in _coefficient_faults(c)
        ]
    if not isinstance(row.balances, tuple) or not row.balances or set(row.balances) - balances:
        faults.append(f"its balances are no tuple of names among {', '.join(sorted(balances))}")
    if not _is_mapping(row.laws, Callable):
        faults.append("its laws are no mapping {place: function}")
    else:
        faults += [
            f"{place}: {f}" for place, law in row.laws.items() for f in _law_faults(place, law)
        ]
    for key in ("law", "signals", "inspect", "repair", "source"):
        if not isinstance(getattr(row, key), str):
            faults.append(f"{key} = {getattr(row, key)!r}; must be a string")
    pairs = row.confused_with
    if pairs and not _is_mapping(pairs, Separation):
        faults.append("its confused_with is no mapping {name: Separation(kind, why)}")
    if type(row.states) is not int or row.states < 0:
        faults.append(f"states = {row.states!r}; must be an integer of at least 0")
    return faults


def _is_mapping(table: Any, kind: Any) -> bool:
    return (
        isinstance(table, dict)
        and bool(table)
        and all(isinstance(key, str) and isinstance(value, kind) for key, value in table.items())
    )


def _coefficient_faults(c: Coefficient) -> list[str]:
    try:
        parse_unit(c.unit)
        if c.low <= c.high and (c.typical == 0 or c.low <= c.typical <= c.high):
            return []
        return [f"typical = {c.typical:g} must be in low to high, {c.low:g} to {c.high:g}"]
    except (ValueError, TypeError, AttributeError) as error:
        return [str(error)]


def _law_faults(place: str, law: Callable) -> list[str]:
    if place not in _ARGUMENTS:
        return [f"no such place; known are {', '.join(_ARGUMENTS)}"]
    if place in MOVING and not inspect.isfunction(law):
        return ["its function is not a plain Python function; remove its decorator"]
    try:
        inspect.signature(law).bind(*_ARGUMENTS[place])
    except TypeError as error:
        return [f"its function is called with ({', '.join(_ARGUMENTS[place])}): {error}"]
    return []
