"""Maps suggested for logs of many kinds, completed by the diameters, and imported."""

import re
import shutil
from dataclasses import replace
from datetime import datetime
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat

from hbench import workflow
from hbench.config.files.yaml_text import parse_yaml
from hbench.config.import_map import parse_import_map
from hbench.errors import ConfigError, DataError
from hbench.motion.plateaus import plateaus
from hbench.store.formats import arrays, opening
from hbench.store.suggesting.force_balance import force_balance
from hbench.store.suggesting.signals import are_proportional, roughness, velocity_factor
from hbench.store.suggesting.suggest import suggest_map
from tests.support.strokes import PISTON_M, friction, one_stroke, there_and_back

SHARED = Path(__file__).parents[3] / "shared" / "data"


@pytest.fixture
def logs(tmp_path):
    (tmp_path / "logs").mkdir()
    return tmp_path / "logs"


@pytest.fixture
def imported(tmp_path, clock):
    """Return a function that imports a folder by its suggested map and analyses it."""

    def imported(logs, piston="40 mm", rod="25 mm"):
        text = suggest_map(logs).text
        text = text.replace("piston_diameter: ??? mm", f"piston_diameter: {piston}")
        text = text.replace("rod_diameter: ??? mm", f"rod_diameter: {rod}")
        map_file = tmp_path / "map.yaml"
        map_file.write_text(text)
        workflow.import_runs(logs, tmp_path / "campaign", map_file, clock)
        return parse_yaml(text), workflow.analyze(tmp_path / "campaign")

    return imported


def german(value):
    return f"{value:,.3f}".translate(str.maketrans(",.", ".,"))


def test_a_german_loggers_files(logs, imported):
    for seed, (v, trial) in enumerate((v, trial) for v in (0.02, 0.05, 0.1) for trial in (1, 2)):
        run = one_stroke(v, 2000.0, seed)
        rows = zip(
            *(run["t_s"] * 1e3, run["x_m"] * 1e3, run["p_tp_pa"] / 1e5, run["p_tr_pa"] / 1e5),
            run["f_applied_n"] / 1e3,
            strict=True,
        )
        text = "Prüfstand 2\nZeit;Weg;p_A;p_B;Kraft\nms;mm;bar;bar;kN\n"
        text += "".join(";".join(map(german, row)) + "\n" for row in rows)
        (logs / f"NBR_{1e3 * v:.0f}mm_s_2000N_{trial}.csv").write_bytes(text.encode("latin-1"))
    rules, results = imported(logs)
    assert rules["columns"] == {
        "t_s": {"column": "Zeit"},
        "x_m": {"column": "Weg"},
        "p_tp_pa": {"column": "p_A"},
        "p_tr_pa": {"column": "p_B"},
        "f_applied_n": {"column": "Kraft"},
    }
    assert rules["series"][0]["files"] == "NBR_{speed}mm_s_{load}N_{trial}.csv"
    assert all(run.accepted for run in results.runs), [run.reasons for run in results.runs]
    (curve,) = results.curves
    assert (curve.f_load_n, [p.n for p in curve.points]) == (2000.0, [2, 2, 2])
    for point in curve.points:
        assert point.friction_n == pytest.approx(friction(point.v_m_s), abs=1.0)


def test_the_balance_of_forces_turns_signs_that_are_the_other_way_round(logs, imported):
    for number, load in enumerate((0, 1000, 2000), start=1):
        run = there_and_back(0.05, load, number)
        columns = {
            "Time [s]": run["t_s"],
            "Position [mm]": 1e3 * (0.3 - run["x_m"]),
            "Pressure A [bar]": run["p_tp_pa"] / 1e5,
            "Pressure B [bar]": run["p_tr_pa"] / 1e5,
            "Load cell [kN]": -run["f_applied_n"] / 1e3,
        }
        pd.DataFrame(columns).to_csv(logs / f"test {number} {load}N.csv", index=False)
    rules, results = imported(logs)
    scales = {channel: column.get("scale", 1) for channel, column in rules["columns"].items()}
    assert scales == {"t_s": 1, "x_m": -1, "p_tp_pa": 1, "p_tr_pa": 1, "f_applied_n": -1}
    assert rules["cut"] == "reversals"
    assert all(run.accepted for run in results.runs)
    for curve in results.curves:
        (point,) = curve.points
        assert abs(point.friction_n) == pytest.approx(friction(0.05), abs=1.0)
        assert point.friction_n * point.v_m_s > 0


def test_the_balance_of_forces_gives_the_bore():
    files = [there_and_back(0.05, load) for load in (0, 1000, 2000)]
    steady = [plateaus(file["t_s"], file["x_m"]) for file in files]
    found = force_balance(files, steady)
    assert (found.force_sign, found.position_sign, found.chambers_swapped) == (1, 1, False)
    assert found.bore_m == pytest.approx(PISTON_M, rel=0.01)
    swapped = [{**f, "p_tp_pa": f["p_tr_pa"], "p_tr_pa": f["p_tp_pa"]} for f in files]
    assert force_balance(swapped, steady).bore_m is None


def as_mat(path, run):
    pressures = np.column_stack([run["p_tp_pa"], run["p_tr_pa"]]) / 1e5
    log = {"t": run["t_s"], "stroke": 1e3 * run["x_m"], "P_a": pressures[:, 0]}
    log |= {"P_b": pressures[:, 1], "F": run["f_applied_n"]}
    savemat(path.with_suffix(".mat"), {"log": log}, oned_as="column")


def as_slow_pressures(path, run):
    """Pressures at half the rate, with times of their own."""
    pressures = {"t": run["t_s"][1::2], "pA": run["p_tp_pa"][1::2], "pB": run["p_tr_pa"][1::2]}
    axis = {"t": run["t_s"], "x": 1e3 * run["x_m"], "F": run["f_applied_n"]}
    content = {"hydraulics": pressures, "zaxis": axis}  # the times of the pressures are first
    savemat(path.with_suffix(".mat"), content, oned_as="column")


def as_parquet(path, run):
    pytest.importorskip("pyarrow")
    times = pd.Timestamp("2024-05-01") + pd.to_timedelta(run["t_s"], unit="s")
    columns = {key: run[key] for key in ("x_m", "p_tp_pa", "p_tr_pa", "f_applied_n")}
    pd.DataFrame({"when": times, **columns}).to_parquet(path.with_suffix(".parquet"))


def as_time_index(path, run):
    """pandas writes the row labels as a column of durations."""
    pytest.importorskip("pyarrow")
    columns = {key: run[key] for key in ("x_m", "p_tp_pa", "p_tr_pa", "f_applied_n")}
    times = pd.to_timedelta(run["t_s"], unit="s")
    pd.DataFrame(columns, index=times).to_parquet(path.with_suffix(".parquet"))


def as_nanoseconds(path, run):
    """Since 1970, without a unit."""
    pytest.importorskip("pyarrow")
    columns = {key: run[key] for key in ("x_m", "p_tp_pa", "p_tr_pa", "f_applied_n")}
    times = 1_714_550_400_000_000_000 + np.rint(1e9 * run["t_s"]).astype(np.int64)
    table = pd.DataFrame({"timestamp": times, **columns})
    table.to_parquet(path.with_suffix(".parquet"))


def as_xlsx(path, run):
    pytest.importorskip("openpyxl")
    columns = {
        "Zeit [s]": run["t_s"],
        "Weg [mm]": 1e3 * run["x_m"],
        "Druck Kolbenseite [bar]": run["p_tp_pa"] / 1e5,
        "Druck Stangenseite [bar]": run["p_tr_pa"] / 1e5,
        "Kraft [N]": run["f_applied_n"],
    }
    sheet = pd.DataFrame(columns)
    sheet.to_excel(path.with_suffix(".xlsx"), index=False, startrow=2)


def as_second_sheet(path, run):
    pytest.importorskip("openpyxl")
    columns = {"s": "t_s", "m": "x_m", "Pa": "p_tp_pa", "Pa ": "p_tr_pa", "N": "f_applied_n"}
    table = pd.DataFrame({f"{name} [{unit.strip()}]": run[name] for unit, name in columns.items()})
    with pd.ExcelWriter(path.with_suffix(".xlsx")) as book:
        cover = pd.DataFrame([["Prüfer", "Müller"], ["Halle", "drei"]])
        cover.to_excel(book, sheet_name="Deckblatt", index=False, header=False)
        table.to_excel(book, sheet_name="Messdaten", index=False)


def as_form(path, run):
    """A cover sheet with dates and sizes, and a header whose cells are merged."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    for row in (["Protokoll"], ["Datum", datetime(2024, 5, 1)], ["Kolben", 40], ["Hub", 500]):
        book.active.append(row)
    sheet = book.create_sheet("Messwerte")
    sheet.append(["Zeit", "Weg", "Druck", None, "Kraft"])
    sheet.merge_cells("C1:D1")
    sheet.append([None, None, "Kolben", "Stange"])
    sheet.append(["s", "mm", "bar", "bar", "N"])
    x, pressures = 1e3 * run["x_m"], (run["p_tp_pa"] / 1e5, run["p_tr_pa"] / 1e5)
    for row in zip(run["t_s"], x, *pressures, run["f_applied_n"], strict=True):
        sheet.append([float(value) for value in row])
    book.save(path.with_suffix(".xlsx"))


def as_kgf_cm2(path, run):
    columns = {"t (s)": run["t_s"], "x (mm)": 1e3 * run["x_m"]}
    columns |= {
        f"P{i} (kgf/cm2)": run[p] / 98066.5 for i, p in enumerate(("p_tp_pa", "p_tr_pa"), 1)
    }
    columns |= {"F (kgf)": run["f_applied_n"] / 9.80665}
    pd.DataFrame(columns).to_csv(path.with_suffix(".csv"), index=False)


def as_comment(path, run):
    columns = (run["t_s"], run["x_m"], run["p_tp_pa"], run["p_tr_pa"], run["f_applied_n"])
    np.savetxt(path, np.column_stack(columns), header="t x p1 p2 force", fmt="%.7g")


@pytest.mark.parametrize(
    "write",
    [
        *(as_mat, as_slow_pressures, as_parquet, as_time_index, as_nanoseconds),
        *(as_xlsx, as_second_sheet, as_form, as_kgf_cm2, as_comment),
    ],
)
def test_formats(logs, imported, write):
    for trial in (1, 2):
        write(logs / f"run_{trial}.txt", one_stroke(0.05, 1000.0, trial))
    rules, results = imported(logs)
    assert all(run.accepted for run in results.runs), [run.reasons for run in results.runs]
    (point,) = results.curves[0].points
    assert (point.n, point.friction_n) == (2, pytest.approx(friction(0.05), abs=1.0))


def real(name):
    path = SHARED / name
    if not path.exists():
        pytest.skip(f"{path} is missing")
    return path


def test_unnamed_columns_of_a_real_cylinder(logs, imported):
    for pressure in (1, 7):
        shutil.copy(real(f"tudelft-cylinder/friction/O-ring_{pressure}bar.csv"), logs)
    rules, results = imported(logs, "25 mm", "0 mm")
    assert {channel: column["column"] for channel, column in rules["columns"].items()} == {
        "t_s": 1, "x_m": 5, "p_tp_pa": 6, "f_applied_n": 7
    }  # fmt: skip
    assert rules["columns"]["x_m"]["scale"] == -1
    assert rules["constants"] == {"p_tr_pa": "0 bar"}
    halves = [band.half_n for band in sorted(results.bands, key=lambda band: band.p_tp_pa)]
    assert halves == pytest.approx([4.0, 8.0], abs=0.5)  # computed independently


def test_a_cranes_jib_is_the_axis_that_moves(logs):
    shutil.copy(real("crane/JibSineTest_230425.csv"), logs)
    rules = parse_yaml(suggest_map(logs).text)
    columns = {channel: column["column"] for channel, column in rules["columns"].items()}
    assert columns == {
        "x_m": "JibPistonPosition",
        "v_m_s": "JibVelocity",
        "p_tp_pa": "JibPaCyl",
        "p_tr_pa": "JibPbCyl",
        "p_s_pa": "Ps",
    }
    assert (rules["cut"], rules["columns"]["x_m"]["unit"]) == ("reversals", "m")
    assert [series["files"] for series in rules["series"]] == ["JibSineTest_230425.csv"]


def driven(folder, name, force, **columns):
    """Write strokes of a stage with a drive, without hydraulics."""
    run = there_and_back(0.05, 0.0)
    logged = {"t [s]": run["t_s"], "x [mm]": 1e3 * run["x_m"], **columns}
    v = np.gradient(run["x_m"], run["t_s"])
    logged[force] = friction(np.where(abs(v) < 0.02, 0, v))
    pd.DataFrame(logged).to_csv(folder / name, index=False)


@pytest.mark.parametrize(
    ("column", "certainty"),
    [("Motorkraft [N]", "sure"), ("drive force [N]", "sure"), ("Force [N]", "guess")],
)
def test_a_force_without_pressures_is_the_drives(logs, imported, column, certainty):
    driven(logs, "stage_1.csv", column)
    rules, results = imported(logs)
    assert rules["columns"]["f_drive_n"] == {"column": column, "unit": "N"}
    assert "f_applied_n" not in rules["columns"] and "cylinder" not in rules["series"][0]
    text = suggest_map(logs).text
    lines = text[text.index("name:") :].splitlines()
    assert not any("???" in line for line in lines if not line.lstrip().startswith("#"))
    (line,) = (line for line in text.splitlines() if line.startswith("  f_drive_n:"))
    above = text[: text.index(line)].splitlines()[-2:]
    assert any(f"; {certainty}: " in part for part in (line, *above))
    (extend,) = (c for c in results.curves if c.direction == "extend")
    assert extend.points[0].friction_n == pytest.approx(friction(0.05), rel=0.02)


def test_a_drives_force_against_the_motion_is_turned(logs):
    driven(logs, "stage_1.csv", "Antriebskraft (N)")
    table = pd.read_csv(logs / "stage_1.csv")
    table["Antriebskraft (N)"] *= -1
    table.to_csv(logs / "stage_1.csv", index=False)
    text = suggest_map(logs).text
    assert parse_yaml(text)["columns"]["f_drive_n"]["scale"] == -1
    assert "sign by the friction" in " ".join(text.replace("#", "").split())


def test_a_force_stays_the_load_cells_where_a_pressure_is_known(logs):
    for bar in (2, 4):
        driven(logs, f"seal_{bar}bar.csv", "Force [N]")
    assert "f_applied_n" in parse_yaml(suggest_map(logs).text)["columns"]


def test_fields_of_names_and_columns_with_few_values_are_factors(logs, imported):
    n = len(there_and_back(0.05, 0.0)["t_s"])
    noise = np.random.default_rng(0).normal(0, 0.1, n)
    for current in (0, 1):
        for oil, warm in (("cold", 20.3), ("warm", 41.8)):
            for trial in (1, 2):
                warmth = warm + noise + 0.2 * trial
                name = f"{oil}_{current}A_{trial}.csv"
                driven(logs, name, "F_Motor [N]", **{"T_Oel": noise, "Temp [°C]": warmth})
    rules, results = imported(logs)
    assert {s["files"]: s["factors"] for s in rules["series"]} == {
        "cold_{current}A_{trial}.csv": {"current": "A", "temperature": "21 °C"},
        "warm_{current}A_{trial}.csv": {"current": "A", "temperature": "42 °C"},
    }
    labels = {curve.label for curve in results.curves}
    assert "cold, current 1 A, temperature 21 °C" in labels and len(labels) == 4


def test_several_values_of_a_column_in_a_series_are_reported(logs):
    for trial, warm in enumerate((20.0, 40.0, 20.0), start=1):
        driven(logs, f"a_{trial}.csv", "F_Motor [N]", **{"Temperatur (K)": np.full(2110, warm)})
    text = suggest_map(logs).text
    assert "factors" not in parse_yaml(text)["series"][0]
    assert "Temperatur (K) has the values 20 K, 40 K in these files" in text


def test_holds_at_several_pressures_are_a_series(logs):
    rng = np.random.default_rng(1)
    t = np.arange(0.0, 8.0, 0.01)
    for a, b, trial in ((20, 60, 1), (40, 80, 1), (60, 30, 1), (20, 60, 2), (60, 30, 2)):
        x = 100 + 1e-3 * rng.standard_normal(len(t))
        columns = np.column_stack([t, x, a * np.exp(-t / 90), b * np.exp(-t / 200)])
        rows = "".join(f"{','.join(f'{each:.4f}' for each in row)}\n" for row in columns.tolist())
        name = f"hold_{a}bar_{b}bar_{trial}.csv"
        (logs / name).write_text(f"time_s,x_mm,pA_bar,pB_bar\n{rows}")
    text = suggest_map(logs).text
    assert text.count("- label:") == 1 and "5 files" in text and "kind: hold" in text


def test_filtered_columns_that_are_left_out_are_reported(logs):
    run = there_and_back(0.05, 1000.0)
    names = {"t_s": "t [s]", "x_m": "x [m]", "p_tp_pa": "pA [Pa]", "p_tr_pa": "pB [Pa]"}
    table = {name: run[key] for key, name in names.items()}
    table |= {"pA_filt [Pa]": run["p_tp_pa"], "pA_raw [Pa]": run["p_tp_pa"]}
    table |= {"F_filtered [N]": run["f_applied_n"], "F [N]": run["f_applied_n"]}
    pd.DataFrame(table).to_csv(logs / "a.csv", index=False)
    suggestion = suggest_map(logs)
    columns = parse_yaml(suggestion.text)["columns"]
    assert (columns["p_tp_pa"]["column"], columns["f_applied_n"]["column"]) == ("pA [Pa]", "F [N]")
    assert "p_tp_pa is pA [Pa]; left out: pA_filt [Pa] (filtered), pA_raw [Pa] (raw)" in (
        suggestion.notes
    )
    assert "f_applied_n is F [N]; left out: F_filtered [N] (filtered)" in suggestion.notes
    text = " ".join(suggestion.text.replace("\n  #", "").split())
    assert "left out: F_filtered [N] (filtered)" in text


def test_columns_of_a_matrix_are_other_signals(logs):
    run = there_and_back(0.05, 1000.0)
    savemat(logs / "a.mat", {"M": np.column_stack(list(run.values()))})
    suggestion = suggest_map(logs)
    assert parse_yaml(suggestion.text)["columns"]["x_m"]["column"] == "M(:,2)"
    assert not any("left out" in note for note in suggestion.notes)


def test_a_suggested_map_is_refused_until_it_is_filled_in(logs):
    np.savetxt(logs / "a.csv", np.column_stack(list(one_stroke(0.05, 0).values())), delimiter=",")
    rules = parse_yaml(suggest_map(logs).text)
    with pytest.raises(ConfigError) as caught:
        parse_import_map(rules, "map.yaml")
    for key in ("piston_diameter", "rod_diameter"):
        assert f"series.0.cylinder.{key}" in caught.value.message


@pytest.mark.parametrize(
    "header", ['t,"x: [1]","a, b"', "t,x\x1b[2J,#{y", "t,yes,'", 't,"a\nb",c', "t,x,x", ",,"]
)
def test_hostile_names_stay_text(logs, header):
    rows = "".join(f"{k / 100},{k / 10},{k % 7}\n" for k in range(300))
    (logs / "a {b}.csv").write_text(f"{header}\n{rows}")
    (logs / "c: #d.csv").write_text(f"{header}\n{rows}")
    suggestion = suggest_map(logs)
    rules = parse_yaml(suggestion.text)
    assert [series["files"] for series in rules["series"]] == ["c: #d.csv"]


@pytest.mark.parametrize("content", [b"", b"\x00\x01\x02" * 99, b"only words\n" * 9, b"1\n2\n3\n"])
def test_a_folder_without_a_table_is_refused(logs, content):
    (logs / "a.csv").write_bytes(content)
    with pytest.raises(DataError, match=r"a\.csv"):
        suggest_map(logs)


def test_signals_show_what_they_are():
    t = np.arange(0, 8, 0.01)
    v = 0.05 * np.sign(np.sin(2 * np.pi * t / 4))
    x = np.concatenate(([0], np.cumsum((v[1:] + v[:-1]) / 2 * 0.01)))
    force = 100 * np.sign(v) + np.random.default_rng(0).standard_normal(len(t))
    assert velocity_factor(t, 1e3 * x, v + 0.001) == pytest.approx(1e3, rel=0.01)
    assert velocity_factor(t, force, v) is None
    back_pressure = 6 + 20 * v  # bar, behind an orifice
    assert velocity_factor(t, 1e3 * x, back_pressure) is None
    assert roughness(t, x) < 0.1 < roughness(t, force)
    assert are_proportional(force, 5 - 0.01 * force) and not are_proportional(force, x)


def test_volts_angles_and_sample_numbers_are_asked_for_or_taken_as_what_they_are(logs):
    run = there_and_back(0.05, 1000.0)
    columns = {
        "Nr": np.arange(len(run["t_s"])),
        "angle [deg]": 1e3 * run["x_m"],
        "p_A [V]": run["p_tp_pa"] / 5e6,
        "Channel 7 [bar]": run["p_tr_pa"] / 1e5,
        "Torque [Nm]": run["f_applied_n"],
    }
    pd.DataFrame(columns).to_csv(logs / "a.csv", index=False)
    rules = parse_yaml(suggest_map(logs).text)
    assert rules["columns"] == {
        "t_s": {"column": "Nr", "unit": "s", "scale": "???"},
        "x_m": {"column": "angle [deg]", "unit": "deg"},
        "p_tp_pa": {"column": "p_A [V]", "unit": "bar", "scale": "???"},
        "p_tr_pa": {"column": "Channel 7 [bar]", "unit": "bar"},
        "f_applied_n": {"column": "Torque [Nm]", "unit": "N m"},
    }
    assert rules["series"][0]["cylinder"] == {"displacement": "??? cm^3"}


def test_a_force_beside_columns_without_names_is_not_that_of_a_drive(logs):
    """Two unknown columns may be the pressures, which the map then asks for."""
    for load in (1000.0, 2000.0):
        run = there_and_back(0.05, load)
        names = ("t_s", "x_m", "p_tp_pa", "p_tr_pa", "f_applied_n")
        rows = np.stack([run[name] for name in names], axis=1) * [1, 1e3, 1e-5, 1e-5, 1]
        np.savetxt(logs / f"{load:.0f}N_1.csv", rows, "%.5f", ",")
    suggestion = suggest_map(logs)
    suggested = suggestion.text
    columns = parse_yaml(suggested)["columns"]
    assert columns["f_applied_n"] == {"column": 5, "unit": "N"} and "f_drive_n" not in columns
    assert "??? mm" in suggested and '# p_tp_pa: {column: "???", unit: bar}' in suggested
    (missing,) = [note for note in suggestion.notes if note.startswith("no column found for ")]
    assert missing.startswith("no column found for p_tp_pa, p_tr_pa: ")


def test_names_of_signals_before_conversion_ask_for_their_scale(logs):
    run = there_and_back(0.05, 1000.0)
    columns = {
        "t_ms": 1e3 * run["t_s"],
        "x_counts": np.round(2e5 * run["x_m"]),
        "pA_mA": 4 + 16 * run["p_tp_pa"] / 16e6,
        "pB (mA)": 4 + 16 * run["p_tr_pa"] / 16e6,
        "F_mV": run["f_applied_n"] / 1e3,
    }
    pd.DataFrame(columns).to_csv(logs / "a.csv", index=False)
    assert parse_yaml(suggest_map(logs).text)["columns"] == {
        "t_s": {"column": "t_ms", "unit": "ms"},
        "x_m": {"column": "x_counts", "unit": "mm", "scale": "???"},
        "p_tp_pa": {"column": "pA_mA", "unit": "bar", "scale": "???"},
        "p_tr_pa": {"column": "pB (mA)", "unit": "bar", "scale": "???"},
        "f_applied_n": {"column": "F_mV", "unit": "N", "scale": "???"},
    }


@pytest.mark.parametrize("seed", range(12))
def test_any_table_gives_a_map_or_a_clear_refusal(logs, seed):
    rng = np.random.default_rng(seed)
    n, names = (
        int(rng.choice([2, 5, 400])),
        ["t", "Weg [mm]", "p1", "", "???", "yes", "p1", "F [V]"],
    )
    t = np.arange(n) * rng.choice([0.01, 10.0])
    kinds = [t, -t, 0 * t, np.sin(t), rng.standard_normal(n), np.full(n, np.nan), 1e300 + t]
    for file in "ab":
        width = int(rng.integers(2, 6))
        columns = [kinds[k] for k in rng.integers(0, len(kinds), width)]
        frame = pd.DataFrame(np.column_stack(columns), columns=rng.choice(names, width))
        frame.to_csv(logs / f"{file}_{seed}bar_1.csv", index=False, sep=rng.choice([";", ","]))
    try:
        assert "series" in parse_yaml(suggest_map(logs).text)
    except DataError:
        pass


def stroke_with(logs, *, force="F [N]", change):
    """Write a stroke of 50 mm/s; ``change`` gets the number and the cells of each row."""
    run = one_stroke(0.05, 2000.0, 1)
    names = ["t [s]", "x [mm]", "Pressure A [bar]", "Pressure B [bar]", force]
    columns = (run["t_s"], 1e3 * run["x_m"], run["p_tp_pa"] / 1e5, run["p_tr_pa"] / 1e5)
    rows = zip(*columns, run["f_applied_n"], strict=True)
    lines = [",".join(change(n, [f"{v:.5f}" for v in row])) for n, row in enumerate(rows)]
    (logs / "a.csv").write_text("\n".join([",".join(names), *lines, ""]))


def unchanged(_, cells):
    return cells


@pytest.mark.parametrize(("name", "unit"), [("F [tons]", "tons"), ("F (lb/rev)", "lb/rev")])
def test_the_scale_of_an_unknown_unit_in_brackets_is_asked_for(logs, name, unit):
    stroke_with(logs, force=name, change=unchanged)
    text = suggest_map(logs).text
    assert parse_yaml(text)["columns"]["f_applied_n"] == {
        "column": name, "unit": "N", "scale": "???"
    }  # fmt: skip
    assert f"give N for each {unit}" in text


def test_a_column_that_cannot_be_read_is_reported_with_its_line(logs):
    def with_a_word(row, cells):
        return [*cells[:2], "1.#INF", *cells[3:]] if row == 7 else cells

    stroke_with(logs, change=with_a_word)
    notes = " ".join(suggest_map(logs).notes)
    assert "p_tp_pa: column 'Pressure A [bar]' can't be read: a.csv: line 9" in notes
    assert "'1.#INF'" in notes


def test_a_channel_beyond_the_memory_is_reported_with_what_to_do(logs, monkeypatch):
    monkeypatch.setattr(arrays, "LARGEST_UNPACKED", 8 * 1000)
    run = one_stroke(0.05, 2000.0, 1)
    with TdmsWriter(logs / "a.tdms") as file:
        step = {"wf_increment": 0.01, "wf_start_offset": 0.0}
        names = {"x [m]": "x_m", "pA [Pa]": "p_tp_pa", "pB [Pa]": "p_tr_pa", "F [N]": "f_applied_n"}
        channels = [ChannelObject("g", name, run[key], step) for name, key in names.items()]
        file.write_segment(channels)
    notes = " ".join(suggest_map(logs).notes)
    assert "'F [N]' can't be read: a.tdms: the mapped channels take more than" in notes
    assert "Map fewer channels, or split the file." in notes


def test_times_that_go_back_are_reported_with_their_values(logs):
    stroke_with(logs, change=lambda row, cells: ["0.25", *cells[1:]] if row == 80 else cells)
    back = re.search(r"'t \[s\]' goes back from (\S+) to 0\.25 in a\.csv", suggest_map(logs).text)
    assert float(back[1]) == pytest.approx(one_stroke(0.05, 2000.0, 1)["t_s"][79], abs=1e-5)


def test_a_sign_that_the_balance_of_forces_does_not_determine_is_a_guess(logs):
    """The rod side has one pressure for each direction, so that friction could be a larger area."""
    rng = np.random.default_rng(1)
    for number, load in enumerate((0, 1000, 2000), start=1):
        run = there_and_back(0.05, load, number)
        out = np.gradient(run["x_m"]) > 0
        p_tr = np.where(out, 20e5, 45e5)
        area_p, area_r = np.pi / 4 * PISTON_M**2, np.pi / 4 * (PISTON_M**2 - 0.025**2)
        force = run["f_applied_n"] + np.where(out, 300.0, -300.0)
        columns = {
            "t [s]": run["t_s"],
            "Position [mm]": 1e3 * run["x_m"],
            "pA [bar]": (force + p_tr * area_r) / area_p / 1e5 + rng.normal(0, 0.02, len(out)),
            "pB [bar]": p_tr / 1e5 + rng.normal(0, 0.02, len(out)),
            "Load cell [kN]": run["f_applied_n"] / 1e3,
        }
        pd.DataFrame(columns).to_csv(logs / f"{number}.csv", index=False)
    suggestion = suggest_map(logs)
    assert "the balance of forces does not determine its sign" in " ".join(
        suggestion.text.replace("\n  #", "").split()
    )
    assert any("guesses to check: x_m" in note for note in suggestion.notes)


AREA_ROD_M2 = np.pi / 4 * (PISTON_M**2 - 0.025**2)


@pytest.mark.parametrize("behind_bar", [(20.0, 45.0), (0.0, 0.0)], ids=["not logged", "open"])
def test_the_pressure_of_the_rod_side_that_is_not_logged_turns_no_position(logs, behind_bar):
    """A valve drives both chambers: without one of them its pressure resembles friction."""
    rng = np.random.default_rng(1)
    for number, load in enumerate((0, 1000, 2000), start=1):
        run = there_and_back(0.05, load, number)
        out = np.gradient(run["x_m"]) > 0
        p_tr = 1e5 * np.where(out, *behind_bar) + 0.05 * load / AREA_ROD_M2
        p_tr = p_tr if behind_bar[0] else 0.0 * p_tr
        area_p = np.pi / 4 * PISTON_M**2
        force = run["f_applied_n"] + np.where(out, 300.0, -300.0)
        columns = {
            "t [s]": run["t_s"],
            "Position [mm]": 1e3 * run["x_m"],
            "pA [bar]": (force + p_tr * AREA_ROD_M2) / area_p / 1e5 + rng.normal(0, 0.02, len(out)),
            "Load cell [kN]": run["f_applied_n"] / 1e3,
        }
        pd.DataFrame(columns).to_csv(logs / f"{number}.csv", index=False)
    suggestion = suggest_map(logs)
    words = " ".join(suggestion.text.replace("\n  #", "").split())
    opened = behind_bar == (0.0, 0.0)
    assert "scale: -1}" not in suggestion.text
    assert ("the balance of forces does not determine its sign" in words) != opened
    assert any("guesses to check: x_m" in note for note in suggestion.notes) != opened
    assert ("the balance of forces gives" in words) == opened


def test_times_of_day_that_pass_midnight_are_reported(logs):
    def late(row, cells):
        seconds = 86_399.0 + float(cells[0])
        hours, rest = divmod(seconds % 86_400, 3600)
        return [f"{hours:02.0f}:{rest // 60:02.0f}:{rest % 60:06.3f}", *cells[1:]]

    stroke_with(logs, change=late)
    assert re.search(r"goes back from \S+T23:59:59\S* to \S+T00:00:0\S* in", suggest_map(logs).text)


@pytest.mark.parametrize("log", [one_stroke, there_and_back])
def test_signs_are_guesses_where_the_balance_of_forces_is_singular_or_has_few_sections(logs, log):
    for number in range(6 if log is there_and_back else 1):
        run = log(0.05, 1000.0, number)
        columns = {
            "t [s]": run["t_s"],
            "Position [mm]": 1e3 * run["x_m"],
            "pA [bar]": run["p_tp_pa"] / 1e5,
            "pB [bar]": 8.0 + 0 * run["p_tr_pa"],
            "Load cell [kN]": run["f_applied_n"] / 1e3,
        }
        pd.DataFrame(columns).to_csv(logs / f"{number}.csv", index=False)
    notes = suggest_map(logs).notes
    (guesses,) = [note for note in notes if note.startswith("guesses to check: ")]
    assert {"x_m", "f_applied_n"} <= set(re.findall(r"\w+", guesses)), guesses


def test_a_text_that_is_too_large_is_refused_with_what_to_do(logs, monkeypatch):
    (logs / "1.csv").write_text("t [s];x [mm]\n" + "0.1;2.0\n" * 1000)
    formats = [replace(row, largest=5000) for row in opening.FORMATS]
    monkeypatch.setattr(opening, "FORMATS", formats)
    with pytest.raises(DataError) as refused:
        suggest_map(logs)
    assert "limit 0.005 MB. Split the log, lower its sampling rate" in refused.value.hint


def test_a_motor_that_turns_a_joint_needs_no_cylinder(tmp_path, logs, clock):
    """Torque of the motor from its current, in N m per ampere; friction of 4 N m + 2.5 N m s."""
    t = np.arange(0, 4, 0.01)
    for v_deg_s in (20, 40):
        for sign, way in ((1, "cw"), (-1, "ccw")):
            v = sign * v_deg_s * np.clip(np.minimum(t - 0.5, 3.5 - t) / 0.2, 0, 1)
            angle = np.cumsum(v) * 0.01
            torque = 4 * np.sign(v) + 2.5 * np.deg2rad(v)
            columns = {"time [s]": t, "angle [deg]": angle, "motor current [A]": torque / 2.4}
            table = pd.DataFrame({**columns, "torque sensor [Nm]": 0 * t})
            table.to_csv(logs / f"0Nm_{v_deg_s}deg_s_{way}_1.csv", index=False)
    text = suggest_map(logs).text
    assert "  # f_drive_n: {column" in text and "then remove" in text
    text = text.replace('# f_drive_n: {column: "???", unit: N m, scale: "???"}', "f_drive_n: DRIVE")
    text = text.replace("DRIVE", '{column: "motor current [A]", unit: N m, scale: 2.4}')
    text = re.sub(r"    cylinder:\n.*displacement.*\n", "", text)
    (tmp_path / "map.yaml").write_text(text)
    summary = workflow.import_runs(logs, tmp_path / "c", tmp_path / "map.yaml", clock)
    assert any("1 m stands for 1 rad" in note for note in summary.notes)
    results = workflow.analyze(tmp_path / "c")
    for curve in results.curves:
        for point in curve.points:
            expected = 4 * np.sign(point.v_m_s) + 2.5 * point.v_m_s
            assert point.friction_n == pytest.approx(expected, rel=0.01)
    text = text.replace('angle [deg]", unit: deg', 'angle [deg]", unit: mm')
    (tmp_path / "linear.yaml").write_text(text)
    with pytest.raises(ConfigError, match="'deg/s' is not one of m/s|is not one of N"):
        workflow.import_runs(logs, tmp_path / "d", tmp_path / "linear.yaml", clock)


def test_sines_with_an_odd_number_of_strokes_are_kept_whole(logs):
    t = np.arange(0, 12, 0.01)
    turned = np.clip(t - 1, 0, 10)  # five strokes of 2 s
    x = 100 - 50 * np.cos(np.pi * turned / 2)
    for load in (0, 1000):
        columns = {"t [s]": t, "x [mm]": x, "p_A [bar]": 20 + np.sin(t), "p_B [bar]": 10 + 0 * t}
        pd.DataFrame(columns | {"F [N]": load + 0 * t}).to_csv(logs / f"{load}N.csv", index=False)
    text = suggest_map(logs).text
    rules = parse_yaml(text)
    assert (rules["kind"], rules["cut"]) == ("triangle", "none")
    assert "10 strokes in 2 files without constant speed; about 100 mm" in text


def test_comments_between_the_rows_are_skipped(logs, imported):
    for trial in (1, 2):
        run = there_and_back(0.05, 500.0, trial)
        rows = pd.DataFrame({key: values for key, values in run.items()}).to_csv(
            index=False, sep="\t"
        )
        lines = rows.splitlines()
        lines.insert(900, "# block 2")
        (logs / f"50mm_s_{trial}.txt").write_text("\n".join(lines) + "\n")
    rules, results = imported(logs)
    assert rules["format"]["comment"] == "#"
    assert all(run.accepted for run in results.runs)


def test_a_command_is_that_of_the_valve(logs):
    run = there_and_back(0.05, 500.0)
    pd.DataFrame(run | {"Cmd (V)": np.sign(run["f_applied_n"])}).to_csv(logs / "1.csv", index=False)
    assert parse_yaml(suggest_map(logs).text)["columns"]["u_t_v"]["column"] == "Cmd (V)"
    pd.DataFrame(run | {"cmd_pct": run["t_s"]}).to_csv(logs / "1.csv", index=False)
    assert '# u_t_v: {column: cmd_pct, unit: V, scale: "???"}' in suggest_map(logs).text


def test_further_pressures_and_commands_may_be_those_of_a_load_cylinder(logs):
    run = there_and_back(0.05, 500.0)
    for name in ("p Druckseite [bar]", "p Gegenseite [bar]", "Y1 [%]", "Y2 [%]", "Y3 [%]"):
        run[name] = 20 + np.sign(run["f_applied_n"])
    pd.DataFrame(run).to_csv(logs / "1.csv", index=False)
    text = suggest_map(logs).text
    assert "further columns: p Druckseite [bar], p Gegenseite [bar]" in text.replace("\n  # ", " ")
    for name in ("p_lp_pa", "p_lr_pa"):
        assert f'# {name}: {{column: "???", unit: bar}}' in text
    for name in ("u_l1_v", "u_l2_v"):
        assert f'# {name}: {{column: "???", unit: V, scale: "???"}}' in text
    pd.DataFrame(run).drop(columns=["p Gegenseite [bar]", "Y3 [%]"]).to_csv(
        logs / "1.csv", index=False
    )
    text = suggest_map(logs).text
    assert "p_lp_pa" not in text and "u_l1_v" not in text


def test_a_series_of_another_motion_has_its_own_kind_and_cut(logs):
    """Six strokes of a file each, and four files of triangles of speed, in one folder."""
    t = np.arange(0, 12, 0.01)
    for trial in range(1, 7):
        x = 100 + 50 * np.clip(t - 2, 0, 3)
        pd.DataFrame({"t [s]": t, "x [mm]": x, "pA [bar]": 20 + t, "pB [bar]": 10 + t}).to_csv(
            logs / f"stroke_{trial}.csv", index=False
        )
    for trial in range(1, 5):
        x = 200 + np.cumsum(80 - np.abs((80 * t) % 320 - 160)) * 0.01
        pd.DataFrame({"t [s]": t, "x [mm]": x, "pA [bar]": 20 + t, "pB [bar]": 10 + t}).to_csv(
            logs / f"sweep_{trial}.csv", index=False
        )
    rules = parse_yaml(suggest_map(logs).text)
    assert (rules["kind"], rules["cut"]) == ("steady", "none")
    stroke, sweep = rules["series"]
    assert "kind" not in stroke and "cut" not in stroke
    assert (sweep["kind"], sweep["cut"]) == ("triangle", "none")


def test_triangles_of_speed_have_no_constant_speed_and_triangles_of_position_have(logs):
    """The top of a triangle of speed is 10 % wide, and longer than min_stroke."""
    t = np.arange(0, 24, 0.01)
    phase = (t - 1) / 6 % 1
    moving = (t >= 1) & (t < 19)
    position = 0.15 * (1 - np.abs(2 * phase - 1))
    speed = 0.1 * np.where(phase < 0.5, 1 - np.abs(4 * phase - 1), np.abs(4 * phase - 3) - 1)
    for name, x in (
        ("position", np.where(moving, position, 0.0)),
        ("speed", np.cumsum(np.where(moving, speed, 0.0)) * 0.01),
    ):
        folder = logs / name
        folder.mkdir()
        noise = 2e-6 * np.random.default_rng(3).standard_normal(len(t))
        columns = {"t [s]": t, "x [mm]": 1e3 * (x + noise), "p_A [bar]": 20 + np.sin(t)}
        pd.DataFrame(columns | {"F [N]": 500 + 0 * t}).to_csv(folder / "1.csv", index=False)
    kinds = {name: parse_yaml(suggest_map(logs / name).text) for name in ("position", "speed")}
    assert (kinds["position"]["kind"], kinds["position"]["cut"]) == ("steady", "reversals")
    assert (kinds["speed"]["kind"], kinds["speed"]["cut"]) == ("triangle", "none")


@pytest.mark.parametrize(("step_s", "max_gap"), [(0.02, None), (1.0, "2 s")])
def test_a_piston_that_rests_is_held(logs, step_s, max_gap):
    """The noise of the position is no stroke; a logger of a long hold may be slow."""
    t = np.arange(0, 300, step_s)
    rng = np.random.default_rng(2)
    for bar in (100, 150):
        x = 200 + rng.normal(0, 0.002, len(t))
        p = bar * np.exp(-t / 2000) + rng.normal(0, 0.02, len(t))
        columns = {"t [s]": t, "x [mm]": x, "p_A [bar]": p, "p_B [bar]": 20 + 0 * p}
        columns["F [N]"] = 300 * p + rng.normal(0, 3, len(t))
        pd.DataFrame(columns).to_csv(logs / f"hold_{bar}bar.csv", index=False)
    rules = parse_yaml(suggest_map(logs).text)
    assert rules["kind"] == "hold" and not {"cut", "min_stroke"} & set(rules)
    assert rules.get("screening", {}).get("max_gap") == max_gap


@pytest.mark.parametrize(("rate_hz", "max_gap"), [(50, None), (5, "0.4 s")])
def test_strokes_of_a_slow_logger_have_a_larger_gap(logs, rate_hz, max_gap):
    t = np.arange(0, 20, 1 / rate_hz)
    x = np.interp(t, [0, 2, 18], [50, 50, 210])
    rng = np.random.default_rng(2)
    p = 30 + 5 * ((t > 2) & (t < 18)) + rng.normal(0, 0.02, len(t))
    columns = {
        "t [s]": t,
        "x [mm]": x,
        "p_A [bar]": p,
        "p_B [bar]": 8 + rng.normal(0, 0.02, len(t)),
    }
    pd.DataFrame(columns | {"F [N]": 500 + rng.normal(0, 2, len(t))}).to_csv(
        logs / "10mm_s_1.csv", index=False
    )
    rules = parse_yaml(suggest_map(logs).text)
    assert (rules["kind"], rules["cut"]) == ("steady", "none")
    assert rules.get("screening", {}).get("max_gap") == max_gap


def test_times_of_day_ask_for_their_date(logs):
    for trial in (1, 2):
        rows = [
            f"10:0{trial}:0{s // 10}.{s % 10};{5 * s};{20 + s % 2};3;{s % 3}" for s in range(90)
        ]
        head = "Zeit;x [mm];p_A [bar];p_B [bar];F [N]"
        (logs / f"50mm_s_{trial}.csv").write_text("\n".join([head, *rows, ""]))
    assert "times of day; for the order of the runs add test: {date:" in suggest_map(logs).text


def test_a_position_without_times_is_not_called_at_rest(logs):
    run = one_stroke(0.05, 1000.0, 1)
    stamps = [f"step {number}" for number in range(len(run["t_s"]))]
    columns = {"time": stamps, "x [mm]": 1e3 * run["x_m"], "p_A [bar]": run["p_tp_pa"] / 1e5}
    pd.DataFrame(columns).to_csv(logs / "1.csv", index=False)
    suggestion = suggest_map(logs)
    assert parse_yaml(suggestion.text)["kind"] == "steady"
    assert any("'step 0'" in note for note in suggestion.notes)


def test_one_load_alone_does_not_give_the_signs(logs):
    """Its valve lets the load fall with the speed by 1 %, while friction raises the pressure."""
    for v in (0.03, 0.06, 0.09):
        for trial in (1, 2):
            run = there_and_back(v, 2000.0, seed=int(1e3 * v) + trial)
            columns = {
                "t [s]": run["t_s"],
                "x [mm]": 1e3 * run["x_m"],
                "p_A [bar]": run["p_tp_pa"] / 1e5,
                "p_B [bar]": run["p_tr_pa"] / 1e5,
                "F [N]": run["f_applied_n"] - 200 * np.gradient(run["x_m"], run["t_s"]),
            }
            pd.DataFrame(columns).to_csv(logs / f"{1e3 * v:.0f}mm_s_{trial}.csv", index=False)
    suggestion = suggest_map(logs)
    columns = parse_yaml(suggestion.text)["columns"]
    assert not any("scale" in column for column in columns.values())
    assert "guesses to check: x_m, f_applied_n" in suggestion.notes


def test_the_sides_of_more_than_two_numbered_pressures_are_guesses(logs):
    """P1 may be that of the supply."""
    for load in (1000, 3000):
        run = there_and_back(0.05, load)
        columns = {"t [s]": run["t_s"], "x [mm]": 1e3 * run["x_m"], "F [N]": run["f_applied_n"]}
        columns |= {"P1 [bar]": 180 + 1e-6 * run["p_tp_pa"], "P2 [bar]": run["p_tp_pa"] / 1e5}
        pd.DataFrame(columns | {"P3 [bar]": run["p_tr_pa"] / 1e5}).to_csv(logs / f"{load}N.csv")
    suggestion = suggest_map(logs)
    guesses = next(note for note in suggestion.notes if note.startswith("guesses to check"))
    assert {"p_tp_pa", "p_tr_pa"} <= set(re.findall(r"\w+", guesses))
    assert "there are also P2 [bar], P3 [bar]" in suggestion.text


def test_rows_of_an_export_with_two_rates_are_not_those_of_one_time(logs):
    """The pressures end after a fifth of the rows: the rows below have none."""
    for load in (1000, 2000, 3000):
        run = there_and_back(0.05, load)
        slow = np.full((3, len(run["t_s"])), "", dtype=object)
        for row, values in enumerate((1e3 * run["t_s"], run["p_tp_pa"], run["p_tr_pa"])):
            slow[row, : len(values[::5])] = [f"{value:.6g}" for value in values[::5]]
        fast = (1e3 * run["t_s"], 1e3 * run["x_m"], run["f_applied_n"])
        rows = [
            ",".join([*s, *(f"{v:.6g}" for v in f)])
            for s, f in zip(slow.T, np.transpose(fast), strict=True)
        ]
        head = ["Name,rig", "Starttime of export,133898804820400000,x", "", "Name,pA,pB,Name,x,F"]
        text = "\n".join([*head, "Unit,Pa,Pa,Unit,mm,N", "", *rows, ""])
        (logs / f"{load}N.csv").write_text(text)
    rules = parse_yaml(suggest_map(logs).text)
    assert {key: column["column"] for key, column in rules["columns"].items()} == {
        "x_m": "x",
        "p_tp_pa": "pA",
        "p_tr_pa": "pB",
        "f_applied_n": "F",
    }
    assert not any("scale" in column for column in rules["columns"].values())


def test_a_speed_at_which_a_pressure_has_no_values_is_left_out_of_the_balance():
    files = [there_and_back(0.05, load) for load in (0, 1000, 2000)]
    steady = [plateaus(file["t_s"], file["x_m"]) for file in files]
    files[0]["p_tp_pa"][steady[0][1].section] = np.nan
    found = force_balance(files, steady)
    assert found.sections == sum(map(len, steady)) - 1
    assert found.bore_m == pytest.approx(PISTON_M, rel=0.01)
