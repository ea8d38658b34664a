"""Tables and headline numbers, in words and numbers as they are shown."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from hbench.records import WordTable


@dataclass(frozen=True)
class Cell:
    """Cell of a table; ``flag`` is a remark that the page shows beside its text."""

    text: str
    flag: str = ""
    link: str = ""  # target of its text, relative to the page


@dataclass(frozen=True)
class Table:
    """Table as it is printed. Numeric columns are those not in ``words``."""

    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    words: frozenset[str]
    messages: tuple[str, ...] = ()
    title: str = ""
    sortable: bool = False  # by a click on a head of the page


AnyTable = TypeVar("AnyTable", WordTable, Table)


def with_columns(table: AnyTable, kept: Sequence[int]) -> AnyTable:
    """Return the columns of a table with these numbers, from 0."""
    rows = tuple(tuple(row[i] for i in kept) for row in table.rows)
    return replace(table, head=tuple(table.head[i] for i in kept), rows=rows)


def titled(table: Table, title: str) -> tuple[Table, ...]:
    """Return a table with a title; nothing where it has no rows."""
    return (replace(table, title=title),) if table.rows else ()


@dataclass(frozen=True)
class Tile:
    """Headline number at the top of a page."""

    value: str
    unit: str
    more: str = ""
    how: str = ""  # anchor of the method that computes it
