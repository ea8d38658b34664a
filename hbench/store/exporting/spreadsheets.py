"""Tables for spreadsheets: an Excel workbook, practical units, decimal commas.

The tables are those of hbench's CSV files, whose names of columns end in their unit. Numbers stay
numbers; whatever identifies, such as ids of runs, stays text.
"""

import csv
import io
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from hbench.store.formats.packages import require_package
from hbench.units import UNITS, Unit
from hbench.untrusted_text import from_cell

Row = list[str]

_TEXTS = re.compile(r"runs?|file|label|reason|message|parameter|with_parameter|unit|factor_.*")
_NUMBER = re.compile(r"-?\d+(\.\d*)?([eE][-+]?\d+)?")
_SHEET = re.compile(r"[\[\]:*?/\\]")
_LONGEST_NAME = 31  # of a sheet
_WIDEST, _SHOWN, _FIRST = 40, 8, 20  # characters: of a column, of a number, of the first column
_ABOUT = "summary"
# Ending of a column in SI, its ending in practical units, and that unit; the longer ones first.
_PRACTICAL: tuple[tuple[str, str, Unit], ...] = (
    ("_m3_s_pa", "_l_min_bar", Unit(1e-3 / 60 / 1e5, ())),
    ("_n_pa", "_n_bar", Unit(1e-5, ())),
    ("_m3_s", "_l_min", Unit(1e-3 / 60, ())),
    ("_m_s2", "_m_s2", UNITS["1"]),
    ("_n_s_m", "_n_s_m", UNITS["1"]),
    ("_pa_s", "_bar_s", UNITS["bar"]),
    ("_m_s", "_mm_s", UNITS["mm"]),
    ("_m2", "_mm2", Unit(1e-6, ())),
    ("_pa", "_bar", UNITS["bar"]),
    ("_m", "_mm", UNITS["mm"]),
    ("_k", "_degc", UNITS["degC"]),
)
_DIFFERENCES = re.compile(r".*(change|ci95|u95|se)_k")  # of temperatures: no zero of degC


def with_rows(tables: Mapping[str, str]) -> dict[str, str]:
    """Return the tables that have rows, by the names of their sheets."""
    return {
        _SHEET.sub(" ", name.removesuffix(".csv"))[:_LONGEST_NAME]: text
        for name, text in tables.items()
        if len(text.splitlines()) > 1
    }


def workbook(about: Sequence[Sequence[str]], tables: Mapping[str, str]) -> bytes:
    """Return an Excel workbook with the text ``about`` it and a sheet for each table.

    The tables are those of ``with_rows``. Numbers have all their digits; a column is as wide as
    its name and its text, so that a cell shows as many of them as fit.

    Raises ``ConfigError`` if openpyxl is not installed.
    """
    require_package("openpyxl", "Excel", "excel")
    import openpyxl
    from openpyxl.styles import Font
    from openpyxl.utils import get_column_letter

    book = openpyxl.Workbook()
    first = book.active
    first.title = _ABOUT
    for row in about:
        first.append([from_cell(text) for text in row])
    for row in first.iter_rows():
        row[0].font = Font(bold=True)
        for cell in row:
            cell.data_type = "s" if cell.value else cell.data_type
    first.column_dimensions["A"].width = _FIRST
    for name, text in tables.items():
        head, *rows = csv.reader(io.StringIO(text))
        sheet = book.create_sheet(name)
        sheet.append(head)
        for row in rows:
            sheet.append([_value(column, cell) for column, cell in zip(head, row, strict=True)])
        for cell in sheet[1]:
            cell.font = Font(bold=True)
        sheet.freeze_panes = "A2"
        sheet.auto_filter.ref = sheet.dimensions
        for number, column in enumerate(zip(head, *rows[:200], strict=True), start=1):
            texts = [cell for cell in column if not _NUMBER.fullmatch(cell)]
            width = min(max(map(len, [*texts, " " * _SHOWN])) + 2, _WIDEST)
            sheet.column_dimensions[get_column_letter(number)].width = width
        for cells in sheet.iter_rows(min_row=2):
            for cell in cells:  # text that begins with = stays text
                if isinstance(cell.value, str):
                    cell.data_type = "s"
    data = io.BytesIO()
    book.save(data)
    return data.getvalue()


def _value(column: str, cell: str) -> Any:
    """Return a cell's value: text where the column identifies, else a number where it is one."""
    if cell in ("true", "false"):
        return cell == "true"
    if not cell:
        return None
    if _TEXTS.fullmatch(column) or not _NUMBER.fullmatch(cell):
        return from_cell(cell)
    return float(cell) if re.search(r"[.eE]", cell) else int(cell)


def in_practical_units(text: str) -> str:
    """Return a table in mm, bar, l/min and degC, as the names of its columns say."""
    return _changed(text, _practical_columns)


def with_decimal_comma(text: str) -> str:
    """Return a table with decimal commas, its cells separated by semicolons."""
    return _changed(text, _with_commas, delimiter=";")


def _changed(text: str, change: Callable[[Row], tuple[Row, list]], delimiter: str = ",") -> str:
    head, *rows = csv.reader(io.StringIO(text))
    names, rules = change(head)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n", delimiter=delimiter)
    writer.writerow(names)
    writer.writerows(_with_rules(rows, rules))
    return out.getvalue()


def _with_rules(rows: list[Row], rules: list[Callable[[str], str] | None]) -> Iterator[Row]:
    for row in rows:
        yield [rule(cell) if rule else cell for rule, cell in zip(rules, row, strict=True)]


def _practical_columns(head: Row) -> tuple[Row, list]:
    names, rules = [], []
    for column in head:
        name, rule = column, None
        for ending, practical, unit in _PRACTICAL:
            if re.search(rf"(.|^){ending}(_low|_high|_ci95)?$", column):
                if _DIFFERENCES.fullmatch(column):
                    unit = UNITS["K"]
                else:
                    name = re.sub(rf"{ending}(?=(_low|_high|_ci95)?$)", practical, column)
                rule = _converted(unit)
                break
        names.append(name)
        rules.append(rule)
    return names, rules


def _converted(unit: Unit) -> Callable[[str], str] | None:
    if unit.factor == 1.0 and not unit.zero:
        return None
    return lambda cell: f"{unit.from_si(float(cell)):.10g}" if _NUMBER.fullmatch(cell) else cell


def _with_commas(head: Row) -> tuple[Row, list]:
    def comma(cell: str) -> str:
        return cell.replace(".", ",") if _NUMBER.fullmatch(cell) else cell

    return head, [None if _TEXTS.fullmatch(column) else comma for column in head]
