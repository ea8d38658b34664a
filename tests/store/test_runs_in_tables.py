"""Logs whose runs are not a file each: what the suggestion says, and the recipes of the README."""

import re
from pathlib import Path

import numpy as np
import openpyxl
import pytest

from hbench import workflow
from hbench.config.files.yaml_text import parse_yaml
from hbench.errors import DataError

AREA_M2 = np.pi / 4 * 0.04**2
README = Path(__file__).parents[2] / "hbench" / "store" / "README.md"
HEAD = ("Run", "Speed (mm/s)", "Load (N)", "Time (s)", "Position (mm)", "Pressure A (bar)")
HEAD += ("Pressure B (bar)", "Load cell (N)")


def rows_of(run, speed, load):
    t = np.round(np.arange(0, 3, 0.02), 3)
    x = 50 + speed * np.clip(t - 0.5, 0, 2)
    force = load + 0.5 * np.sin(20 * t)
    columns = (t, x, 40 + force / 1256, 30 + 0 * t, force)
    return [[run, speed, load, *map(float, row)] for row in np.column_stack(columns)]


RUNS = [
    rows_of(3 * i + k, speed, load)
    for i, (speed, load) in enumerate([(20, 500), (50, 500), (50, 2000)])
    for k in (1, 2, 3)
]


def workbook(path, sheets):
    book = openpyxl.Workbook(write_only=True)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)


def recipe(name, folder, monkeypatch):
    """Run a recipe of the README in a folder; return the names of the files that it writes."""
    (code,) = re.findall(rf"<!-- {name} -->\n```python\n(.*?)```", README.read_text(), re.S)
    (folder / "logs").mkdir()
    monkeypatch.chdir(folder)
    exec(f"import pandas as pd\n{code}", {})
    return sorted(path.name for path in (folder / "logs").iterdir())


def test_a_table_of_several_runs_is_recognised_and_split(tmp_path, monkeypatch):
    workbook(tmp_path / "campaign.xlsx", {"data": [HEAD, *(row for run in RUNS for row in run)]})
    found = workflow.suggest_import_map(tmp_path)
    assert "goes back from 2.98 to 0 in campaign.xlsx; if it contains several runs" in found.text
    assert 'f_applied_n: {column: "Load cell (N)"' in found.text  # not the nominal load
    assert "v_m_s" not in found.text  # the nominal speed is not measured
    names = recipe("split", tmp_path, monkeypatch)
    assert len(names) == 9 and names[0] == "20mm_s_500N_1.csv"
    text = workflow.suggest_import_map(tmp_path / "logs").text
    assert '"{speed}mm_s_{load}N_{trial}.csv"' in text and "goes back" not in text


def test_the_import_of_several_runs_in_a_file_says_what_to_do(tmp_path, clock):
    (tmp_path / "logs").mkdir()
    lines = [",".join(map(str, row)) for row in (HEAD, *RUNS[0], *RUNS[1])]
    (tmp_path / "logs" / "all.csv").write_text("\n".join([*lines, ""]))
    (tmp_path / "map.yaml").write_text(
        "name: n\n"
        "columns: {t_s: {column: 'Time (s)', unit: s}, x_m: {column: 'Position (mm)', unit: mm}}\n"
        "series: [{label: a, files: all.csv, cylinder: {piston_diameter: 40 mm}}]\n"
    )
    with pytest.raises(DataError, match=r"time goes from 2\.98 s to 0 s") as error:
        workflow.import_runs(tmp_path / "logs", tmp_path / "c", tmp_path / "map.yaml", clock)
    assert "write each to a file of its own" in error.value.hint


def test_sheets_that_are_not_read_are_reported(tmp_path, monkeypatch):
    overview = [HEAD[:3], *(run[0][:3] for run in RUNS)]
    sheets = {f"Run {i}": [HEAD[3:], *(r[3:] for r in run)] for i, run in enumerate(RUNS, start=1)}
    workbook(tmp_path / "campaign.xlsx", {"Overview": overview, **sheets})
    found = workflow.suggest_import_map(tmp_path)
    assert any("one sheet was read; 8 others: Run 2, Run 3" in note for note in found.notes)
    assert parse_yaml(found.text)["format"]["sheet"] == "Run 1"  # the overview is no log
    assert recipe("sheets", tmp_path, monkeypatch) == [f"Run {i}.csv" for i in range(1, 10)]


def test_a_sheet_beside_others_is_imported_with_a_note(tmp_path):
    (tmp_path / "logs").mkdir()
    sheets = {name: [HEAD[3:], *(row[3:] for row in RUNS[0])] for name in ("log", "copy")}
    workbook(tmp_path / "logs" / "1.xlsx", sheets)
    text = (
        "name: n\nformat: {FORMAT}\n"
        "columns: {t_s: {column: 'Time (s)', unit: s}, x_m: {column: 'Position (mm)', unit: mm}}\n"
        "series: [{label: a, files: 1.xlsx, cylinder: {piston_diameter: 40 mm}}]\n"
    )
    for chosen, count in (("", 1), ("sheet: log", 0)):
        (tmp_path / "map.yaml").write_text(text.replace("FORMAT", chosen))
        (file,) = workflow.preview_import(tmp_path / "logs", tmp_path / "map.yaml").files
        assert sum("sheets not read" in note for note in file.notes) == count


def test_a_run_in_several_files_is_recognised_and_joined(tmp_path, monkeypatch):
    (tmp_path / "traces").mkdir()
    for i, run in enumerate(RUNS, start=1):
        for group, names, columns in (
            ("Achse", "Zeit [ms];Weg [mm];Kraft [N]", (3, 4, 7)),
            ("Druck", "Zeit [ms];Druck A [bar];Druck B [bar]", (3, 5, 6)),
        ):
            rows = [[1e3 * row[3], *(row[c] for c in columns[1:])] for row in run]
            lines = [names, *(";".join(map(str, row)).replace(".", ",") for row in rows)]
            (tmp_path / "traces" / f"Lauf{i}_{group}.csv").write_text("\n".join([*lines, ""]))
    (note,) = [
        note
        for note in workflow.suggest_import_map(tmp_path / "traces").notes
        if "in several files" in note
    ]
    assert "Lauf{trial}_Achse.csv, Lauf{trial}_Druck.csv" in note
    names = recipe("join", tmp_path, monkeypatch)
    assert names == sorted(f"Lauf{i}.csv" for i in range(1, 10))
    text = workflow.suggest_import_map(tmp_path / "logs").text
    assert 'p_tp_pa: {column: "Druck A [bar]"' in text and "f_drive_n" not in text


def test_a_valves_command_in_percent_is_offered_with_its_scale_to_fill_in(tmp_path):
    for i, run in enumerate(RUNS, start=1):
        rows = [[*row[3:], 10 + 0.1 * row[3]] for row in run]
        lines = [",".join((*HEAD[3:], "Ventil 1 [%]")), *(",".join(map(str, r)) for r in rows)]
        (tmp_path / f"run_{i}.csv").write_text("\n".join([*lines, ""]))
    text = workflow.suggest_import_map(tmp_path).text
    assert '# u_t_v: {column: "Ventil 1 [%]", unit: V, scale: "???"}' in text
    assert "0.1 for percent of 10 V" in " ".join(text.replace("#", "").split())


@pytest.mark.parametrize("clock_s", [lambda t: t % 1.0, lambda t: np.where(t < 1.5, t, t - 1.5)])
def test_a_clock_that_wraps_or_restarts_is_made_to_rise(tmp_path, monkeypatch, clock_s):
    (tmp_path / "traces").mkdir()
    t = np.arange(0, 3, 0.02)
    lines = [f"{time:.2f}\t{20 * true:.3f}" for time, true in zip(clock_s(t), t, strict=True)]
    lines.insert(80, "# block 2")
    (tmp_path / "traces" / "20mm_s.txt").write_text("t\tx\n" + "\n".join(lines) + "\n")
    assert recipe("clock", tmp_path, monkeypatch) == ["20mm_s.csv"]
    made = np.loadtxt(tmp_path / "logs" / "20mm_s.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(made[:, 0], t, atol=1e-6)


def test_several_loads_in_a_file_are_split_and_each_gives_its_friction(
    tmp_path, monkeypatch, clock
):
    """Friction is 100 N and 4 % of the load, so that a mean over loads is that of none of them."""
    (tmp_path / "traces").mkdir()
    for trial in (1, 2, 3):
        cycle = np.array([0.0, 0.5, 4.5, 5.0, 9.0])
        t = np.arange(0, 36, 0.01)
        x = np.interp(t % 9.0, cycle, [50.0, 50.0, 250.0, 250.0, 50.0])
        load = np.interp(t, [0, 17.95, 18.05, 36], [500, 500, 2000, 2000])
        friction = np.sign(np.gradient(x)) * (100 + 0.04 * load)
        noise = np.random.default_rng(trial).normal(0, 1, (2, len(t)))
        p = (load + friction + noise[0]) / AREA_M2 / 1e5
        table = np.column_stack([t, x, p, load + noise[1]])
        np.savetxt(tmp_path / f"traces/50mm_s_{trial}.csv", table, "%.4f", ",",
                   header="t,x,p,F", comments="")  # fmt: skip
    names = recipe("loads", tmp_path, monkeypatch)
    assert [name.split("_")[3] for name in names] == 3 * ["2000N", "500N"]
    (tmp_path / "map.yaml").write_text(
        "name: n\n"
        "columns: {t_s: {column: t, unit: s}, x_m: {column: x, unit: mm},\n"
        "  p_tp_pa: {column: p, unit: bar}, f_applied_n: {column: F, unit: N}}\n"
        "constants: {p_tr_pa: 0 bar}\ncut: reversals\n"
        "series: [{label: a, files: '{speed}mm_s_{trial}_{load}N_*.csv',\n"
        "  cylinder: {piston_diameter: 40 mm}}]\n"
    )
    workflow.import_runs(tmp_path / "logs", tmp_path / "c", tmp_path / "map.yaml", clock)
    results = workflow.analyze(tmp_path / "c")
    found = {(c.f_load_n, c.direction): abs(c.points[0].friction_n) for c in results.curves}
    for (load_n, _), friction_n in found.items():
        assert friction_n == pytest.approx(100 + 0.04 * load_n, abs=1)
    assert len(found) == 4 and results.curves[0].points[0].n == 3
    assert not any(c.name == "load_spread" for c in results.quality.checks)
