"""Objects of MATLAB classes in a MATLAB 7.3 file, such as tables, timetables and date-times.

A variable of a class refers to an object of the file's object store, ``#subsystem#/MCOS``: cells
of which the first describes all objects and the others are values of properties. The description is
a sequence of 32-bit integers: version, number of names, eight offsets of regions; the names; then

- classes (region 1): numbers of namespace and name, 0, 0
- objects (region 3): class, 0, 0, number of the saved and of the ordinary properties, 0
- saved (region 2) and ordinary properties (region 4): per object the count and, for each property,
  the number of its name, its type and its value, padded to 8 bytes. Type 1 is a cell.

MathWorks has not published this layout; it was described by readers such as ``mat-io``.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from hbench.store.formats.matlab.hdf5 import Group

_MAGIC = 0xDD000000  # begins a reference to an object
_CELL = 1  # type of a property whose value is a cell
_FIRST_VALUE = 2  # cells before the values of properties


class ObjectStore:
    """The objects of an HDF5 file ``content``. Raises ``ValueError`` and others if damaged."""

    def __init__(self, content: Group):
        self._content = content
        self._cells = content["#subsystem#/MCOS"][()].ravel()
        data = content[self._cells[0]][()].tobytes()
        offsets = np.frombuffer(data, "<u4", 10)[2:]
        self._names = data[40 : offsets[0]].decode().split("\0")
        regions = [
            np.frombuffer(data[start:stop], "<u4")
            for start, stop in zip(offsets[:4], offsets[1:5], strict=True)
        ]
        self._classes = regions[0].reshape(-1, 4)
        self._objects = regions[2].reshape(-1, 6)
        self._saved, self._ordinary = list(_properties(regions[1])), list(_properties(regions[3]))

    def find(self, dataset: Any) -> tuple[str, dict[str, Any]] | None:
        """Return class and properties (HDF5 objects) of what ``dataset`` refers to.

        None if it refers to no object, or to an array of several.
        """
        if dataset.dtype != np.uint32 or dataset.size != 6:
            return None
        reference = dataset[()].ravel()
        if reference[0] != _MAGIC:
            return None
        class_number, _, _, saved, ordinary, _ = self._objects[reference[4]]
        properties = self._saved[saved] if saved else self._ordinary[ordinary]
        name = self._names[self._classes[class_number, 1] - 1]
        return name, {
            self._names[key - 1]: self._content[self._cells[_FIRST_VALUE + value]]
            for key, kind, value in properties
            if kind == _CELL
        }


def _properties(region: np.ndarray) -> Iterator[np.ndarray]:
    """Yield name, type and value (n, 3) of the properties of each object."""
    at = 0
    while at < len(region):
        count = int(region[at])
        yield region[at + 1 : at + 1 + 3 * count].reshape(-1, 3)
        at += 1 + 3 * count
        at += at % 2
