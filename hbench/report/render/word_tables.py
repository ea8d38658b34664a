"""Tables of words with what a reader must not miss about a cell."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Cell:
    """A cell of a table; ``flag`` is what a reader must not miss about it."""

    text: str
    flag: str = ""
    link: str = ""  # where its text leads to, relative to the page


@dataclass(frozen=True)
class Table:
    """A table as it is printed. Numeric columns are those not in ``words``."""

    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    words: frozenset[str]
    messages: tuple[str, ...] = ()
    title: str = ""
