"""Dialect of a text table, determined from its content."""

import csv
import re
from collections import Counter
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import islice

from hbench.config.import_layout import Format
from hbench.store.formats.date_times import parse_date_time
from hbench.store.formats.header_row import ends_with_comment
from hbench.units import unit_in

_SEPARATORS = {"tab": "\t", "semicolon": ";", "comma": ",", "whitespace": None}  # by preference
_THOUSANDS = {".": (",", "'", " "), ",": (".", "'", " ")}  # possible ones, by the decimal mark
_GAPS = ("", "nan", "na", "n/a", "null", "-nan", "inf", "-inf")
_COMMENTS = ("#", "%", "//", "!", "*", "$", "@")
_LONGEST_SIGN = max(map(len, _COMMENTS))
_MOST_LINES = 300  # read at the beginning
_MOST_HEAD = 4  # lines between a header and the data
_NUMERIC = 0.5  # of a row's cells, in a row of data

Row = tuple[int, list[str]]  # its line in the file, from 1, and its cells


@dataclass(frozen=True)
class Dialect:
    """Layout of a text, and the names of its columns."""

    layout: Format
    names: tuple[str, ...]  # from the header, or from a comment; empty if there are none


def text_dialect(text: str) -> Dialect | None:
    """Return the dialect of a text; None if it contains no table of numbers."""
    every = text.splitlines()
    filled = ((n, line) for n, line in enumerate(every, start=1) if line.strip())
    lines = list(islice(filled, _MOST_LINES))
    best: tuple[float, dict, list[Row]] = (0.0, {}, [])
    for separator in _SEPARATORS:
        rows = _rows(lines, separator)
        for decimal, thousands in _marks(separator):
            share = _numeric_share(rows, decimal, thousands)
            if share > best[0] + 1e-9:
                marks = {"separator": separator, "decimal": decimal, "thousands": thousands}
                best = share, marks, rows
    share, marks, rows = best
    found = rows_dialect(rows, marks, lines) if share > 0.0 else None
    if found is None:
        return None
    return _with_comments_between(_with_later_thousands(found, lines, every), every)


def _with_later_thousands(
    dialect: Dialect, lines: Sequence[tuple[int, str]], every: Sequence[str]
) -> Dialect:
    """Return the dialect with the mark of thousands that only numbers far below contain.

    A time in ms reaches 1.000 after the lines that are read at the beginning.
    """
    layout = dialect.layout
    if layout.thousands is not None or len(every) <= len(lines):
        return dialect
    step = max(1, len(every) // _MOST_LINES)
    later = [(n, every[n - 1]) for n in range(len(every), lines[-1][0], -step)]
    cells = {cell.strip() for _, row in _rows(later, layout.separator) for cell in row}
    unread = [cell for cell in cells if not is_number(cell, layout.decimal, None)]
    for decimal, mark in _marks(layout.separator):
        if mark and decimal == layout.decimal:
            if any(_number(decimal, mark).fullmatch(cell) for cell in unread):
                return replace(dialect, layout=layout.model_copy(update={"thousands": mark}))
    return dialect


def _with_comments_between(dialect: Dialect, lines: Sequence[str]) -> Dialect:
    """Return the dialect with the sign of comments between the rows of data, if there are any."""
    layout = dialect.layout
    above = layout.preamble + layout.header + layout.units_row + layout.skip_rows
    starts = dict.fromkeys(line.lstrip()[:_LONGEST_SIGN] for line in lines[above:])
    first, *others = filter(None, starts)
    for sign in _COMMENTS if layout.comment is None else ():
        if not first.startswith(sign) and any(start.startswith(sign) for start in others):
            return replace(dialect, layout=layout.model_copy(update={"comment": sign}))
    return dialect


def rows_dialect(
    rows: Sequence[Row], marks: dict, lines: Sequence[tuple[int, str]] = ()
) -> Dialect | None:
    """Return the dialect of ``rows``, whose separator and marks of numbers are known."""
    decimal, thousands = marks.get("decimal", "."), marks.get("thousands")
    is_data = [_is_data(cells, decimal, thousands) for _, cells in rows]
    widths = Counter(_width(cells) for (_, cells), data in zip(rows, is_data, strict=True) if data)
    if not widths:
        return None
    width = widths.most_common(1)[0][0]
    full = [data and _width(cells) == width for (_, cells), data in zip(rows, is_data, strict=True)]
    below = range(_lines_of_labview(rows), len(full))
    lasting = (i for i in below if all(full[i : i + 3]))
    first = next(lasting, next((i for i in below if full[i]), None))
    if first is None:
        return None
    has_names = any(_width(cells) == width for _, cells in rows[:first])
    if not has_names and _count_columns(rows[first][1]) and any(full[first + 1 :]):
        first = full.index(True, first + 1)  # below a header of numbers
    above = list(rows[:first])
    sign = _comment_sign([line for number, line in lines if number < rows[first][0]])
    if sign:
        above = [row for row in above if not row[1] or not row[1][0].lstrip().startswith(sign)]
    header, units, skipped = _head(above, {width, len(rows[first][1])})
    if header is None and above and ends_with_comment(above[-1][1]):
        header = above[-1] if len(above[-1][1]) == width + 1 else None
    layout = dict(marks)
    if sign:
        layout["comment"] = sign
    if header is None:
        names = _names_in_comments(rows[:first], dict(lines), sign, width)
        before = [number for number, _ in above]
        layout |= {"header": False, "preamble": before[-1] if before else 0}
    else:
        names = tuple(cell.strip() for cell in header[1][:width])
        layout |= {"units_row": units, "skip_rows": skipped}
        between = [number for number, _ in above if number < header[0]]
        layout["preamble"] = header[0] - 1 if between else 0
    return Dialect(Format(**layout), names)


def is_number(cell: str, decimal: str, thousands: str | None) -> bool:
    """Return whether a cell is a number in this notation, or a gap."""
    cell = cell.strip()
    return cell.lower() in _GAPS or _number(decimal, thousands).fullmatch(cell) is not None


def is_date_time(cell: str) -> bool:
    """Return whether a cell is a time of day, perhaps with a date."""
    cell = cell.strip()
    if cell.count(":") < 2 and (len(cell) < 14 or ":" not in cell):
        return False
    try:
        parse_date_time(cell)
    except ValueError:
        return False
    return True


def _number(decimal: str, thousands: str | None) -> re.Pattern[str]:
    mark = re.escape(decimal)
    whole = rf"\d{{1,3}}(?:{re.escape(thousands)}\d{{3}})*|\d+" if thousands else r"\d+"
    return re.compile(rf"[+-]?(?:(?:{whole})(?:{mark}\d+)?|{mark}\d+|\d+\.)(?:[eE][+-]?\d+)?")


def _rows(lines: Sequence[tuple[int, str]], separator: str) -> list[Row]:
    mark = _SEPARATORS[separator]
    if mark is None:
        return [(number, line.split()) for number, line in lines]
    rows = []
    for number, line in lines:
        try:
            rows.append((number, next(csv.reader([line], delimiter=mark), [])))
        except csv.Error:
            rows.append((number, []))
    return rows


def _marks(separator: str) -> Iterator[tuple[str, str | None]]:
    """Yield decimal and thousands marks, the simpler ones first."""
    yield from ((decimal, None) for decimal in _THOUSANDS)
    for decimal in _THOUSANDS:
        for mark in _THOUSANDS[decimal]:
            if not (mark == " " and separator == "whitespace"):
                yield decimal, mark


def _numeric_share(rows: Sequence[Row], decimal: str, thousands: str | None) -> float:
    """Return the share of numbers among the cells of rows of data; 0 for less than two rows."""
    pattern = _number(decimal, thousands)
    shares, widths = [], Counter[int]()
    for _, cells in rows:
        cells = [cell.strip() for cell in _without_end(cells)]
        numbers = sum(pattern.fullmatch(cell) is not None for cell in cells)
        good = numbers + sum(cell.lower() in _GAPS or is_date_time(cell) for cell in cells)
        if len(cells) >= 2 and numbers and good >= _NUMERIC * len(cells):
            shares.append(good / len(cells))
            widths[len(cells)] += 1
    if len(shares) < 2:
        return 0.0
    alike = widths.most_common(1)[0][1] / len(rows)
    return alike * sum(shares) / len(shares)


def _is_data(cells: list[str], decimal: str, thousands: str | None) -> bool:
    cells = _without_end(cells)
    good = sum(is_number(cell, decimal, thousands) or is_date_time(cell) for cell in cells)
    filled = sum(bool(cell.strip()) for cell in cells)
    return len(cells) >= 2 and filled > 0 and good >= _NUMERIC * len(cells)


def _count_columns(cells: list[str]) -> bool:
    """Return whether cells are the numbers of their columns, as programs write without names."""
    counts = [[str(n + k) for n in range(len(cells))] for k in (0, 1)]
    return len(cells) > 2 and [cell.strip() for cell in cells] in counts


def _without_end(cells: list[str]) -> list[str]:
    """Return the cells without the empty one behind a separator at the end of a line."""
    return cells[:-1] if cells and not cells[-1].strip() else cells


def _width(cells: list[str]) -> int:
    return len(_without_end(cells))


def _lines_of_labview(rows: Sequence[Row]) -> int:
    """Return how many rows are in the header sections of a LabVIEW measurement file; mostly 0."""
    ends = [i + 1 for i, (_, cells) in enumerate(rows) if cells[:1] and "***End_of_" in cells[0]]
    return max(ends, default=0)


def _comment_sign(above: Sequence[str]) -> str:
    """Return the sign with which the lines above the data, or all but the last few, begin."""
    for sign in _COMMENTS:
        count = sum(line.lstrip().startswith(sign) for line in above)
        if count and count >= len(above) - _MOST_HEAD + 1:
            return sign
    return ""


def _names_in_comments(
    above: Sequence[Row], lines: dict[int, str], sign: str, width: int
) -> tuple[str, ...]:
    """Return the names in the last row above the data, or in that above a row of units."""
    last = _names_in_line(above[-1], lines, sign, width) if above else ()
    if len(above) < 2 or not last or not _are_units(last):
        return last
    names = _names_in_line(above[-2], lines, sign, width)
    if not names or _are_units(names):
        return last
    return tuple(f"{name} [{unit}]" for name, unit in zip(names, last, strict=True))


def _names_in_line(row: Row, lines: dict[int, str], sign: str, width: int) -> tuple[str, ...]:
    """Return the names of the columns in a comment, or between two blanks or more."""
    number, cells = row
    line = lines.get(number, "").strip()
    if sign and line.startswith(sign):
        first = cells[0].lstrip()[len(sign) :].strip()
        cells = [first, *cells[1:]] if first else cells[1:]
        line = line[len(sign) :].strip()
    for found in (cells, re.split(r"\s{2,}|\t", line)):
        words = any(re.search(r"[^\W\d]", cell) for cell in found)
        if _width(found) == width and words and sum(map(str.isdigit, found)) == 0:
            return tuple(cell.strip() for cell in found[:width])
    return ()


def _head(above: Sequence[Row], widths: Container[int]) -> tuple[Row | None, bool, int]:
    """Return the header, whether units follow it, and the number of rows below before the data.

    ``widths`` are those of the data, with and without an empty last column.
    """
    above = [row for row in above if any(map(str.strip, row[1]))] or above
    last = [row for row in above[-_MOST_HEAD:] if _width(row[1]) in widths or len(row[1]) in widths]
    if not last or last[-1] is not above[-1]:
        return None, False, 0
    for skipped, row in enumerate(reversed(last)):
        if skipped + 1 < len(last) and _are_units(row[1]):
            return last[-2 - skipped], True, skipped
    return last[-1], False, 0


def _are_units(cells: Sequence[str]) -> bool:
    """Return whether half of the cells are units, and none is a longer text."""
    filled = [cell.strip() for cell in cells if cell.strip()]
    known = sum(unit_in(cell) is not None for cell in filled)
    return bool(filled) and known >= max(1, len(filled) / 2) and max(map(len, filled)) <= 12
