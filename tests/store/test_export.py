"""Exports read back by what reads them: import, pandas, scipy, and Modelica's table format."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from hbench import workflow
from hbench.cli.main import app
from hbench.store.campaign.folder import load_campaign

SAMPLES = Path(__file__).parents[2] / "data_samples"


def exported(kind, folder, sample="stribeck-small"):
    arguments = ["export", str(SAMPLES / sample), "--format", kind, "-o", str(folder)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    return folder


@pytest.fixture(scope="module")
def results():
    campaign = load_campaign(SAMPLES / "stribeck-small")
    return workflow.results.derive(campaign)


@pytest.fixture(scope="module")
def screened():
    """With their samples, which results leave out."""
    return list(workflow.results.screened_runs(load_campaign(SAMPLES / "stribeck-small")))


@pytest.mark.parametrize("kind", ["csv", "parquet", "mat"])
def test_an_exported_campaign_comes_back_by_import_with_the_same_curves(tmp_path, results, kind):
    folder = exported(kind, tmp_path / kind)
    again = tmp_path / "again"
    result = CliRunner().invoke(app, ["import", str(folder), "-o", str(again)])
    assert result.exit_code == 0 and "note:" not in result.stderr
    found = workflow.analyze(again)
    assert [len(curve.points) for curve in found.curves] == [len(c.points) for c in results.curves]
    for ours, theirs in zip(results.curves, found.curves, strict=True):
        assert (ours.direction, ours.f_load_n) == (theirs.direction, theirs.f_load_n)
        assert ours.specimen == theirs.specimen
        for p, q in zip(ours.points, theirs.points, strict=True):
            # The window begins within a few samples: the reference counts as reached within 0.1 %.
            assert abs(q.friction_n - p.friction_n) < 0.1 * p.ci95_n
            assert q.ci95_n == pytest.approx(p.ci95_n, rel=0.2)


def test_rejected_runs_are_exported_with_their_reasons(tmp_path):
    import pandas as pd

    index = pd.read_csv(exported("csv", tmp_path, "bad-runs") / "runs.csv", dtype={"run": str})
    rejected = index[~index.accepted]
    assert len(rejected) > 3
    assert rejected.reason.str.contains("end_stop|off_reference|truncated").any()
    assert all((tmp_path / name).exists() for name in index.file)


def test_what_was_saturated_is_so_when_it_comes_back(tmp_path):
    folder, again = exported("csv", tmp_path / "csv", "bad-runs"), tmp_path / "again"
    assert CliRunner().invoke(app, ["import", str(folder), "-o", str(again)]).exit_code == 0

    def saturated(campaign):
        runs = workflow.analyze(campaign).runs
        return {
            (one.run.plan.run, reason.split(":")[0])
            for one in runs
            for reason in one.reasons
            if "saturated" in reason.split(":")[0]
        }

    copy = tmp_path / "bad-runs"
    shutil.copytree(SAMPLES / "bad-runs", copy)
    assert len({code for _, code in saturated(copy)}) == 2
    assert saturated(again) == saturated(copy)


def test_parquet_holds_the_same_samples(tmp_path, screened):
    pd = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    folder = exported("parquet", tmp_path)
    index = pd.read_parquet(folder / "runs.parquet")
    assert list(index.run) == [one.run.plan.run for one in screened]
    run = screened[7].run
    table = pd.read_parquet(folder / index.file[7])
    np.testing.assert_array_equal(table.p_tp_pa, run.p_tp_pa)
    np.testing.assert_array_equal(table.t_s, run.t_s)
    assert set(table.run) == {run.plan.run}


def test_parquet_without_its_package_is_refused_with_what_to_install(tmp_path, monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "pyarrow", None)
    arguments = ["export", str(SAMPLES / "stribeck-small"), "--format", "parquet"]
    error = CliRunner().invoke(app, [*arguments, "-o", str(tmp_path / "p")]).exception
    assert "pyarrow" in error.message and "pip install" in error.hint


def test_the_matlab_file_is_a_struct_array_of_runs(tmp_path, screened):
    from scipy.io import loadmat

    folder = exported("mat", tmp_path)
    runs = loadmat(folder / "campaign.mat", squeeze_me=True, struct_as_record=False)["runs"]
    assert len(runs) == len(screened)
    run = screened[3].run
    assert runs[3].run == run.plan.run and runs[3].f_load_n == run.plan.f_load_n
    np.testing.assert_array_equal(runs[3].log.f_applied_n, run.f_applied_n)
    assert runs[3].log.t_s.shape == run.t_s.shape


def test_curves_and_fits_stand_in_a_matlab_file_of_their_own(tmp_path, results):
    from scipy.io import loadmat

    folder = exported("mat", tmp_path)
    curves = loadmat(folder / "curves.mat", squeeze_me=True, struct_as_record=False)["curves"]
    assert len(curves) == len(results.curves)
    ours, theirs = results.curves[2], curves[2]
    assert (theirs.direction, theirs.f_load_n) == (ours.direction, ours.f_load_n)
    np.testing.assert_array_equal(theirs.friction_n, [p.friction_n for p in ours.points])
    fit = np.atleast_1d(theirs.fits)[0]
    own = ours.fits[0].parameters["f_stiction_n"]
    assert fit.law == ours.fits[0].law
    assert fit.parameters.f_stiction_n.value == own.value
    assert tuple(fit.parameters.f_stiction_n.ci95) == own.ci95


def test_the_modelica_file_has_a_table_for_each_curve_and_fit(tmp_path, results):
    text = (exported("modelica", tmp_path) / "friction.txt").read_text()
    assert text.startswith("#1\n")
    tables = re.findall(r"^double (\w+)\((\d+),(\d)\)\n((?:  \S.*\n)+)", text, re.MULTILINE)
    assert len(tables) == sum(1 + sum(bool(fit.line) for fit in c.fits) for c in results.curves)
    assert len({name for name, *_ in tables}) == len(tables)
    for name, rows, columns, body in tables:
        values = np.array([line.split() for line in body.splitlines()], dtype=float)
        assert values.shape == (int(rows), int(columns))
        assert int(columns) == (3 if name.startswith("measured") else 2)
        assert (np.diff(values[:, 0]) > 0).all(), name
    name, _, _, body = tables[0]
    assert name == "measured_extend_1000N"
    assert any(name == "measured_retract_minus_1000N" for name, *_ in tables)
    points = results.curves[0].points
    read = np.array([line.split() for line in body.splitlines()], dtype=float)
    np.testing.assert_array_equal(read[:, 1], [p.friction_n for p in points])


def test_an_export_is_told_in_one_line(tmp_path):
    arguments = ["export", str(SAMPLES / "stribeck-small"), "--format", "modelica"]
    result = CliRunner().invoke(app, [*arguments, "-o", str(tmp_path)])
    assert result.stdout == f"{tmp_path}: 1 file\n"
