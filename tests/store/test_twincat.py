"""CSV exports of TwinCAT Scope: real ones where they are at hand, and other locales."""

import re
from pathlib import Path

import numpy as np
import pytest

from hbench.errors import DataError

CRANE = Path(__file__).parents[2].parent / "shared" / "data" / "crane"

# Map of the jib cylinder of a loader crane, HMF 2020-K.
JIB = {
    "name": "jib of a loader crane",
    "kind": "verification",
    "columns": {
        "x_m": {"column": "JibPistonPosition", "unit": "m"},
        "p_tp_pa": {"column": "JibPaCyl", "unit": "bar"},
        "p_tr_pa": {"column": "JibPbCyl", "unit": "bar"},
        "p_s_pa": {"column": "Ps", "unit": "bar"},
        "v_ref_m_s": {"column": "JibXDotRef", "unit": "m/s"},
    },
    "series": [
        {
            "label": "jib",
            "files": "FILE",
            "cylinder": {
                "piston_diameter": "150 mm",
                "rod_diameter": "100 mm",
                "stroke": "0.85 m",
            },
        }
    ],
}


def cells_of(path, name):
    """A column, its times [s] and its lines by plain splitting."""
    lines = path.read_text().split("\n")
    names = lines[6].split(",")
    column = names.index(name)
    time = max(i for i in range(column) if names[i] == "Name")
    rows = [(n, line.split(",")) for n, line in enumerate(lines, 1) if n > 8 and line]
    full = [(n, cells) for n, cells in rows if len(cells) == len(names)]
    kept = [(n, cells) for n, cells in full if cells[time].strip() and cells[column].strip()]
    t_ms, values = ([float(cells[i]) for _, cells in kept] for i in (time, column))
    return np.array(t_ms) / 1e3, np.array(values)


@pytest.mark.parametrize(
    ("name", "samples", "left_out"),
    [
        ("JibSineTest_230425.csv", 5032, None),
        ("JibValveResponseTime_010425.csv", 2741, ("9", "2750")),
        ("RampDisturbanceTest_230425.csv", 3429, ("9", "3438")),
        ("FixedXSensor_090525.csv", 4238, None),
    ],
)
def test_exports_of_a_crane_are_read(import_by, name, samples, left_out):
    if not CRANE.is_dir():
        pytest.skip(f"the exports are not at {CRANE}")
    series = [{**JIB["series"][0], "files": name}]
    (run,), notes = import_by({**JIB, "series": series}, CRANE)
    assert len(run.t_s) == samples
    omissions = [re.search(r"(\d+) rows left out.*line (\d+)", note) for note in notes]
    found = [match.groups() for match in omissions if match]
    assert found == ([left_out] if left_out else [])
    t, x = cells_of(CRANE / name, "JibPistonPosition")
    common = np.isin(np.round(1e3 * t), np.round(1e3 * run.t_s))
    np.testing.assert_array_equal(run.x_m, x[common])
    t, p = cells_of(CRANE / name, "JibPaCyl")
    if len(p) == len(x):
        np.testing.assert_allclose(run.p_tp_pa, 1e5 * p[common])
    else:  # at 200 Hz: the means over 10 ms about every second sample
        expected = (p[1:-3:2] + 2 * p[2:-2:2] + p[3:-1:2]) / 4
        assert abs(run.p_tp_pa / 1e5 - expected).max() < np.abs(np.diff(p)).max() / 4


HEAD = """\
Name;Crane
File;C:\\Users\\me\\a.csv
Starttime of export;133898804820400000;Mittwoch, 23. April 2025;13:14:42.040
Endtime of export;133898804820500000;Mittwoch, 23. April 2025;13:14:42.050

Name;p;Name;x;f
SymbolComment;a comment;SymbolComment;;
SampleTime[ms];1;SampleTime[ms];2;2
Unit;bar (Pressure);Unit;(None);N (Force)

"""
BOTH = [f"{i};{50 + i / 8};{2 * i};{i / 4 + 1};3" for i in range(30)]
ROWS = BOTH + [f"{i};{50 + i / 8}; ; ; " for i in range(30, 60)]


@pytest.fixture
def bring_in(rules, import_by, tmp_path):
    def bring_in(text, charset="utf-8-sig"):
        (tmp_path / "a.csv").write_bytes(text.encode(charset))
        (run,), notes = import_by(rules)
        return run, notes

    rules["columns"] = {
        "x_m": {"column": "x", "unit": "cm"},
        "p_tp_pa": {"column": "p", "unit": "bar"},
        "f_applied_n": {"column": "f", "unit": "N"},
    }
    rules["min_stroke"] = "1 mm"
    return bring_in


def check(run):
    np.testing.assert_allclose(run.t_s, np.arange(2, 60, 2) / 1e3, atol=1e-9)
    np.testing.assert_allclose(run.x_m, (run.t_s * 125 + 1) / 100)
    np.testing.assert_allclose(run.p_tp_pa, 1e5 * (50 + run.t_s * 125))
    np.testing.assert_array_equal(run.f_applied_n, 3)


def test_semicolons_and_decimal_commas_and_rows_about_the_channels(bring_in):
    run, notes = bring_in(HEAD + "\n".join(ROWS).replace(".", ",") + "\nEOF\n")
    check(run)
    assert not any("left out: blank" in note for note in notes)


@pytest.mark.parametrize("charset", ["utf-16", "utf-8"])
def test_tabs(bring_in, charset):
    run, _ = bring_in((HEAD + "\n".join(ROWS) + "\n").replace(";", "\t"), charset)
    check(run)


def test_times_in_ticks_of_100_ns(bring_in):
    def ticks(row):
        cells = row.split(";")
        for i in (0, 2):
            if cells[i].strip():
                cells[i] = str(133898804820400000 + 10_000 * int(cells[i]))
        return ";".join(cells)

    check(bring_in(HEAD + "\n".join(map(ticks, ROWS)) + "\n")[0])


def test_rows_with_a_value_but_no_time_and_short_rows_are_left_out(bring_in):
    rows = ROWS.copy()
    rows[9] = rows[9].replace(";3.25;", ";;")  # line 20: no x
    rows[20] = rows[20][:9]
    run, notes = bring_in(HEAD + "\n".join(rows) + "\n")
    assert "2 rows left out" in notes[0] and "line 20" in notes[0]
    expected = [t for t in range(2, 60, 2) if t not in (18, 40)]
    np.testing.assert_allclose(run.t_s, np.array(expected) / 1e3)
    np.testing.assert_allclose(run.x_m, (run.t_s * 125 + 1) / 100)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD, "without a row of names and data"),
        (HEAD + "0;1;2\n", "no row of data has 5 cells"),
        (HEAD + "\n".join(ROWS).replace("3;", "drei;", 1), "line 1[0-9]: column .*drei"),
        (HEAD.replace(";x;", ";y;") + "\n".join(ROWS), "no column 'x'.* Name, p, Name, y, f"),
        (HEAD.replace("bar (P", "psi (P") + "\n".join(ROWS), "'psi'; unit in the map is 'bar'"),
    ],
)
def test_an_export_that_cannot_be_read_is_refused(bring_in, text, message):
    with pytest.raises(DataError, match=f"a.csv: .*{message}"):
        bring_in(text)
