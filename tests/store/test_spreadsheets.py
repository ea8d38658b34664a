"""Tables for spreadsheets: numbers as numbers, ids as text, units and decimal signs."""

import io
import re
import shutil

import pandas as pd
import pytest

from hbench.store.exporting.spreadsheets import (
    in_practical_units,
    with_decimal_comma,
    with_rows,
    workbook,
)
from tests.support import ROOT
from tests.support.commands import hbench

TABLE = (
    "run,label,v_m_s,p_tp_pa,temp_port_k,temp_change_k,slope_n_pa,slope_ci95_n_pa,leak_m3_s,reason\n"
    "0007,'=1+1,0.05,1.5e6,313.15,2.5,4e-5,1e-5,1e-6,\n"
    "0008,-5,,-2e5,273.15,,,,,not_steady: 1.5 mm/s\n"
)


def frame(text, **how):
    return pd.read_csv(io.StringIO(text), **how)


def test_practical_units_are_in_names_and_numbers():
    table = frame(in_practical_units(TABLE))
    assert list(table) == [
        *["run", "label", "v_mm_s", "p_tp_bar", "temp_port_degc", "temp_change_k"],
        *["slope_n_bar", "slope_ci95_n_bar", "leak_l_min", "reason"],
    ]
    assert table.iloc[0, 2:9].tolist() == pytest.approx([50, 15, 40, 2.5, 4, 1, 0.06])
    assert table.p_tp_bar[1] == pytest.approx(-2) and table.temp_port_degc[1] == 0


def test_a_leak_coefficient_keeps_its_flow_at_any_pressure():
    head = "value_m3_s_pa,ci95_low_m3_s_pa,pressure_pa,flow_m3_s"
    coefficient, pressure = 2e-13, 80e5
    text = in_practical_units(f"{head}\n{coefficient},1e-13,{pressure},{coefficient * pressure}\n")
    table = frame(text)
    assert list(table) == ["value_l_min_bar", "ci95_low_l_min_bar", "pressure_bar", "flow_l_min"]
    value, _, bar, flow = table.iloc[0]
    assert value * bar == pytest.approx(flow) == pytest.approx(0.096)


def test_a_decimal_comma_is_read_back_and_texts_stay():
    text = with_decimal_comma(TABLE)
    table = frame(text, sep=";", decimal=",", dtype={"run": str})
    pd.testing.assert_frame_equal(table, frame(TABLE, dtype={"run": str}))
    assert "not_steady: 1.5 mm/s" in text


def test_a_workbook_has_ids_as_text_numbers_as_numbers_and_no_formula():
    openpyxl = pytest.importorskip("openpyxl")
    tables = with_rows({"runs.csv": TABLE, "empty.csv": "a,b\n"})
    book = openpyxl.load_workbook(io.BytesIO(workbook([("Campaign", "=1+1"), ()], tables)))
    assert book.sheetnames == ["summary", "runs"]
    assert book["summary"]["B1"].value == "=1+1" and book["summary"]["B1"].data_type == "s"
    head, first, second = ([cell for cell in row] for row in book["runs"].iter_rows())
    assert [cell.value for cell in head][:3] == ["run", "label", "v_m_s"]
    assert [cell.value for cell in first][:4] == ["0007", "=1+1", 0.05, 1.5e6]
    assert {cell.data_type for cell in first[:2]} == {"s"}  # not "f", a formula
    assert second[1].value == "-5" and second[2].value is None


@pytest.fixture
def campaign(tmp_path):
    return shutil.copytree(ROOT / "data_samples" / "stribeck-small", tmp_path / "campaign")


def test_the_workbook_of_a_campaign_has_runs_points_fits_and_budget(campaign, tmp_path):
    openpyxl = pytest.importorskip("openpyxl")
    done = hbench("export", campaign, "--format", "excel", "-o", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    book = openpyxl.load_workbook(tmp_path / "out" / "results.xlsx")
    assert {"runs", "curves", "fits", "budget"} <= set(book.sheetnames)
    rows = [[cell for cell in row if cell] for row in book["summary"].values]
    first = {row[0]: row[1:] for row in rows if row}
    assert "no cylinder was measured" in first["Source"][0] and "with care" in first["Verdict"][0]
    assert set(book.sheetnames[1:]) <= set(first) and "extending" in first
    assert book.sheetnames[0] == "summary"
    curves, budget = (
        pd.DataFrame(rows[1:], columns=rows[0])
        for rows in ([list(row) for row in book[name].values] for name in ("curves", "budget"))
    )
    series = ["direction", "f_load_n", "p_lr_ref_pa", "v_m_s"]
    parts = budget[budget.input != "trials"].assign(square=lambda b: b.part_n**2)
    combined = parts.groupby(series).square.sum() ** 0.5
    stated = curves.set_index(series).sigma_instruments_n
    pd.testing.assert_series_equal(
        combined.sort_index(), stated.sort_index(), check_names=False, rtol=1e-9
    )


@pytest.mark.parametrize(
    "options",
    [("--format", "mat", "--units", "practical"), ("--format", "excel", "--decimal", "comma")],
)
def test_an_option_that_a_format_does_not_take_is_refused(campaign, tmp_path, options):
    done = hbench("export", campaign, *options, "-o", tmp_path / "out")
    assert done.returncode == 2 and options[2] in done.stderr
    assert not (tmp_path / "out").exists()


def test_the_loader_of_the_documentation_reads_an_export(campaign, tmp_path, monkeypatch):
    page = (ROOT / "hbench" / "store" / "README.md").read_text()
    (code,) = re.findall(r"<!-- loader -->\n```python\n(.*?)```", page, re.S)
    monkeypatch.chdir(tmp_path)
    assert hbench("export", campaign, "-o", "demo-csv").returncode == 0
    names: dict = {}
    exec(code, names)
    assert len(names["logs"]) == len(names["runs"]) and "p_tp_pa" in names["logs"]["0001"]
