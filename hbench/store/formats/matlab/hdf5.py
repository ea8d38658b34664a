"""Values in a MATLAB 7.3 file: how MATLAB stores its arrays in HDF5.

Dimensions are in reverse order, so that the flat order is MATLAB's. The attribute ``MATLAB_class``
is the class; a cell array contains references.
"""

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from hbench.store.formats.arrays import Matrix, Signal


class Group(Mapping[Any, Any]):
    """Group of an HDF5 file; keys are paths and references.

    Links and datasets can lead to other files, which are not read: such a link is missing here
    (``KeyError``), such a dataset raises ``ValueError``.
    """

    def __init__(self, group: Any, h5py: Any):
        self._group = group
        self._h5py = h5py
        self.attrs = group.attrs

    def __getitem__(self, key: Any) -> Any:
        node = self._group
        if isinstance(key, str):
            for name in key.split("/"):
                if not self._is_inside(node, name):
                    raise KeyError(key)
                node = node[name]
        else:
            node = node[key]
        if isinstance(node, self._h5py.Group):
            return Group(node, self._h5py)
        if node.external or node.is_virtual:
            raise ValueError(f"{node.name} contains data of another file")
        return node

    def __iter__(self) -> Iterator[str]:
        return (name for name in self._group if self._is_inside(self._group, name))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def _is_inside(self, node: Any, name: str) -> bool:
        return isinstance(node.get(name, getlink=True), self._h5py.HardLink)


def channel_of(
    dataset: Any, times: Callable[[], np.ndarray] | None = None, unit: str | None = None
) -> Signal | Matrix | None:
    """Return a numeric vector or matrix, with the ``times`` of its rows; None for other arrays."""
    if is_empty(dataset) or dataset.dtype.kind not in "fiu" or class_of(dataset) == "char":
        return None
    if dataset.size == max(dataset.shape):
        return Signal(dataset.size, lambda: dataset[()].ravel(), times, unit)
    if dataset.ndim != 2:
        return None
    columns, rows = dataset.shape
    return Matrix(
        (rows, columns), lambda column: Signal(rows, lambda: dataset[column], times, unit)
    )


def class_of(node: Any) -> str:
    """Return the MATLAB class of a dataset or group; empty if it has none."""
    name = node.attrs.get("MATLAB_class", b"")
    return name.decode() if isinstance(name, bytes) else str(name)


def is_empty(dataset: Any) -> bool:
    """Return whether an array has no elements; its dataset contains the dimensions then."""
    return bool(dataset.attrs.get("MATLAB_empty", 0)) or not dataset.size


def text(dataset: Any) -> str:
    """Return a char array as a string."""
    return "" if is_empty(dataset) else "".join(map(chr, dataset[()].ravel()))


def cells(content: Any, dataset: Any) -> list[Any]:
    """Return the elements of a cell array, or of a field of a struct array."""
    if is_empty(dataset) or dataset.dtype.kind != "O":
        return []
    return [content[reference] for reference in dataset[()].ravel()]


def texts(content: Any, dataset: Any) -> list[str]:
    """Return a cell array of char arrays."""
    return [text(cell) for cell in cells(content, dataset)]
