"""Signals with names and times in MATLAB structs, as other programs write them.

Simulink's structure with time has the fields ``time`` and ``signals``, a struct array of ``label``
and ``values``. A recording of dSPACE ControlDesk has ``X`` and ``Y``, struct arrays of ``Name``,
``Unit`` and ``Data``: ``X`` are the times, and ``XIndex`` of a signal is the number of its own.
"""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from hbench.store.formats.arrays import Signal


def recorded_signals(variables: Mapping[str, Any]) -> Iterator[tuple[str, str, Signal]]:
    """Yield variable, name and samples of each signal; its path is the name of one without."""
    for variable, value in variables.items():
        if isinstance(value, Mapping):
            for name, signal in (*_of_simulink(variable, value), *_of_dspace(variable, value)):
                yield variable, name, signal


def _of_simulink(variable: str, struct: Mapping[str, Any]) -> Iterator[tuple[str, Signal]]:
    t_s: Any = struct.get("time")
    for path, each in _structs(f"{variable}.signals", struct.get("signals")):
        values: Any = each.get("values")
        if _is_column(values, t_s):
            yield _text(each.get("label")) or f"{path}.values", _signal(values, t_s)
        elif _is_column(t_s) and np.ndim(values) == 2 and len(values) == len(t_s):
            for number, column in enumerate(np.transpose(values), start=1):
                if _is_column(column, t_s):
                    yield f"{path}.values(:,{number})", _signal(column, t_s)


def _of_dspace(variable: str, struct: Mapping[str, Any]) -> Iterator[tuple[str, Signal]]:
    times = [each.get("Data") for _, each in _structs("", struct.get("X"))]
    for path, each in _structs(f"{variable}.Y", struct.get("Y")):
        values: Any = each.get("Data")
        number = each.get("XIndex", 1)
        own = (
            times[number - 1 : number]
            if isinstance(number, (int, np.integer)) and number > 0
            else []
        )
        t_s = next((t_s for t_s in (*own, *times) if _is_column(values, t_s)), None)
        if t_s is not None:
            name = _text(each.get("Name")) or f"{path}.Data"
            yield name, _signal(values, t_s, _text(each.get("Unit")))


def _structs(path: str, value: Any) -> list[tuple[str, Mapping[str, Any]]]:
    """Return the elements of a struct array, or a struct, with their paths."""
    if isinstance(value, Mapping):
        return [(path, value)]
    if not (isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object)):
        return []
    elements = enumerate(value, start=1)
    return [(f"{path}({k})", each) for k, each in elements if isinstance(each, Mapping)]


def _is_column(values: Any, like: Any = None) -> bool:
    """Return whether a value is a column of numbers (n,), as long as another one."""
    is_array = isinstance(values, np.ndarray) and values.ndim == 1 and values.dtype.kind in "fiu"
    return is_array and (like is None or (_is_column(like) and len(values) == len(like)))


def _text(value: Any) -> str:
    return value.strip() if isinstance(value, str) else ""


def _signal(values: np.ndarray, t_s: np.ndarray, unit: str = "") -> Signal:
    return Signal(len(values), lambda: values, lambda: t_s.astype(float), unit or None)
