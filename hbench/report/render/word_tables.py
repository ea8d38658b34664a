"""Tables and headline numbers, in words and numbers as they are shown."""

from dataclasses import dataclass, replace


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
