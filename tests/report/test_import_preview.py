"""The preview of an import: the numbers of the import itself, and errors as rows."""

import json

import numpy as np
import pytest
import yaml
from matplotlib import rc_context
from typer.testing import CliRunner

from hbench import workflow
from hbench.cli.main import app
from hbench.report.import_preview.figures import draw_file, window_of
from hbench.report.import_preview.page import channel_table, file_table, run_table
from hbench.report.render import style
from hbench.report.render.series import series_of
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.results import screened_runs
from tests.support.strokes import one_stroke, there_and_back

RULES = {
    "name": "preview",
    "columns": {
        "t_s": {"column": "t_s"},
        "x_m": {"column": "x", "unit": "mm"},
        "p_tp_pa": {"column": "p_tp_pa"},
        "p_tr_pa": {"column": "p_tr_pa"},
        "f_applied_n": {"column": "f", "unit": "kN"},
    },
    "series": [
        {
            "label": "strokes",
            "files": "{speed}mm_s_{trial}.csv",
            "cylinder": {"piston_diameter": "40 mm", "rod_diameter": "25 mm"},
        }
    ],
}


def write(path, run, offset_n=0.0):
    columns = (run["t_s"], 1e3 * run["x_m"], run["p_tp_pa"], run["p_tr_pa"])
    rows = np.column_stack([*columns, (run["f_applied_n"] + offset_n) / 1e3])
    np.savetxt(path, rows, delimiter=",", header="t_s,x,p_tp_pa,p_tr_pa,f", comments="")


@pytest.fixture
def make(tmp_path):
    """Return a function that writes logs and a map with other rules, and gives both paths."""

    def make(files, **changes):
        (tmp_path / "logs").mkdir()
        for name, content in files.items():
            path = tmp_path / "logs" / name
            write(path, **content) if isinstance(content, dict) else path.write_text(content)
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(RULES | changes))
        return tmp_path / "logs", tmp_path / "map.yaml"

    return make


def texts(table):
    return [dict(zip(table.head, (cell.text for cell in row), strict=True)) for row in table.rows]


def known(means):
    numbers = vars(means) | {f"u of {name}": u for name, u in means.u_steps.items()}
    return {name: value for name, value in numbers.items() if isinstance(value, int | float)}


def test_its_runs_are_those_of_the_import(make, tmp_path, clock):
    logs, map_file = make(
        {
            "50mm_s_1.csv": {"run": there_and_back(0.05, 500.0)},
            "80mm_s_1.csv": {"run": there_and_back(0.05, 500.0, 1)},  # not its speed
        },
        cut="reversals",
    )
    preview = workflow.preview_import(logs, map_file)
    assert not (tmp_path / "campaign").exists()
    workflow.import_runs(logs, tmp_path / "campaign", map_file, clock)
    imported = list(screened_runs(load_campaign(tmp_path / "campaign")))
    previewed = [run.screened for run in preview.runs]
    assert [run.run.plan for run in previewed] == [run.run.plan for run in imported]
    assert [run.reasons for run in previewed] == [run.reasons for run in imported]
    for here, there in zip(previewed, imported, strict=True):
        assert known(here.means) == pytest.approx(known(there.means), rel=1e-12)
    first, second = texts(file_table(preview))
    assert (first["Accepted"], first["Reasons to reject"]) == (first["Runs"], "")
    assert (
        second["Accepted"] == "0"
        and f"off reference ({second['Runs']})" in second["Reasons to reject"]
    )
    assert [file.log is not None for file in preview.files] == [True, True]  # another reason


def test_what_cant_be_imported_is_a_row(make, tmp_path):
    good, still = one_stroke(0.05, 0.0), one_stroke(0.0, 0.0)
    logs, map_file = make(
        {
            "50mm_s_1.csv": {"run": good},
            "50mm_s_2.csv": "t_s,x,p_tp_pa,p_tr_pa,f\n0,1,2,three,4\n",
            "50mm_s_3.csv": "other,columns\n1,2\n",
            "50mm_s_4.csv": {"run": still},
            "<b>notes.txt": "no log",
        },
        series=[*RULES["series"], RULES["series"][0] | {"label": "none", "files": "none_*.csv"}],
    )
    preview = workflow.preview_import(logs, map_file)
    errors = {file.name: file.error for file in preview.files}
    assert {name for name, error in errors.items() if error} == {
        f"50mm_s_{k}.csv" for k in (2, 3, 4)
    }
    assert "line 2" in errors["50mm_s_2.csv"] and "min_stroke" in errors["50mm_s_4.csv"]
    assert preview.empty_series == {"none": "none_*.csv"}
    assert preview.unmatched == ("<b>notes.txt",)
    rows = texts(file_table(preview))
    assert [row["Samples"] for row in rows] == ["350", "–", "–", "350", "–"]
    page = workflow.write_import_preview(tmp_path / "out", preview).read_text()
    assert "<b>notes" not in page and "&lt;b&gt;notes" in page
    assert page.count("<figure ") == 1


def test_a_figure_shows_rest_windows_and_both_sides_of_the_zero(make):
    run = one_stroke(0.05, 0.0)
    run["f_applied_n"] += 800.0 * (run["t_s"] > 1.0)
    gap = {key: np.delete(values, slice(220, 240)) for key, values in run.items()}
    columns = {k: dict(v) for k, v in RULES["columns"].items()}
    columns["f_applied_n"]["zero"] = "rest"
    logs, map_file = make(
        {"50mm_s_1.csv": {"run": run, "offset_n": 25.0}, "50mm_s_2.csv": {"run": gap}},
        columns=columns,
    )
    preview = workflow.preview_import(logs, map_file)
    accepted, rejected = preview.files
    assert accepted.log.rest_s == pytest.approx((0.0, 0.9), abs=0.02)
    assert (accepted.rate_hz, accepted.duration_s) == pytest.approx((100.0, 3.49))
    assert rejected.longest_step_s == pytest.approx(0.21)
    (channel,) = (c for c in accepted.channels if c.name == "f_applied_n")
    assert channel.zero == pytest.approx(25.0, abs=1.0) and channel.unit_in_file == "kN"
    row = texts(channel_table(accepted))[-1]
    assert row["Channel"] == "F_applied" and row["Unit in the file"] == "kN"
    with rc_context(style.RC):
        series = {line.label: line for line in series_of(draw_file(accepted))}
    difference = np.array(series["F_applied, as logged"].y) - np.array(series["F_applied"].y)
    np.testing.assert_allclose(difference, channel.zero)
    np.testing.assert_allclose(series["nominal"].y, 50.0)
    (shown,) = accepted.runs
    assert window_of(shown) == (shown.screened.means.t_start_s, shown.screened.means.t_stop_s)
    assert shown.at_speed_s == pytest.approx((1.0, 3.49), abs=0.05)
    assert texts(run_table(rejected))[0]["Verdict"].startswith("rejected: gapped")


def test_a_long_log_is_drawn_by_its_extremes(make):
    run = one_stroke(0.05, 0.0, rate_hz=5000.0)
    run["f_applied_n"][12_345] = 900.0
    logs, map_file = make({"50mm_s_1.csv": {"run": run}})
    (file,) = workflow.preview_import(logs, map_file).files
    with rc_context(style.RC):
        series = {line.label: line for line in series_of(draw_file(file))}
    force = np.array(series["F_applied"].y)
    assert len(force) < 2000 and np.nanmax(force) == pytest.approx(900.0)


def test_the_command_writes_the_page_and_no_campaign(make, tmp_path, undrawn):
    logs, map_file = make({"50mm_s_1.csv": {"run": one_stroke(0.05, 0.0)}})
    out = tmp_path / "out"
    arguments = ["import", str(logs), "--map", str(map_file), "--preview", str(out), "--json"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    answer = json.loads(result.stdout)
    assert (answer["schema"], answer["runs"], answer["accepted"], answer["errors"]) == (
        "hbench.import-preview/1", 1, 1, {}
    )  # fmt: skip
    assert sorted(path.name for path in out.iterdir()) == ["figures", "preview.html"]


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--preview", "p"],
        ["--preview", "p", "--map", "m.yaml", "-o", "c"],
        ["--suggest", "--map", "m.yaml"],
    ],
)
def test_options_that_contradict_each_other_are_refused(options, tmp_path):
    result = CliRunner().invoke(app, ["import", str(tmp_path), *options])
    assert result.exception.exit_code == 2
