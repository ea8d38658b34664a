"""The header of a text table, and hints about a layout that does not fit it."""

import re
from collections.abc import Iterable, Sequence
from contextlib import suppress
from itertools import islice
from typing import NamedTuple

import numpy as np

from hbench.config.import_layout import Format
from hbench.store.formats.date_times import parse_date_time
from hbench.units import unit_in

# In place of a value: of spreadsheets and loggers, such as for an overloaded or open input.
_MISSING = (
    *("#n/a", "#div/0!", "#value!", "#num!", "#ref!", "inf", "-inf", "none", "no data", "nodata"),
    *("ovl", "ol", "o.l", "ovf", "over", "overload", "overflow", "open", "bad", "error", "invalid"),
)
_FILLERS = "-*#?+ "  # cells of these alone
# Digits in groups of three: 1.234.567 or 1'234.5.
_GROUPED = re.compile(
    r"[+-]?\d{1,3}(?P<mark>[.,' ])\d{3}(?:(?P=mark)\d{3})*(?:(?P<decimal>[.,])\d+)?"
)
_WITH_UNIT = re.compile(r"[+-]?[\d.,]+(?:[eE][+-]?\d+)?\s*([^\W\d].*)")  # 0.01 sec
_MOST_ROWS = 60
_MOST_BETWEEN = 3  # rows between header and data, such as units
_NUMERIC = 0.5  # of the cells of a row of data
_FORMAT = (
    "Set 'format' in the map: separator, preamble (lines before the header), comment, skip_rows."
)


def ends_with_comment(names: Sequence[str]) -> bool:
    """Return whether a header ends with LabVIEW's "Comment", a cell that its rows may leave out."""
    return len(names) > 1 and names[-1].strip().lower() == "comment"


class LabviewHeader(NamedTuple):
    """What LabVIEW writes above the columns, of which the first has the times; empty without it."""

    units: tuple[str, ...] = ()
    times: tuple[tuple[float, float], ...] = ()  # [s] start and step, where no column has them


def labview_header(text: str, layout: Format, width: int) -> LabviewHeader:
    """Return the header of ``width`` columns, of which the times are in seconds."""
    if not layout.preamble:
        return LabviewHeader()
    marks = "," if layout.separator == "comma" else r"[\t;]"
    rows = (re.split(marks, line) for line in text.splitlines()[: layout.preamble])
    of = {label: cells[: width - 1] for label, *cells in rows}
    units = of.get("Y_Unit_Label", [])
    times: tuple[tuple[float, float], ...] = ()
    if of.get("X_Columns", [""])[0].strip() == "No":
        with suppress(ValueError):  # no numbers, or of few columns: the times are not known
            start, step = (
                [float(cell.replace(layout.decimal, ".")) for cell in of.get(label, [])]
                for label in ("X0", "Delta_X")
            )
            times = tuple(zip(start, step, strict=True))
    return LabviewHeader(
        ("s", *units) if any(units) and len(units) == width - 1 else (),
        ((0.0, 0.0), *times) if len(times) == width - 1 else (),
    )


def layout_hint(
    rows: Iterable[Sequence[str]], lines: Sequence[int] | np.ndarray, layout: Format
) -> str:
    """Return a hint with the line of the header, or with the keys of a map where none is found.

    ``rows`` are the cells of the rows that the ``layout`` leaves, ``lines`` their numbers from 1.
    """
    line = header_line(rows, lines, layout)
    if line is None or line == layout.preamble + 1:
        return _FORMAT
    return f"Line {line} looks like the header: write 'preamble: {line - 1}' in the map's 'format'."


def column_hint(
    names: Sequence[str],
    other_sheets: Sequence[str],
    rows: Iterable[Sequence[str]],
    lines: Sequence[int] | np.ndarray,
    layout: Format,
) -> str:
    """Return the hint for a column that is not among the ``names`` of a table's header."""
    if other_sheets:
        return sheets_hint(other_sheets)
    if names and all(_is_number(name, layout) for name in names):
        return (
            "The header consists of numbers: if the file has none, write 'header: false' in the "
            "map's 'format', and give the columns' numbers, from 1."
        )
    mapped = layout != Format() or len(names) == 1
    return layout_hint(rows, lines, layout) if mapped else ""


def sheets_hint(others: Sequence[str]) -> str:
    """Return the hint for a workbook of which the first sheet does not fit the map."""
    return (
        "The first sheet was read. For another write 'sheet: NAME' in the map's 'format'; the "
        f"others are {', '.join(others)}."
    )


def cell_hint(cell: str, layout: Format) -> str:
    """Return the hint for a cell that is no number."""
    if cell.startswith("="):
        return (
            "The formula has no stored value: open the file in a spreadsheet program, and save it."
        )
    if grouped := _GROUPED.fullmatch(cell.strip()):
        mark = grouped["mark"]
        if mark == "," and not grouped["decimal"] and layout.decimal == ".":
            return (
                "State in the map whether the comma is the decimal mark, format.decimal, or the "
                "mark of thousands, format.thousands."
            )
        if layout.decimal == (grouped["decimal"] or layout.decimal) != mark:
            return f'Specify the mark of thousands in the map: format.thousands: "{mark}".'
    if "," in cell and layout.decimal != ",":
        return "Specify a decimal comma in the map: format.decimal."
    if cell.strip().lower().strip("+-") in _MISSING or not cell.strip(_FILLERS):
        return "Leave the cell empty, or write nan, if there is no value."
    with suppress(ValueError, OverflowError):
        parse_date_time(cell.strip())
        return "Write 'unit: date-time' at this column of the map if it has dates or times."
    if (match := _WITH_UNIT.fullmatch(cell.strip())) and unit_in(match[1]):
        return f"Remove {match[1]!r} behind each number: the map states the unit of a column."
    return ""


def header_line(
    rows: Iterable[Sequence[str]], lines: Sequence[int] | np.ndarray, layout: Format
) -> int | None:
    """Return the line of the first row of names as wide as the row of numbers below it."""
    first = [_stripped(row) for row in islice(rows, _MOST_ROWS)]
    shares = [_numeric_share(row, layout) for row in first]
    for i, names in enumerate(first):
        if len(names) < 2 or shares[i]:
            continue
        below = range(i + 1, min(i + 2 + _MOST_BETWEEN, len(first)))
        data = next((k for k in below if shares[k] >= _NUMERIC), None)
        if data is not None and all(len(first[k]) == len(names) for k in range(i, data + 1)):
            return int(lines[i])
    return None


def _stripped(row: Sequence[str]) -> list[str]:
    """Return a row's cells without blank ones at its end."""
    cells = [cell.strip() for cell in row]
    while cells and not cells[-1]:
        cells.pop()
    return cells


def _numeric_share(cells: Sequence[str], layout: Format) -> float:
    return sum(_is_number(cell, layout) for cell in cells) / max(1, len(cells))


def _is_number(cell: str, layout: Format) -> bool:
    try:
        float(cell.replace(layout.thousands or " ", "").replace(layout.decimal, "."))
    except ValueError:
        return False
    return True
