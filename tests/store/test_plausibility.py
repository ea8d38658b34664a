"""Columns that state absolute pressures: the atmosphere acts on the rod, and is not measured."""

import numpy as np
import pytest

from hbench.errors import DataError
from hbench.store.importing.plausibility import is_absolute_pressure
from hbench.store.suggesting.suggest import suggest_map
from tests.support.strokes import there_and_back


@pytest.mark.parametrize(
    "name",
    ["Druck A [bara]", "p_A bar(a)", "pA (psia)", "p1 kPa abs", "p1 [bar abs.]", "p_A [MPa(a)]",
     "Absolutdruck A [bar]", "p_abs_A", "pressure_psia", "Druck B absolut (bar)"],
)  # fmt: skip
def test_an_absolute_pressure_is_one_by_its_name(name):
    assert is_absolute_pressure("p_tp_pa", name)
    assert not is_absolute_pressure("x_m", name)


@pytest.mark.parametrize(
    "name",
    ["p_A [bar]", "Druck A bar", "p bar A", "barA", "p_bar_a", "p_Pa", "absorber [bar]",
     "p_tp_pa", "Abstand", "bar g", "[barg]"],
)  # fmt: skip
def test_other_names_are_those_of_pressures_above_the_atmosphere(name):
    assert not is_absolute_pressure("p_tp_pa", name)


@pytest.fixture
def logs(tmp_path):
    """Return a folder with logs of strokes; their pressures are absolute, in bara."""
    folder = tmp_path / "logs"
    folder.mkdir()
    for trial in (1, 2, 3):
        run = there_and_back(0.03, 1500.0, trial)
        rows = np.stack(
            [
                run["t_s"],
                1e3 * run["x_m"],
                run["p_tp_pa"] / 1e5 + 1.013,
                run["p_tr_pa"] / 1e5 + 1.013,
                run["f_applied_n"],
            ],
            axis=1,
        )
        header = "t [s],x [mm],p_A [bara],p_B [bara],F [N]"
        np.savetxt(folder / f"{trial}.csv", rows, "%.5f", ",", header=header, comments="")
    return folder


@pytest.mark.parametrize("by_number", [False, True])
def test_an_absolute_pressure_without_an_offset_is_refused(rules, import_by, logs, by_number):
    rules["columns"] = {
        "t_s": {"column": "t [s]", "unit": "s"},
        "x_m": {"column": "x [mm]", "unit": "mm"},
        "p_tp_pa": {"column": 3 if by_number else "p_A [bara]", "unit": "bar"},
        "p_tr_pa": {"column": 4 if by_number else "p_B [bara]", "unit": "bar"},
        "f_applied_n": {"column": "F [N]", "unit": "N"},
    }
    del rules["constants"]
    rules["series"][0]["files"] = "{trial}.csv"
    rules["cut"] = "reversals"
    with pytest.raises(DataError, match=r"absolute pressure.*p_tp_pa") as caught:
        import_by(rules, logs)
    assert "'offset: -1.013 bar' at columns.p_tp_pa" in caught.value.hint
    for channel in ("p_tp_pa", "p_tr_pa"):
        rules["columns"][channel]["offset"] = "-1.013 bar"
    runs, _ = import_by(rules, logs)
    assert np.mean(runs[0].p_tr_pa) == pytest.approx(8e5, rel=1e-3)


def test_a_suggested_map_subtracts_the_atmosphere(logs):
    text = suggest_map(logs).text
    assert 'p_tp_pa: {column: "p_A [bara]", unit: bar, offset: -1.013 bar}' in text
    assert 'p_tr_pa: {column: "p_B [bara]", unit: bar, offset: -1.013 bar}' in text


@pytest.mark.parametrize(("offset_bar", "is_noted"), [(-9.5, True), (-8.5, False)])
def test_a_pressure_below_a_vacuum_is_noted(rules, import_by, logs, offset_bar, is_noted):
    """The rod side has 8 bar."""
    rules["columns"] = {
        "t_s": {"column": "t [s]", "unit": "s"},
        "x_m": {"column": "x [mm]", "unit": "mm"},
        "p_tr_pa": {"column": 4, "unit": "bar", "offset": f"{offset_bar - 1.013} bar"},
    }
    rules["constants"] = {"p_tp_pa": "20 bar"}
    rules["series"][0]["files"] = "{trial}.csv"
    rules["cut"] = "reversals"
    _, notes = import_by(rules, logs)
    found = [note for note in notes if "below a vacuum" in note]
    assert len(found) == is_noted
    assert all("p_tr_pa: down to -1.5" in note and "(-1.013 bar)" in note for note in found)


@pytest.mark.parametrize(
    ("column", "factor", "channel", "units"),
    [
        (2, 0.1, "p_tp_pa", "bar and MPa"),
        (3, 1e5, "p_tr_pa", "Pa and bar"),
        (2, 14.504, "p_tp_pa", "psi and bar"),
        (4, 1e-3, "f_applied_n", "N and kN"),
        (2, 1.5, "", ""),
    ],
)
def test_a_file_with_another_unit_than_the_other_trials_is_noted(
    rules, import_by, tmp_path, column, factor, channel, units
):
    (tmp_path / "logs").mkdir()
    for trial in (1, 2, 3):
        run = there_and_back(0.03, 1500.0, trial)
        rows = np.stack(
            [
                run["t_s"],
                1e3 * run["x_m"],
                run["p_tp_pa"] / 1e5,
                run["p_tr_pa"] / 1e5,
                run["f_applied_n"],
            ],
            axis=1,
        )
        rows[:, column] *= factor if trial == 2 else 1
        np.savetxt(tmp_path / "logs" / f"{trial}.csv", rows, "%.7g", ",", header="t,x,a,b,f")
    names = (
        ("t_s", "s"),
        ("x_m", "mm"),
        ("p_tp_pa", "bar"),
        ("p_tr_pa", "bar"),
        ("f_applied_n", "N"),
    )
    rules["columns"] = {
        name: {"column": number, "unit": unit} for number, (name, unit) in enumerate(names, start=1)
    }
    del rules["constants"]
    rules["series"][0]["files"] = "{trial}.csv"
    rules["cut"] = "reversals"
    _, notes = import_by(rules, tmp_path / "logs")
    unlike = [note for note in notes if "mistaken for one another" in note]
    if not channel:
        assert not unlike
        return
    (note,) = unlike
    assert note.startswith(f"2.csv: {channel}: has {factor:.3g} times its values in other files")
    assert f"as if {units} were mistaken" in note
