"""Exports read back by what reads them: import, pandas, scipy, and Modelica's table format."""

import re
import shutil
from pathlib import Path
from unittest import mock

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from hbench import workflow
from hbench.cli.main import app
from hbench.errors import ConfigError
from hbench.store.campaign.folder import load_campaign
from tests.support import shared
from tests.support.cut_campaign import two_curves
from tests.support.seal_strokes import stroke_campaign, write_strokes

SAMPLES = Path(__file__).parents[2] / "data_samples"

pytestmark = pytest.mark.usefixtures("fitted_once")


def export(kind, campaign, folder):
    arguments = ["export", str(campaign), "--format", kind, "-o", str(folder)]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0 and "note:" not in result.stderr, result.output
    return folder


@pytest.fixture(scope="session")
def exported(tmp_path_factory):
    """Return a function that gives the folder of a sample's export, which tests only read."""

    def give(kind, sample="stribeck-small"):
        def make():
            return export(kind, SAMPLES / sample, tmp_path_factory.mktemp("export"))

        return shared.once(f"export-{sample}-{kind}", make)

    return give


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """A campaign of eight runs."""
    return two_curves(tmp_path_factory.mktemp("small") / "campaign")


@pytest.fixture(scope="module")
def results():
    campaign = load_campaign(SAMPLES / "stribeck-small")
    return workflow.results.derive(campaign)


@pytest.fixture(scope="module")
def screened():
    """With their samples, which results leave out."""
    return list(workflow.results.screened_runs(load_campaign(SAMPLES / "stribeck-small")))


def brought_back(folder, again):
    """Import exported files, and return what the analysis gives."""
    result = CliRunner().invoke(app, ["import", str(folder), "-o", str(again)])
    assert result.exit_code == 0 and "note:" not in result.stderr, result.output
    return workflow.analyze(again)


@pytest.mark.parametrize("kind", ["csv", "parquet", "mat"])
def test_an_exported_campaign_comes_back_by_import_with_the_same_curves(
    tmp_path, exported, results, kind
):
    found = brought_back(exported(kind), tmp_path / "again")
    assert found.curves == results.curves
    assert found.efficiency == results.efficiency


@pytest.fixture(scope="module")
def strokes(tmp_path_factory):
    """Campaigns of strokes without set speeds, with limits, instruments and cylinders of a map."""
    folder = tmp_path_factory.mktemp("strokes")
    logs = write_strokes(folder / "logs", "seal", {0: (40, 5), 4: (60, 5)}, scatter_n=1.0)
    write_strokes(folder / "large", "large", {4: (90, 5)}, scatter_n=1.0, seed=1)
    shutil.copy(folder / "large" / "large_4bar.csv", logs)
    rules = yaml.safe_load((logs / "map.yaml").read_text())
    tolerance = {"tolerance": "0.5 %", "of": "full_scale"}
    rules["instruments"] = {
        "force": {**tolerance, "full_scale": "500 N"},
        "pressure": {**tolerance, "full_scale": "10 bar"},
    }
    rules["moving_mass"] = "2 kg"
    rules["details"] = {"oil": "none"}
    (series,) = rules["series"]
    cylinder = {"piston_diameter": "26 mm", "rod_diameter": "10 mm", "stroke": "50 mm"}
    other = {"label": "large", "files": "large_{pressure}bar.csv", "cylinder": cylinder}
    other["factors"] = {"grease": 'PTFE, "white"', "temperature": "20 °C"}
    rules["series"] = [series, other]
    (logs / "map.yaml").write_text(yaml.safe_dump(rules))
    return stroke_campaign(logs, folder / "campaign")


@pytest.fixture(scope="module")
def analyzed_strokes(strokes):
    return workflow.analyze(strokes)


@pytest.fixture(scope="module")
def strokes_csv(strokes, tmp_path_factory):
    return export("csv", strokes, tmp_path_factory.mktemp("csv"))


@pytest.mark.parametrize("kind", ["csv", "parquet", "mat"])
def test_foreign_strokes_come_back_with_their_positions_cylinders_and_limits(
    tmp_path, strokes, analyzed_strokes, kind
):
    own = analyzed_strokes
    plan = own.runs[0].run.plan
    assert plan.speed_is_measured and plan.positions_m and own.curves[0].points[0].u95_n
    assert own.curves[-1].factor_values["temperature"] == "20 °C"
    found = brought_back(export(kind, strokes, tmp_path / kind), tmp_path / "again")
    assert [run.run.plan for run in found.runs] == [run.run.plan for run in own.runs]
    assert found.curves == own.curves
    assert found.bands == own.bands and found.band_trends == own.band_trends
    assert found.notes[-1] == own.notes[-1]
    assert found.provenance.details["oil"] == "none"
    first, again = (load_campaign(f) for f in (strokes, tmp_path / "again"))
    assert again.setup() == first.setup() and again.screening() == first.screening()


@pytest.mark.parametrize(
    ("column", "cell", "words"),
    [
        ("speed_is_measured", "maybe", "expected True or False"),
        ("x_low_m", "low", "expected a number"),
        ("factors", "[1]", 'expected {"name": "value"}'),
        ("factors", "{", 'expected {"name": "value"}'),
        ("area_rod_m2", "", "missing, but other sizes of the cylinder are given"),
    ],
)
def test_an_edited_index_is_refused_with_line_and_column(
    tmp_path, strokes_csv, column, cell, words
):
    import pandas as pd

    shutil.copytree(strokes_csv, tmp_path / "csv")
    index = pd.read_csv(tmp_path / "csv" / "runs.csv", dtype=str)
    index.loc[1, column] = cell
    index.to_csv(tmp_path / "csv" / "runs.csv", index=False)
    arguments = ["import", str(tmp_path / "csv"), "-o", str(tmp_path / "again")]
    error = CliRunner().invoke(app, arguments).exception
    assert f"line 3: {column} {cell!r}: {words}" in error.message


def test_a_cylinder_of_the_index_that_contradicts_the_bench_file_is_reported(tmp_path, exported):
    folder = shutil.copytree(exported("csv"), tmp_path / "csv")
    text = (folder / "bench.yaml").read_text()
    bench = yaml.safe_load(text)
    bench["test_cylinder"]["piston_diameter"] = "50 mm"
    (folder / "bench.yaml").write_text(yaml.safe_dump(bench))
    result = CliRunner().invoke(app, ["import", str(folder), "-o", str(tmp_path / "again")])
    assert "runs have another cylinder in the index than in bench.yaml" in result.stderr


def test_rejected_runs_are_exported_with_their_reasons(exported):
    import pandas as pd

    folder = exported("csv", "bad-runs")
    index = pd.read_csv(folder / "runs.csv", dtype={"run": str})
    rejected = index[~index.accepted]
    assert len(rejected) > 3
    assert rejected.reason.str.contains("end_stop|off_reference|truncated").any()
    assert all((folder / name).exists() for name in index.file)


@pytest.mark.parametrize("kind", ["csv", "parquet", "mat"])
def test_an_incomplete_log_is_still_rejected_when_it_comes_back(tmp_path, exported, kind):
    copy = tmp_path / "bad-runs"
    shutil.copytree(SAMPLES / "bad-runs", copy)
    own = workflow.analyze(copy)
    found = brought_back(exported(kind, "bad-runs"), tmp_path / "again")
    truncated = [run.reason for run in own.runs if "truncated" in run.reason]
    assert (
        truncated and [run.reason for run in found.runs if "truncated" in run.reason] == truncated
    )
    assert found.curves == own.curves


def test_what_was_saturated_is_so_when_it_comes_back(tmp_path, exported):
    folder, again = exported("csv", "bad-runs"), tmp_path / "again"
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


def test_parquet_holds_the_same_samples(exported, screened):
    pd = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    folder = exported("parquet")
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


def test_the_matlab_file_is_a_struct_array_of_runs(exported, screened):
    from scipy.io import loadmat

    folder = exported("mat")
    runs = loadmat(folder / "campaign.mat", squeeze_me=True, struct_as_record=False)["runs"]
    assert len(runs) == len(screened)
    run = screened[3].run
    assert runs[3].run == run.plan.run and runs[3].f_load_n == run.plan.f_load_n
    np.testing.assert_array_equal(runs[3].log.f_applied_n, run.f_applied_n)
    assert runs[3].log.t_s.shape == run.t_s.shape


def test_curves_and_fits_stand_in_a_matlab_file_of_their_own(exported, results):
    from scipy.io import loadmat

    folder = exported("mat")
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


def test_the_modelica_file_has_a_table_for_each_curve_and_fit(exported, results):
    text = (exported("modelica") / "friction.txt").read_text()
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


def test_an_export_into_a_campaign_is_refused_and_no_log_is_replaced(tmp_path, exported):
    campaign = tmp_path / "imported"
    CliRunner().invoke(app, ["import", str(exported("csv")), "-o", str(campaign)])
    log = campaign / "runs" / "0001.csv"
    before = log.read_bytes()
    for source in (SAMPLES / "stribeck-small", campaign):
        with pytest.raises(ConfigError, match="imported: contains a campaign already"):
            workflow.export(source, campaign, "csv")
    assert log.read_bytes() == before


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("csv", "runs/0001.csv"),
        ("csv", "runs.csv"),
        ("csv", "bench.yaml"),
        ("parquet", "bench.yaml"),
        ("mat", "bench.yaml"),
        ("mat", "curves.mat"),
    ],
)
def test_an_export_of_runs_replaces_no_log_and_no_bench_file(tmp_path, small, kind, name):
    """Such as raw logs in the layout of an export, or the bench file that a user has edited."""
    own = tmp_path / name
    own.parent.mkdir(exist_ok=True)
    own.write_text("mine\n")
    with pytest.raises(ConfigError, match="exists already with other content, and"):
        workflow.export(small, tmp_path, kind)
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == [own]
    assert own.read_text() == "mine\n"


@pytest.mark.parametrize("kind", ["csv", "parquet", "mat"])
def test_an_export_can_be_repeated_and_writes_the_same_bytes(tmp_path, exported, kind):
    def content():
        return {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}

    shutil.copytree(exported(kind), tmp_path, dirs_exist_ok=True)
    first = content()
    with mock.patch("time.asctime", lambda: "another time"):  # scipy writes it into a MATLAB file
        assert workflow.export(SAMPLES / "stribeck-small", tmp_path, kind) == len(first)
    assert content() == first


def test_an_import_into_the_imported_folder_replaces_none_of_its_logs(tmp_path, exported, clock):
    logs = tmp_path / "logs"
    shutil.copytree(exported("csv"), logs)
    log = next((logs / "runs").iterdir())
    log.write_text(log.read_text().replace("\n", ",\n"))  # a column more, which an import drops
    before = log.read_bytes()
    with pytest.raises(ConfigError, match="runs: is a part of the imported folder"):
        workflow.import_runs(logs, logs, None, clock)
    assert log.read_bytes() == before and not (logs / "campaign.yaml").exists()
