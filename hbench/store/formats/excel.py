"""Sheets of Excel workbooks (.xlsx)."""

import zipfile
from collections.abc import Iterator
from dataclasses import replace
from datetime import date, datetime, time, timedelta
from typing import Any, BinaryIO

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.files.bounded_read import check_unpacked
from hbench.store.formats.header_row import sheets_hint
from hbench.store.formats.text import TextTable, table_of_rows

_DAY = datetime(1900, 1, 1)  # of a time without a date


def open_excel(file: BinaryIO, source: str, layout: Format) -> TextTable:
    """Return a sheet's cells as text, in the notation of ``layout``.

    Raises ``DataError``.
    """
    import openpyxl

    with zipfile.ZipFile(file) as archive:
        size = sum(part.file_size for part in archive.infolist())
    check_unpacked(size, source, "Save the sheet as a CSV file.")
    book = openpyxl.load_workbook(file, read_only=True, data_only=True)
    names = [sheet.title for sheet in book.worksheets]
    if layout.sheet is not None and layout.sheet not in names:
        raise DataError(f"{source}: no sheet {layout.sheet!r}; the file has: {', '.join(names)}")
    chosen = layout.sheet or names[0]
    rows = dict(_rows(book.worksheets[names.index(chosen)], layout))
    if empty := _empty_columns(rows):  # some programs store formulas without their values
        book = openpyxl.load_workbook(file, read_only=True)
        for number, formulas in _rows(book.worksheets[names.index(chosen)], layout):
            row = rows.setdefault(number, [])
            row += [""] * (len(formulas) - len(row))
            for column in range(len(formulas)):
                row[column] = row[column] or (formulas[column] if column in empty else "")
        rows = dict(sorted(rows.items()))
    head = list(rows.values())[: layout.header + layout.units_row]  # merged cells are empty
    width = max(map(len, head if layout.header else rows.values()), default=0)
    cells = [row + [""] * (width - len(row)) for row in rows.values()]
    others = () if layout.sheet else tuple(name for name in names if name != chosen)
    try:
        table = table_of_rows(cells, list(rows), layout, source)
    except DataError as error:
        raise DataError(error.message, sheets_hint(others) if others else error.hint) from None
    return replace(table, other_sheets=others)


def _empty_columns(rows: dict[int, list[str]]) -> list[int]:
    """Return the columns of the first row that have no cells below it."""
    first, *others = rows.values() if rows else [[]]
    return [k for k in range(len(first)) if not any("".join(row[k : k + 1]) for row in others)]


def _rows(sheet: Any, layout: Format) -> Iterator[tuple[int, list[str]]]:
    """Yield the number from 1 and the cells of each row that is not blank."""
    sheet.reset_dimensions()  # those that the file states may be wrong
    for number, values in enumerate(sheet.iter_rows(values_only=True), start=1):
        cells = [_text(value, layout.decimal) for value in values]
        while cells and not cells[-1]:
            cells.pop()
        is_comment = layout.comment is not None and cells and cells[0].startswith(layout.comment)
        if cells and number > layout.preamble and not is_comment:
            yield number, cells


def _text(value: Any, decimal: str) -> str:
    if isinstance(value, float):
        return repr(value).replace(".", decimal)
    if isinstance(value, time):
        value = datetime.combine(_DAY, value)
    elif isinstance(value, timedelta):
        value = _DAY + value
    if isinstance(value, date):  # also a datetime
        return value.isoformat()
    return "" if value is None else " ".join(str(value).split())
