"""A user's own laws tried alone, so that what can't be used is told in words of their file.

Inside the plant the same fault would be an error of the plant's code, pages long.
"""

import re
from collections.abc import Callable, Mapping
from math import isclose
from pathlib import Path
from typing import Any

import numpy as np

from hbench.errors import ConfigError
from hbench.model.compiled import OWN_EFFECTS
from hbench.model.effects.couplings import Flows, Oil, Openings, Rubbing
from hbench.model.effects.rows import HINT, MOVING, Effect
from hbench.model.parameters import PlantParameters

_STATES = 64  # more than a plant has, with all effects
_FRAME = ("Failed in", "During:", "File", "<source", "---", "raised")  # of numba's messages
_FIRST = 20  # of them that is an effect's: after the plant's own
# What a law is given: no number is zero, so that it does not hide that one is lost.
_WHAT: dict[str, Any] = {
    "openings": Openings(1.0, -2.0, 3.0),
    "oil": Oil(2e5, 7e7, 6e7, 5e7, 4e7),
    "flows": Flows(1e-4, -6e-5, 5e-5, -8e-5, 2e-4, 1e-4, 1.0),
    "friction": Rubbing(100.0, 200.0, 1.0, 2.0, 3.0, 4.0),
}


def try_laws(rows: Mapping[str, Effect], par: PlantParameters) -> None:
    """Compile and call each law of ``rows`` with its default coefficients.

    ``par`` is a plant with effects. Raises ``ConfigError`` where one can't be compiled, or does not
    hand back what it was given.
    """
    for name, row in rows.items():
        c = tuple(float(one.to_si(one.default)) for one in row.coefficients.values())
        for place in MOVING:
            if place in row.laws:
                _try(f"{name}: {place}", row.laws[place], _WHAT[place], c, par)


def try_parameters(name: str, law: Callable, what: Any, c: tuple[float, ...]) -> Any:
    """Return what a user's law makes of parameters. Raises ``ConfigError`` where it fails."""
    try:
        found = law(what, c)
    except Exception as error:
        raise _refused(name, f"{type(error).__name__}: {error}") from None
    if type(found) is not type(what):
        wanted = type(what).__name__
        raise _refused(name, f"returns a {type(found).__name__}; expected a {wanted}")
    return found


def _try(where: str, law: Callable, what: Any, c: tuple[float, ...], par: Any) -> None:
    from numba.core.errors import NumbaError

    state, rates = np.zeros(_STATES), np.zeros(_STATES)
    try:
        found = law(what, c, state, _FIRST, rates, par)
    except NumbaError as error:
        raise _refused(where, f"can't be compiled: {_reason(str(error))}") from None
    except Exception as error:
        raise _refused(where, f"{type(error).__name__}: {error}") from None
    if type(found) is not type(what):
        wanted = type(what).__name__
        raise _refused(where, f"returns a {type(found).__name__}; expected {wanted}(...)")
    names = [key for key, a, b in zip(what._fields, found, what, strict=True) if not isclose(a, b)]
    if names:
        raise _refused(where, f"changes {', '.join(names)} with its default coefficients")


def _refused(where: str, why: str) -> ConfigError:
    return ConfigError(f"{OWN_EFFECTS}: {where}: {why}", HINT)


def _reason(message: str) -> str:
    """Return the sentence of numba's message that tells the fault, with the line."""
    lines = [line.strip() for line in re.sub(r"\x1b\[[0-9;]*m", "", message).splitlines()]
    told = [line for line in lines if line and not line.startswith(_FRAME)]
    places = re.findall(r'File "([^"]*)", line (\d+)', message)
    own = [number for file, number in places if Path(file).name == Path(OWN_EFFECTS).name]
    line = f"line {own[-1]}: " if own else ""
    return line + (told[0] if told else "numba does not tell why")
