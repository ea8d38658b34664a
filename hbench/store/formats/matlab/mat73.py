"""MATLAB files of version 7.3, which are HDF5 files."""

from typing import Any, BinaryIO

from hbench.config.import_layout import Format
from hbench.store.formats.arrays import Arrays, Names, by_name
from hbench.store.formats.matlab.hdf5 import Group, cells, channel_of, class_of
from hbench.store.formats.matlab.simulink import simulink_signals
from hbench.store.formats.matlab.tables import ObjectReader

_HDF5 = b"\x89HDF\r\n\x1a\n"
_STARTS = (0, 512, 1024, 2048)  # where HDF5 may begin; MATLAB's header takes 512 bytes
_DEEPEST = 50  # nested structs
_MOST = 20_000  # variables and fields


def is_mat73(head: bytes) -> bool:
    """Return whether a file that begins with ``head`` is of version 7.3."""
    return any(head.startswith(_HDF5, start) for start in _STARTS)


def open_mat73(file: BinaryIO, source: str, layout: Format) -> Arrays:
    """Return the variables of a file, read one by one; timetables have times of their own.

    Raises ``DataError``.
    """
    import h5py

    content = Group(h5py.File(file, "r"), h5py)
    signals = by_name(simulink_signals(content))
    variables = _Variables(content).read()
    return Arrays(
        Names({**variables, **signals.listed}, signals.other),
        source,
        "Variables without a size are not numeric, or of a class that is not read.",
    )


class _Variables:
    """Reader of an HDF5 file's variables, without their samples."""

    def __init__(self, content: Group):
        self._content = content
        self._objects = ObjectReader(content) if "#subsystem#/MCOS" in content else None
        self._left = _MOST

    def read(self) -> dict[str, Any]:
        """Return the variables: structs are dicts, struct arrays lists."""
        nodes = self._content.items()
        return {name: self._value(node, 0) for name, node in nodes if not name.startswith("#")}

    def _value(self, node: Any, depth: int) -> Any:
        """Return a variable or field; None if it can't be a channel."""
        self._left -= 1
        if self._left < 0 or depth > _DEEPEST:
            raise ValueError(f"more than {_MOST} fields, or nested deeper than {_DEEPEST}")
        if isinstance(node, Group):
            return self._struct(dict(node), depth)
        is_object, value = self._objects.read(node) if self._objects else (False, None)
        return value if is_object else channel_of(node)

    def _struct(self, fields: dict[str, Any], depth: int) -> Any:
        # The fields of a struct array are references without a class.
        is_array = fields and not any(isinstance(f, Group) or class_of(f) for f in fields.values())
        if not is_array:
            return {name: self._value(node, depth + 1) for name, node in fields.items()}
        elements = zip(*(cells(self._content, node) for node in fields.values()), strict=True)
        return [
            {name: self._value(node, depth + 1) for name, node in zip(fields, row, strict=True)}
            for row in elements
        ]
