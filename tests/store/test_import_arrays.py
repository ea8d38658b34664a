"""MATLAB and Parquet files by a map, written by scipy and pandas."""

import sys

import numpy as np
import pytest
import yaml
from scipy.io import savemat

from hbench.config.import_layout import Format
from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import load_campaign
from hbench.store.formats.arrays import Arrays
from hbench.store.formats.text import parse_table
from hbench.store.importing.importer import import_folder

T = np.arange(0, 1.0, 0.01)
X = 40.0 * T  # mm
P = np.column_stack([60 + T, 15 - T])  # bar
F = np.full(len(T), 2.5)  # kN

MAT = {
    "plain vectors": ({"t": T, "x": X, "p": P[:, 0], "f": F}, "t", "x", "p", "f"),
    "fields of a struct": (
        {"data": {"t": T, "x": X, "p": P[:, 0], "force": {"f": F}}},
        *("data.t", "data.x", "data.p", "data.force.f"),
    ),
    "a struct array's element": (
        {"runs": np.array([{"log": {"t": T + i, "x": X, "p": P[:, 0], "f": F}} for i in (9, 0)])},
        *(f"runs(2).log.{name}" for name in ("t", "x", "p", "f")),
    ),
    "columns of a matrix": (
        {"M": np.column_stack([T, X, P[:, 0], F]), "note": "by hand"},
        *("M(:,1)", "M(:, 2)", "M( : ,3)", "M(:,4)"),
    ),
    "numbered columns of the only matrix": (
        {"M": np.column_stack([T, X, P[:, 0], F]), "rate": 100.0},
        *(1, 2, 3, 4),
    ),
    "integers": (
        {"t": (1e3 * T).astype(np.int32), "x": X.astype(np.float32), "p": P[:, 0], "f": F},
        *("t", "x", "p", "f"),
    ),
}


@pytest.fixture
def bring_in(tmp_path, at):
    def bring_in(name, columns, time_unit="s"):
        units = {"t_s": time_unit, "x_m": "mm", "p_tp_pa": "bar", "f_applied_n": "kN"}
        rules = {
            "name": "others",
            "columns": {
                channel: {"column": column, "unit": unit}
                for (channel, unit), column in zip(units.items(), columns, strict=True)
            },
            "constants": {"p_tr_pa": "0 bar"},
            "series": [{"label": "", "files": name, "cylinder": {"piston_diameter": "25 mm"}}],
        }
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        import_folder(tmp_path / "logs", tmp_path / "out", tmp_path / "map.yaml", {}, at(0))
        return next(load_campaign(tmp_path / "out").runs())

    (tmp_path / "logs").mkdir()
    return bring_in


@pytest.mark.parametrize("layout", MAT)
def test_matlab_columns_are_found_by_matlabs_own_notation(bring_in, tmp_path, layout):
    content, *columns = MAT[layout]
    savemat(tmp_path / "logs" / "a.mat", content, oned_as="column")
    run = bring_in("a.mat", columns, "ms" if layout == "integers" else "s")
    np.testing.assert_allclose(run.t_s, T, atol=1e-12)
    np.testing.assert_allclose(run.x_m, X / 1e3, rtol=1e-6)
    np.testing.assert_allclose(run.p_tp_pa, P[:, 0] * 1e5)
    np.testing.assert_allclose(run.f_applied_n, 2500)


@pytest.mark.parametrize(
    ("column", "message"),
    [
        ("data.q", r"'data.q'.* data.t \(100\), data.p \(100x2\), s\(1..2\).a"),
        ("data.p(:,3)", "'data.p"),
        ("data.p(:,0)x", "'data.p"),
        ("s(3).a", "'s"),
        ("data.p", "column data.p: .*100x2.*float64"),
        ("name", "column name: "),
        (2, "column 2: .* 0 matrices"),
        ("short", r"p_tp_pa .*\b3 .*t_s .*\b100\b"),
        ("holey", r"sample 4: column holey: .*inf"),
    ],
)
def test_matlab_columns_that_are_not_there_are_told_with_those_that_are(
    bring_in, tmp_path, column, message
):
    holey = np.where(np.arange(100) == 3, np.inf, 1.0)
    s = np.array([{"a": 1.0}, {"a": 2.0}])
    content = {"data": {"t": T, "p": P}, "s": s, "name": "x", "short": [1.0, 2, 3], "holey": holey}
    savemat(tmp_path / "logs" / "a.mat", content, oned_as="column")
    with pytest.raises(DataError, match=message):
        bring_in("a.mat", ["data.t", "data.p(:,2)", column, "data.t"])


@pytest.mark.parametrize("content", [b"not a mat file at all" * 20, b"\x89HDF\r\n\x1a\n" * 99])
def test_a_broken_matlab_file_is_refused(bring_in, tmp_path, content):
    (tmp_path / "logs" / "a.mat").write_bytes(content)
    with pytest.raises(DataError, match="a.mat: .*MATLAB"):
        bring_in("a.mat", "txpf")


@pytest.fixture
def frame():
    pd = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    return pd.DataFrame({"t": T, "x": X, "p": P[:, 0], "f": F})


def test_parquet_columns_are_found_by_name(bring_in, frame, tmp_path):
    frame.to_parquet(tmp_path / "logs" / "a.parquet")
    run = bring_in("a.parquet", "txpf")
    np.testing.assert_array_equal(run.t_s, T)
    np.testing.assert_allclose(run.p_tp_pa, P[:, 0] * 1e5)


def test_parquet_date_times_become_seconds(bring_in, frame, tmp_path):
    import pandas as pd

    frame["t"] = pd.Timestamp("2024-05-01T23:59:59.5") + pd.to_timedelta(T, unit="s")
    frame.to_parquet(tmp_path / "logs" / "a.parquet")
    np.testing.assert_allclose(bring_in("a.parquet", "txpf", "date-time").t_s, T, atol=1e-6)


def test_a_parquet_column_that_is_not_there_is_told_with_those_that_are(bring_in, frame, tmp_path):
    frame.to_parquet(tmp_path / "logs" / "a.parquet")
    with pytest.raises(DataError, match=r"'q'.* t \(100\), x \(100\)"):
        bring_in("a.parquet", "txqf")


def test_parquet_without_its_package_is_refused_with_what_to_install(
    bring_in, frame, tmp_path, monkeypatch
):
    frame.to_parquet(tmp_path / "logs" / "a.parquet")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(ConfigError, match="pyarrow") as caught:
        bring_in("a.parquet", "txpf")
    assert "pip install" in caught.value.hint


def test_a_table_lists_its_columns_as_a_map_gives_them():
    logs = [{"t": T, "p": P}] * 2
    table = Arrays({"M": np.zeros((9, 2)), "rate": 100.0, "note": "by hand", "runs": logs}, "a.mat")
    assert table.columns() == ("M(:,1)", "M(:,2)", "runs(1).t", "runs(1).p(:,1)", "runs(1).p(:,2)")
    assert all(len(table.numbers(column)) for column in table.columns())


def test_a_texts_columns_without_a_unique_name_are_numbered():
    text = parse_table(b"t,x,x,,f\n0,1,2,3,4\n", "a.csv", Format())
    assert text.columns() == ("t", 2, 3, 4, "f")
