"""Units and speeds of a suggested map where neither logger nor names state them."""

import numpy as np
import pytest

from hbench.config.files.yaml_text import parse_yaml
from hbench.store.suggesting.suggest import suggest_map
from tests.support.strokes import one_stroke, there_and_back


def columns_of(folder, *, length_m, pressure_pa, force_n, name="{v:g}mm_s_{load:g}N_{trial}.csv"):
    """Return the columns of the map suggested for logs in other units, which no header states."""
    for v, load, trial in ((v, f, i) for v in (20, 60) for f in (2000, 5000) for i in (1, 2)):
        run = one_stroke(v / 1e3, float(load), seed=trial)
        pressures = run["p_tp_pa"] / pressure_pa, run["p_tr_pa"] / pressure_pa
        rows = (run["t_s"], run["x_m"] / length_m, *pressures, run["f_applied_n"] / force_n)
        file = folder / name.format(v=v, load=load, trial=trial)
        np.savetxt(file, np.transpose(rows), "%.6g", ",", header="t,x,pA,pB,F", comments="")
    return parse_yaml(suggest_map(folder).text)["columns"]


@pytest.mark.parametrize(
    ("length", "length_m", "force", "force_n"),
    [("in", 0.0254, "lbf", 4.44822), ("m", 1.0, "kgf", 9.80665), ("mm", 1e-3, "kN", 1e3)],
)
def test_units_are_those_of_the_speeds_and_loads_in_the_names(
    tmp_path, length, length_m, force, force_n
):
    columns = columns_of(tmp_path, length_m=length_m, pressure_pa=1e5, force_n=force_n)
    assert columns["x_m"]["unit"] == length
    assert columns["f_applied_n"]["unit"] == force


def test_a_pressure_beside_inches_is_in_psi(tmp_path):
    columns = columns_of(tmp_path, length_m=0.0254, pressure_pa=6894.76, force_n=4.44822)
    assert [columns[channel]["unit"] for channel in ("p_tp_pa", "p_tr_pa")] == ["psi", "psi"]


@pytest.mark.parametrize(
    ("name", "files"),
    [
        ("log_{v}_{trial}.csv", "log_{speed}_{trial}.csv"),
        ("{trial}-{v}-NBR.csv", "{trial}-{speed}-NBR.csv"),
        ("Versuch_{v}_{trial}.csv", "Versuch_{speed}_{trial}.csv"),
        ("[{v}] 50% (neu)/Lauf #{trial} ü.csv", "[{speed}] 50% (neu)/Lauf #{trial} ü.csv"),
        ("{code}_{trial}.csv", None),
    ],
)
def test_a_number_in_the_names_that_is_the_measured_speed_is_the_speed(tmp_path, name, files):
    """A code of another order than the speeds is none: its files stay apart."""
    for v, code in ((20, 7), (50, 60), (90, 20)):
        for trial in (1, 2):
            run = there_and_back(v / 1e3, 2000.0, seed=v + trial, cycles=1)
            rows = run["t_s"], run["x_m"], run["p_tp_pa"], run["p_tr_pa"], run["f_applied_n"]
            file = tmp_path / name.format(v=v, trial=trial, code=code)
            file.parent.mkdir(exist_ok=True)
            np.savetxt(file, np.transpose(rows), "%.6g", ",", header="t,x,pA,pB,F", comments="")
    series = parse_yaml(suggest_map(tmp_path).text)["series"]
    if files is None:
        assert not any("{speed}" in each["files"] for each in series)
    else:
        assert [each["files"] for each in series] == [files]
        assert series[0]["speed_unit"] == "mm/s"


def test_the_unit_of_a_speed_in_the_names_is_that_of_the_motion(tmp_path):
    for v in (0.02, 0.05, 0.09):
        run = there_and_back(v, 2000.0, cycles=1)
        rows = run["t_s"], 1e3 * run["x_m"], run["p_tp_pa"], run["p_tr_pa"], run["f_applied_n"]
        file = tmp_path / f"v{v}.csv"
        np.savetxt(file, np.transpose(rows), "%.6g", ",", header="t,x,pA,pB,F", comments="")
    (series,) = parse_yaml(suggest_map(tmp_path).text)["series"]
    assert (series["files"], series["speed_unit"]) == ("v{speed}.csv", "m/s")


@pytest.mark.parametrize(("unit", "reading"), [("degC", 40.0), ("degF", 104.0), ("K", 313.15)])
def test_the_unit_of_an_oil_temperature_is_that_of_a_usual_one(tmp_path, unit, reading):
    run = there_and_back(0.05, 2000.0, cycles=1)
    oil = reading + 0.1 * np.sin(run["t_s"])
    rows = run["t_s"], run["x_m"], run["p_tp_pa"], run["p_tr_pa"], run["f_applied_n"], oil
    header = "t,x,pA,pB,F,oil temp"
    np.savetxt(tmp_path / "a.csv", np.transpose(rows), "%.6g", ",", header=header, comments="")
    columns = parse_yaml(suggest_map(tmp_path).text)["columns"]
    assert columns["temp_tank_k"] == {"column": "oil temp", "unit": unit}
