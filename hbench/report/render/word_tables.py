"""Tables and headline numbers, in words and numbers as they are shown."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from hbench.records import WordTable
from hbench.report.render.symbols import numbers_kept

_NUMBER = re.compile(
    r"(< )?[-+−±]?\d[\d.,e+−-]*( [±%] ?[\d.]*)?( \((\d[\d.]*|none)\))?"
    r"|[-–]|none|not significant|cancels|"
)
_DIGIT = re.compile(r"\d")
_LONG, _SHORT, _ENDLESS = 24, 12, 30  # letters of a cell, of a short one, of a word
_LONG_FLAG = 18  # letters of a flag that is not broken


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


def numeric(table: WordTable | Table) -> set[int]:
    """Return the columns that hold numbers, or that there are none."""
    if isinstance(table, Table):
        return {i for i, name in enumerate(table.head) if name not in table.words}
    columns = enumerate(zip(*table.rows, strict=True))
    return {
        i
        for i, cells in columns
        if all(_NUMBER.fullmatch(cell) for cell in cells)
        and (any(map(_DIGIT.search, cells)) or not any(cells))
    }


def cell_classes(cell: tuple[bool, str, str]) -> str:
    """Return the classes of a cell by its kind, its text and its flag."""
    number, text, flag = cell
    long = len(flag) > _LONG_FLAG or len(text) > _LONG and (flag or " " in numbers_kept(text))
    kinds = ["n"] if number else ["long"] if long else []
    kinds += ["short"] if not number and len(text) <= _SHORT else []
    return " ".join((*kinds, *(["flagged"] if flag else []), *_endless(f"{text} {flag}")))


def head_classes(cell: tuple[bool, str, str]) -> str:
    """Return the classes of a head by its column's kind and its text."""
    number, text, _ = cell
    return " ".join((*(["n"] if number else []), *_endless(text)))


def _endless(text: str) -> list[str]:
    """Return the class of a cell that has to be broken within a word."""
    return ["endless"] if any(len(word) > _ENDLESS for word in text.split()) else []
