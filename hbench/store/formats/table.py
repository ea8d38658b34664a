"""What every reader returns: a table of columns, each perhaps with times of its own."""

from collections.abc import Iterable
from datetime import datetime
from typing import Protocol

import numpy as np


class Table(Protocol):
    """Columns of a foreign file, read on demand.

    A column is given by its name, path or number from 1. All methods raise ``DataError`` that names
    the file, and the columns that exist if one is missing.
    """

    @property
    def source(self) -> str:
        """Path of the file, for messages."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns at the top level."""

    @property
    def leaves_out_rows(self) -> bool:
        """Whether incomplete rows are a property of the format, to be left out with a note."""

    @property
    def short_lines(self) -> tuple[int, ...]:
        """Lines of the file that were left out because cells are missing."""

    @property
    def started(self) -> datetime | None:
        """Date-time from which ``own_times`` count, in UTC; None if the file states none."""

    def where(self, row: int) -> str:
        """Return a row's position in the file, for messages."""

    def lines_of(self, rows: np.ndarray) -> np.ndarray:
        """Return the line in the file, from 1, of each of ``rows`` (n,), from 0."""

    def columns(self) -> tuple[int | str, ...]:
        """Return all columns by name or path; by number where there is no unique name."""

    def position(self, column: int | str) -> int:
        """Return a column's index, from 0."""

    def prefetch(self, columns: Iterable[int | str]) -> None:
        """Read the numbers of columns together, where that is faster than one by one.

        Raises nothing: errors are raised when a column is read.
        """

    def unit(self, column: int | str) -> str | None:
        """Return a column's unit in the file; None if the file has no units."""

    def numbers(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) as floats; ``gaps`` allows NaN."""

    def date_times(self, column: int | str, *, gaps: bool = False) -> np.ndarray:
        """Return a column (n,) of date-times as datetime64 in UTC; ``gaps`` allows NaT."""

    def own_times(self, column: int | str) -> np.ndarray | None:
        """Return the times (n,) [s] that the file states for a column, or None.

        All columns count from the same instant.
        """
