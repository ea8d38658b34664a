"""Signals of Simulink in a MATLAB 7.3 file: a Dataset of the Simulation Data Inspector.

A struct ``Values`` describes each signal. Its field ``DataR2`` is the number of the stream
``#sigstream#/<number>/#data#`` that contains the samples as bytes; the times are those of the
stream ``TimeR2``, or ``CompressedTime``: start, step and count.
"""

from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from hbench.store.formats.arrays import Signal
from hbench.store.formats.matlab.hdf5 import Group, cells, is_empty, text

_STREAMS = "#sigstream#"
_UNITS = {"seconds": 1.0, "milliseconds": 1e-3, "minutes": 60.0, "hours": 3600.0, "days": 86400.0}
_TYPES = {"logical": "u1", "boolean": "u1", "single": "f4", "double": "f8"} | {
    f"{sign}int{bits}": f"{kind}{bits // 8}"
    for sign, kind in (("", "i"), ("u", "u"))
    for bits in (8, 16, 32, 64)
}


def simulink_signals(content: Group) -> Iterator[tuple[str, str, Signal]]:
    """Yield block, name and samples of each signal in an HDF5 file; only of scalar signals."""
    if _STREAMS not in content:
        return
    for element in content["#refs#"].values():
        values = element.get("Values") if isinstance(element, Group) else None
        if values is None or "DataR2" not in values:
            continue
        with suppress(KeyError, ValueError):  # stored otherwise: the others may be readable
            signal = _signal(content, values)
            if signal is not None:
                # Simulink encloses names that come from a block upstream.
                name = text(values["Name"]).removeprefix("<").removesuffix(">")
                yield _block(content, element), name, signal


def _signal(content: Group, values: Any) -> Signal | None:
    kind = np.dtype(_TYPES.get(text(values["SignalAttributes/ClassName"]), "V"))
    factor = _UNITS.get(text(values["TimeUnits/Value"]))
    stream, size = _stream(content, values["DataR2"], kind)
    regular, times = values["CompressedTime"], values["TimeR2"]
    if stream is None or factor is None:
        return None

    def read_times() -> np.ndarray:
        if not is_empty(regular):
            start, step, count = regular[()].ravel()
            return factor * (start + step * np.arange(int(count)))
        times_stream, _ = _stream(content, times, np.dtype("f8"))
        return factor * times_stream[()].view("f8")

    return Signal(
        size,
        lambda: stream[()].view(kind),
        None if is_empty(regular) and is_empty(times) else read_times,
        text(values["DataUnits/Value"]) or None,
    )


def _stream(content: Group, number: Any, kind: np.dtype) -> tuple[Any, int]:
    """Return the bytes of a stream of scalars and their count; None for other streams."""
    if is_empty(number):
        return None, 0
    stream = content[f"{_STREAMS}/{int(number[()].item())}"]
    data = stream["#data#"]
    if not kind.itemsize or stream["#sampleSize#"][()].item() != kind.itemsize:
        return None, 0
    return data, data.size // kind.itemsize


def _block(content: Group, element: Any) -> str:
    path = cells(content, element["BlockPath"]) if "BlockPath" in element else []
    return text(path[0]) if path else "signals"
