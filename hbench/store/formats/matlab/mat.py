"""MATLAB files up to version 7."""

import io
from typing import Any, BinaryIO

from hbench.config.import_layout import Format
from hbench.store.files.bounded_read import read_whole
from hbench.store.formats.arrays import Arrays, Names, by_name
from hbench.store.formats.matlab.mat_sizes import check_mat_sizes
from hbench.store.formats.matlab.recordings import recorded_signals


def open_mat(file: BinaryIO, source: str, layout: Format) -> Arrays:
    """Return the variables of a file; recorded signals have names and times of their own.

    Raises ``DataError``.
    """
    variables = read_mat(read_whole(file, source), source)
    signals = list(recorded_signals(variables))
    named, recorded = by_name(signals), {variable for variable, _, _ in signals}
    listed = {name: value for name, value in variables.items() if name not in recorded}
    other = {name: variables[name] for name in recorded}
    names = Names({**listed, **named.listed}, {**other, **named.other})
    return Arrays(names, source, "Save tables and timetables in MATLAB with '-v7.3'.")


def read_mat(data: bytes, source: str) -> dict[str, Any]:
    """Return a MATLAB file's variables; structs are dicts. Raises ``DataError``."""
    from scipy.io import loadmat

    check_mat_sizes(data, source)
    content = loadmat(io.BytesIO(data), simplify_cells=True)
    return {name: value for name, value in content.items() if name and not name.startswith("__")}
