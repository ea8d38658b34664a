"""Tables in aligned columns, no wider than a terminal of 80 columns."""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest

from hbench.records import WordTable
from hbench.report.render.terminal_text import WIDE, broken, plain, wrapped

_HEAD = 14  # letters of a head that is not broken over lines where there is room
_CELL = 12  # letters of a cell of words that is not broken over lines
_PADDING = 5  # letters by which aligned decimal points may widen a column
_TAIL = 20  # letters behind a number, such as its unit
_GAP = "  "
_INDENT = "  "  # of the further lines of a cell
_NUMBER = r"(?:(?:[<>]=?|about|at most|at least|up to) )?[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?"
_QUANTITY = re.compile(
    rf"(?P<numbers>{_NUMBER}(?: (?:\+- |to |\(){_NUMBER})*)(?P<tail>[)%*,]*(?: [^\d\s].*)?)"
)
_PIECE = re.compile(rf"({_NUMBER})")
_DECIMALS = re.compile(r"(?<=\d)[.e].*")


@dataclass(frozen=True)
class _Column:
    """Column of a table. Cells with ``numbers`` are aligned at their decimal points."""

    head: str
    cells: tuple[str, ...]
    numbers: bool = False
    alone: bool = False  # each cell is one number without an interval or a unit

    @property
    def natural(self) -> int:
        """Width of its widest cell."""
        return max(map(len, self.cells), default=len(self.head))

    @property
    def narrow(self) -> int:
        """Width of its widest cell and of its head's longest word."""
        return max(self.natural, _longest_word(self.head))

    @property
    def narrowest(self) -> int:
        """Least width where cells of words are broken over lines."""
        if self.numbers:
            return self.narrow
        longest = max(map(_longest_word, (self.head, *self.cells)))
        return max(longest, min(self.narrow, _CELL))

    def lines(self, row: int, width: int) -> list[str]:
        """Return the lines of a cell."""
        cell = self.cells[row]
        return _broken(cell, width) if len(cell) > width else [cell]

    def justified(self, text: str, width: int) -> str:
        """Return a line of a cell or of the head at the width of the column."""
        return text.rjust(width) if self.alone else text.ljust(width)


def table_lines(table: WordTable) -> Iterable[str]:
    """Yield the title and the rows of a table in columns that fit in ``WIDE`` letters.

    Signs that some terminals do not have are replaced first. A table that is too wide has heads and
    words broken over lines. If it is still too wide, its last columns follow below it, again with
    the first columns, which name the rows.
    """
    columns = _columns(table)
    yield from wrapped(table.title) or [""]
    for number, block in enumerate(_blocks(columns)):
        if number:
            yield ""
        for lines in _block_lines(block):
            yield from lines


def lines_by_row(table: WordTable) -> list[list[str]]:
    """Return the lines of the head and of each row, with all columns side by side."""
    return list(_block_lines(_columns(table)))


def _columns(table: WordTable) -> list[_Column]:
    """Return the columns of a table that have a head or an entry."""
    head, *rows = [[plain(cell) for cell in row] for row in (table.head, *table.rows)]
    cells = zip(*rows, strict=True) if rows else [()] * len(head)
    named = zip(head, cells, strict=True)
    return [_column(name, each) for name, each in named if name or any(each)]


def _block_lines(columns: Sequence[_Column]) -> Iterator[list[str]]:
    """Yield the lines of the head and of each row of columns that stand side by side."""
    widths = _widths(columns) or [column.narrowest for column in columns]
    heads = [_broken(column.head, w, "") for column, w in zip(columns, widths, strict=True)]
    most = max(map(len, heads))
    heads = [[""] * (most - len(each)) + each for each in heads]
    yield list(_side_by_side(columns, heads, widths))
    for row in range(len(columns[0].cells)):
        lines = [column.lines(row, w) for column, w in zip(columns, widths, strict=True)]
        yield list(_side_by_side(columns, lines, widths))


def _side_by_side(
    columns: Sequence[_Column], lines: Sequence[Sequence[str]], widths: Sequence[int]
) -> Iterator[str]:
    for line in zip_longest(*lines, fillvalue=""):
        each = zip(columns, line, widths, strict=True)
        yield _GAP.join(column.justified(text, width) for column, text, width in each).rstrip()


def _blocks(columns: Sequence[_Column]) -> Iterator[list[_Column]]:
    """Yield columns that fit side by side; those that name the rows are in each block."""
    if _widths(columns):
        yield list(columns)
        return
    keys = _keys(columns)
    block: list[_Column] = []
    for column in columns[keys:]:
        if block and not _widths([*columns[:keys], *block, column]):
            yield [*columns[:keys], *block]
            block = []
        block.append(column)
    yield [*columns[:keys], *block]


def _keys(columns: Sequence[_Column]) -> int:
    """Return how many of the first columns distinguish the rows; at least one."""
    for count in range(1, len(columns)):
        rows = list(zip(*(column.cells for column in columns[:count]), strict=True))
        if len(set(rows)) == len(rows):
            return count
    return 1


def _widths(columns: Sequence[_Column]) -> list[int] | None:
    """Return the width of each column, or None where they do not fit side by side."""
    room = WIDE - len(_GAP) * (len(columns) - 1)
    one_line = [max(column.narrow, min(len(column.head), _HEAD)) for column in columns]
    narrow = [column.narrow for column in columns]
    for widths in (one_line, narrow):
        if sum(widths) <= room:
            return widths
    least = [column.narrowest for column in columns]
    if sum(least) > room:
        return None
    excess = sum(narrow) - room
    choices = [
        [*narrow[:i], width - excess, *narrow[i + 1 :]]
        for i, width in enumerate(narrow)
        if width - excess >= least[i]
    ]
    choices.append(_shrunk(narrow, least, room))
    return min(choices, key=lambda widths: _height(columns, widths))


def _shrunk(widths: Sequence[int], least: Sequence[int], room: int) -> list[int]:
    """Return widths that are reduced, the widest first, until they fit in ``room``."""
    shrunk = list(widths)
    while sum(shrunk) > room:
        spare = [(width, i) for i, width in enumerate(shrunk) if width > least[i]]
        shrunk[max(spare)[1]] -= 1
    return shrunk


def _height(columns: Sequence[_Column], widths: Sequence[int]) -> int:
    """Return the number of lines of all rows."""
    each = list(zip(columns, widths, strict=True))
    rows = range(len(columns[0].cells))
    return sum(max(len(column.lines(row, width)) for column, width in each) for row in rows)


def _broken(text: str, width: int, indent: str = _INDENT) -> list[str]:
    fits = _longest_word(text) + len(indent) <= width
    return broken(text, max(width, 1), indent if fits else "")


def _longest_word(text: str) -> int:
    return max(map(len, broken(text, 1)), default=0)


def _column(head: str, cells: Sequence[str]) -> _Column:
    """Return a column, with its cells aligned if all that have a digit are numbers of one unit."""
    found = [_QUANTITY.fullmatch(cell) for cell in cells]
    known = [each for each in found if each]
    words = [cell for cell, each in zip(cells, found, strict=True) if not each]
    tails = {each["tail"] for each in known}
    units = {tail.strip(" ?*") for tail in tails} - {""}
    mixed = len(units) > 1 or any(len(unit) > _TAIL for unit in units)
    if not known or mixed or any(map(str.isdigit, "".join(words))):
        return _Column(head, tuple(cells))
    pieces = [_PIECE.split(each["numbers"]) if each else [] for each in found]
    aligned = _aligned(pieces)
    first = max(len(_whole(each[1])) for each in pieces if each)
    shown = tuple(
        _joined(each, match["tail"]) if match else cell.rjust(first)
        for cell, each, match in zip(cells, aligned, found, strict=True)
    )
    if max(map(len, shown)) > max(map(len, cells)) + _PADDING:  # such as 1.25e-05 below 800
        shown = tuple(cells)
    alone = all(len(each) < 4 for each in pieces) and tails == {""}
    if alone:
        shown = tuple(cell.ljust(max(map(len, shown))) for cell in shown)
    return _Column(head, shown, True, alone and max(map(len, words), default=0) <= _HEAD)


def _joined(pieces: Sequence[str], tail: str) -> str:
    """Return a number with what is behind it, such as its unit, one space apart."""
    text = "".join(pieces)
    return text.rstrip() + tail if tail else text


def _aligned(cells: Sequence[list[str]]) -> list[list[str]]:
    """Return cells, split at their numbers, with each number padded to its decimal point.

    The second and further numbers are aligned where the same signs are between them.
    """
    groups: dict[tuple[str, ...], list[list[str]]] = {}
    padded = [list(cell) for cell in cells]
    for cell in padded:
        for at in range(1, len(cell), 2):
            groups.setdefault(tuple(cell[0:at:2]), []).append(cell)
    for before, members in groups.items():
        at = 2 * len(before) - 1
        whole = max(len(_whole(cell[at])) for cell in members)
        part = max(len(cell[at]) - len(_whole(cell[at])) for cell in members)
        for cell in members:
            left = whole - len(_whole(cell[at]))
            cell[at] = (" " * left + cell[at]).ljust(whole + part)
    return padded


def _whole(number: str) -> str:
    """Return a number up to its decimal point."""
    return _DECIMALS.sub("", number)
