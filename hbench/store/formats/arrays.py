"""Table of arrays and signals, by name or by a path in MATLAB's notation."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import Any, NamedTuple

import numpy as np

from hbench.errors import DataError
from hbench.store.files.bounded_read import LARGEST_UNPACKED
from hbench.store.formats.barrier import reader_errors

# One step of a path: a name, then (k) for an element or (:,k) for a column, from 1.
_STEP = re.compile(r"(\w+)(?:\((?:\s*([1-9]\d{,8})\s*|\s*:\s*,\s*([1-9]\d{,8})\s*)\))?")
_FEW = 40  # columns that a message lists


@dataclass(frozen=True)
class Signal:
    """A channel of a file, read on demand."""

    size: int  # samples
    read: Callable[[], np.ndarray]  # the samples (n,)
    times: Callable[[], np.ndarray] | None = None  # (n,) [s], from an instant common to the file
    unit: str | None = None

    @property
    def shape(self) -> tuple[int]:
        """Shape of the samples."""
        return (self.size,)


@dataclass(frozen=True)
class Matrix:
    """Columns of a file, read on demand."""

    shape: tuple[int, int]
    column: Callable[[int], Signal]  # from 0

    @property
    def ndim(self) -> int:
        """Two."""
        return len(self.shape)

    def __getitem__(self, index: tuple[slice, int]) -> Signal:
        if not 0 <= index[1] < self.shape[1]:
            raise IndexError(index[1])
        return self.column(index[1])


def by_name(signals: Iterable[tuple[str, str, Signal]]) -> "Names":
    """Return channels, each given with its group's and its own name, by the names of a map.

    A channel is found as ``group/name``, and as ``name`` if no other channel has this name.
    """
    signals = list(signals)
    uses = Counter(name for _, name, _ in signals)
    shown: dict[str, Signal] = {}
    full: dict[str, Signal] = {}
    for group, name, signal in signals:
        path, number = f"{group}/{name}", 1
        while path in full:  # groups of the same name
            number += 1
            path = f"{group}/{name} ({number})"
        full[path] = shown[name if uses[name] == 1 else path] = signal
    return Names(shown, full)


class Names(NamedTuple):
    """Contents of a file by the names that messages list, and by other names."""

    listed: Mapping[str, Any]
    other: Mapping[str, Any] = {}


class Arrays:
    """Table of arrays and signals, by name or by a path in MATLAB's notation.

    ``names`` are the contents of the file; ``hint`` explains the names if one is not found;
    ``started`` is the date-time from which the signals' times count.
    """

    leaves_out_rows = False
    short_lines: tuple[int, ...] = ()

    def __init__(
        self,
        names: Names | Mapping[str, Any],
        source: str,
        hint: str = "",
        started: datetime | None = None,
    ):
        names = names if isinstance(names, Names) else Names(names)
        self._root, self._other = names
        self._hint = hint
        self._unread = LARGEST_UNPACKED // 8  # samples of signals
        self.source = source
        self.started = started
        self.names = tuple(self._root)

    def where(self, row: int) -> str:
        """Return a row's position in the file, for messages."""
        return f"sample {row + 1}"

    def lines_of(self, rows: np.ndarray) -> np.ndarray:
        """Return the numbers from 1 of ``rows`` (n,), from 0."""
        return rows + 1

    def unit(self, column: int | str) -> str | None:
        """Return a signal's unit in the file; None if the file has no units."""
        found = self._lookup(column)
        return found.unit if isinstance(found, Signal) else None

    def columns(self) -> tuple[int | str, ...]:
        """Return the paths of all columns; of a struct array, those of its first element."""
        return tuple(_columns(self._root))

    def position(self, column: int | str) -> int:
        """Return a column's index, from 0. Raises ``DataError``."""
        if column not in self.names:
            raise self._missing(column)
        return self.names.index(column)

    def prefetch(self, columns: Iterable[int | str]) -> None:
        """Do nothing: columns are read one by one."""

    def numbers(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) as floats; ``gaps`` allows NaN. Raises ``DataError``."""
        values = self._values(column)
        if values.ndim != 1 or values.dtype.kind not in "fiu":
            raise self._not_a_column(column, values.shape, str(values.dtype))
        values = values.astype(float, copy=False)
        bad = np.flatnonzero(np.isinf(values) if gaps else ~np.isfinite(values))
        if len(bad):
            raise DataError(
                f"{self.source}: {self.where(bad[0])}: column {column}: is {values[bad[0]]}; "
                "expected a number"
            )
        return values

    def date_times(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) of date-times as datetime64; ``gaps`` allows NaT."""
        values = self._values(column)
        if values.dtype.kind != "M" or (not gaps and np.isnat(values).any()):
            raise DataError(
                f"{self.source}: column {column}: contains no date-times",
                "In MATLAB, write posixtime(t) to a column in s; a datenum has the unit d.",
            )
        return values

    def own_times(self, column: int | str) -> np.ndarray | None:
        """Return the times (n,) [s] that the file states for a signal, or None."""
        found = self._lookup(column)
        if not isinstance(found, Signal) or found.times is None:
            return None
        with reader_errors(f"{self.source}: column {column}"):
            return found.times()

    def _values(self, column: int | str) -> np.ndarray:
        found = self._lookup(column)
        if found is None:
            raise self._not_a_column(column, (), "not numeric")
        if isinstance(found, Matrix):
            raise self._not_a_column(column, found.shape, "matrix")
        if not isinstance(found, Signal):
            return np.atleast_1d(np.asarray(found))
        self._unread -= found.size
        if self._unread < 0:
            raise DataError(
                f"{self.source}: the mapped channels take more than {LARGEST_UNPACKED / 1e6:g} MB",
                "Map fewer channels, or split the file.",
            )
        with reader_errors(f"{self.source}: column {column}"):
            return np.atleast_1d(found.read())

    def _lookup(self, column: int | str) -> Any:
        if isinstance(column, int):
            return self._matrix_column(column)
        for names in (self._root, self._other):
            if column in names:
                return names[column]
        at: Any = {**self._other, **self._root}
        for step in column.split("."):
            match = _STEP.fullmatch(step.strip())
            if match is None or not isinstance(at, Mapping) or match[1] not in at:
                raise self._missing(column)
            at = at[match[1]]
            try:
                at = at[int(match[2]) - 1] if match[2] else at
                if match[3]:
                    at = (at if isinstance(at, Matrix) else np.atleast_2d(at))[:, int(match[3]) - 1]
            except (IndexError, KeyError, TypeError):
                raise self._missing(column) from None
        return at

    def _matrix_column(self, column: int) -> Any:
        matrices = {k: v for k, v in self._root.items() if np.ndim(v) == 2}
        if len(matrices) != 1:
            raise DataError(
                f"{self.source}: column {column}: the file contains {len(matrices)} matrices, "
                f"expected 1; it contains: {self._listed()}",
                "Write the matrix's name too, as in M(:,3).",
            )
        matrix = next(iter(matrices.values()))
        if column > matrix.shape[1]:
            raise DataError(f"{self.source}: no column {column}; the last is {matrix.shape[1]}")
        return matrix[:, column - 1]

    def _not_a_column(self, column: int | str, shape: tuple[int, ...], kind: str) -> DataError:
        size = "x".join(map(str, shape)) or "1"
        return DataError(
            f"{self.source}: column {column}: is {size} of type {kind}; expected a column of "
            "numbers",
            "Write M(:,3) for a column of a matrix, runs(2) for an element of a struct array.",
        )

    def _missing(self, column: int | str) -> DataError:
        return DataError(
            f"{self.source}: no column {column!r}; the file contains: {self._listed()}",
            self._hint,
        )

    def _listed(self) -> str:
        paths = list(_paths(self._root))
        more = f" and {len(paths) - _FEW} more" if len(paths) > _FEW else ""
        return (", ".join(paths[:_FEW]) or "no readable variable") + more


def _paths(root: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    for name, value in root.items():
        path = prefix + name
        if isinstance(value, Mapping):
            yield from _paths(value, f"{path}.")
        elif isinstance(value, (list, np.ndarray)) and _structs(value):
            yield from _paths(value[0], f"{path}(1..{len(value)}).")
        else:
            shape = "x".join(map(str, np.shape(value)))
            yield f"{path} ({shape})" if shape else path


def _columns(root: Mapping[str, Any], prefix: str = "") -> Iterator[str]:
    for name, value in root.items():
        path = prefix + name
        shape: tuple[int, ...] = getattr(value, "shape", ())
        if isinstance(value, Mapping):
            yield from _columns(value, f"{path}.")
        elif isinstance(value, (list, np.ndarray)) and _structs(value):
            yield from _columns(value[0], f"{path}(1).")
        elif len(shape) == 1:
            yield path
        elif len(shape) == 2 and shape[1] <= min(shape[0], _FEW):
            yield from (f"{path}(:,{number})" for number in range(1, shape[1] + 1))


def _structs(value: list | np.ndarray) -> bool:
    return len(value) > 0 and isinstance(value[0], Mapping)
