"""Recordings of Simulink and dSPACE ControlDesk in MATLAB files up to version 7."""

import numpy as np
import pytest
from scipy.io import savemat

from hbench.config.files.yaml_text import parse_yaml
from hbench.store.suggesting.suggest import suggest_map

T = np.arange(0, 4, 0.01)
X = 20 + np.interp(T, [0, 1, 3.5], [0, 0, 100])  # mm
P = 60 + np.sin(40 * T)  # bar
F = 2500 + np.cos(50 * T)  # N
CYLINDER = {"piston_diameter": "40 mm"}


def struct_array(*rows):
    array = np.zeros((1, len(rows)), dtype=[(name, object) for name in rows[0]])
    for number, row in enumerate(rows):
        array[0, number] = tuple(row.values())
    return array


def structure_with_time(*labels):
    """Three signals, the last one as a matrix with an idle column."""
    values = X, P, np.column_stack([F, 0 * F])
    signals = ({"values": v, "label": n} for v, n in zip(values, labels, strict=True))
    return {"time": T, "signals": struct_array(*signals), "blockName": "rig/Scope"}


def recording(start):
    """Two rasters: the position's is the second."""
    signals = (("Weg", X, "mm", 2), ("p_A", P[::2], "bar", 1), ("Kraft", F, "N", 2))
    rows = (dict(zip(("Name", "Data", "Unit", "XIndex"), row, strict=True)) for row in signals)
    times = struct_array({"Name": "slow", "Data": start + T[::2]}, {"Name": "", "Data": start + T})
    return {"X": times, "Y": struct_array(*rows), "Description": "by hand"}


def check(run):
    np.testing.assert_allclose(run.x_m, X[: len(run.x_m)] / 1e3, atol=1e-9)
    np.testing.assert_allclose(np.diff(run.t_s), 0.01, atol=1e-6)
    np.testing.assert_allclose(run.f_applied_n, F[: len(run.x_m)], rtol=1e-6)
    np.testing.assert_allclose(run.p_tp_pa[::2], 1e5 * P[: len(run.x_m) : 2], rtol=1e-6)


@pytest.mark.parametrize("by_path", [False, True])
@pytest.mark.parametrize("names", [("Weg", "p_A"), ("", "")])
def test_signals_of_a_structure_with_time_are_found_by_label_or_path(
    rules, import_by, tmp_path, names, by_path
):
    content = {"ScopeData": structure_with_time(*names, "")}
    savemat(tmp_path / "a.mat", content, oned_as="column")
    columns = [name or f"ScopeData.signals({k}).values" for k, name in enumerate(names, start=1)]
    rules["series"][0] |= {"files": "a.mat", "cylinder": CYLINDER}
    rules["columns"] = {
        "x_m": {"column": columns[0], "unit": "mm"},
        "p_tp_pa": {"column": columns[1], "unit": "bar"},
        "f_applied_n": {"column": "ScopeData.signals(3).values(:,1)", "unit": "N"},
    }
    if by_path:
        rules["columns"]["t_s"] = {"column": "ScopeData.time", "unit": "s"}
        rules["columns"]["x_m"]["column"] = "ScopeData.signals(1).values"
    (run,), _ = import_by(rules)
    check(run)


def test_a_suggested_map_names_the_signals_of_files_whose_struct_has_the_files_name(
    tmp_path, rules, import_by
):
    (tmp_path / "logs").mkdir()
    for number in (1, 2):
        name = f"run_{number}"
        savemat(tmp_path / f"logs/{name}.mat", {name: recording(10.0 * number)}, oned_as="row")
    text = suggest_map(tmp_path / "logs").text
    columns = parse_yaml(text)["columns"]
    assert {key: column["column"] for key, column in columns.items()} == {
        "x_m": "Weg",
        "p_tp_pa": "p_A",
        "f_applied_n": "Kraft",
    }
    (tmp_path / "logs/run_1.mat").rename(tmp_path / "a.mat")
    rules["series"][0] |= {"files": "a.mat", "cylinder": CYLINDER}
    rules["columns"] = columns
    (run,), _ = import_by(rules)
    check(run)
