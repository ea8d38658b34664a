"""Excel workbooks as people keep them: what is missing is named with the key that helps."""

import io

import pytest

from hbench.config.import_layout import Format
from hbench.errors import DataError
from hbench.store.formats.excel import open_excel

openpyxl = pytest.importorskip("openpyxl")
HEAD = ["t [s]", "x [mm]"]
ROWS = [[0.01 * k, 50.0 + k] for k in range(5)]


def read(sheets: dict[str, list[list]], **layout):
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    file = io.BytesIO()
    book.save(file)
    return open_excel(file, "a.xlsx", Format(**layout))


@pytest.mark.parametrize("overview", [[], [["Cylinder", 7]], [["Run", "speed"], [1, 50]]])
def test_a_first_sheet_without_the_columns_points_to_the_others(overview):
    with pytest.raises(DataError) as error:
        read({"Overview": overview, "Data": [HEAD, *ROWS]}).numbers("t [s]")
    assert "'sheet: NAME'" in error.value.hint and "Data" in error.value.hint


def test_formulas_without_stored_values_are_named():
    rows = [[f"=A{k}*0.1", row[1]] for k, row in enumerate(ROWS, start=2)]
    table = read({"Data": [HEAD, *rows]})
    assert table.numbers("x [mm]").tolist() == [row[1] for row in ROWS]
    with pytest.raises(DataError, match=r"'=A2\*0.1'") as error:
        table.numbers("t [s]")
    assert "no stored value" in error.value.hint


def test_an_empty_column_stays_empty():
    table = read({"Data": [[*HEAD, "spare"], *ROWS]})
    assert table.numbers("t [s]").tolist() == [row[0] for row in ROWS]
    with pytest.raises(DataError, match="found ''"):
        table.numbers("spare")


def test_a_sheet_without_a_header_points_to_the_key():
    with pytest.raises(DataError) as error:
        read({"Data": ROWS}).numbers("t [s]")
    assert "'header: false'" in error.value.hint
    assert read({"Data": ROWS}, header=False).numbers(2).tolist() == [row[1] for row in ROWS]
