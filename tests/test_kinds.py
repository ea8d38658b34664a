"""The table of experiment kinds, against every stage that dispatches on its columns."""

import json
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import get_args, get_type_hints

import pytest
import yaml
from jsonschema import Draft202012Validator
from typer.testing import CliRunner

from hbench import workflow
from hbench.cli.main import app
from hbench.config.experiments import PROFILE_SECTIONS
from hbench.errors import ConfigError
from hbench.experiment.kind_support import STAGES
from hbench.experiment.motions import PROFILES
from hbench.experiment.plan import plan_runs
from hbench.experiment.upload import uploads
from hbench.protocol.codec import BY_NAME, pack, unpack
from hbench.records import KINDS
from hbench.records.kinds import ExperimentKind
from hbench.report.campaign.figures import FIGURE_NAMES
from hbench.report.campaign.figures.all_figures import FIGURES
from hbench.rig.client import Identity
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.results import derive

CONFIGS = Path(__file__).parents[1] / "configs"
LOAD = {"p_lr": "15 bar", "loads": ["2000 N"], "hold": "0.2 s", "trials": 2}
TRAVEL = {"travel": {"start": "140 mm", "end": "240 mm"}}
EXAMPLES = {  # one experiment of each kind
    "steady": TRAVEL
    | {"direction": "extend", "velocities": ["60 mm/s", "80 mm/s", "120 mm/s"]}
    | {"acceleration": "2 m/s^2", "window": "0.5 s"},
    "ramp": TRAVEL | {"direction": "extend", "speed": "120 mm/s", "accelerations": ["0.1 m/s^2"]},
    "triangle": TRAVEL | {"speed": "100 mm/s", "cycles": 2},
    "steps": TRAVEL | {"levels": ["50 mm/s", "-50 mm/s"], "dwell": "0.6 s"},
    "hold": {"positions": ["200 mm"], "duration": "1.5 s"},
    "breakaway": {"direction": "retract", "position": "200 mm", "dwells": ["0.3 s"]}
    | {"rate": "2000 N/s", "rise": "4000 N"},
    "check": {"vent": "2 s"},
    "verification": TRAVEL
    | {"profile": [{"velocity": "40 mm/s", "acceleration": "0.2 m/s^2", "duration": "1 s"}]},
}
BOARD = Identity("f", "b", 1, 10_000, 1024, max_steps=128, max_segments=104)


def schedule_file(folder, *kinds):
    keys = {"check": {"trials": 2}, "breakaway": {k: v for k, v in LOAD.items() if k != "hold"}}
    experiments = [keys.get(kind, LOAD) | EXAMPLES[kind] | {"kind": kind} for kind in kinds]
    bench = str(CONFIGS / "bench-aau.yaml")
    path = folder / "schedule.yaml"
    path.write_text(yaml.safe_dump({"name": "kinds", "bench": bench, "experiments": experiments}))
    return path


@pytest.fixture(scope="module")
def campaign(tmp_path_factory, on_the_rig):
    """A campaign with one experiment of each kind."""
    folder = tmp_path_factory.mktemp("kinds")
    return on_the_rig(schedule_file(folder, *KINDS), folder / "campaign")


@pytest.fixture(scope="module")
def results(campaign):
    return workflow.report(campaign.folder)


def test_each_stage_supports_exactly_the_values_that_its_column_may_take():
    hints = get_type_hints(ExperimentKind)
    for column, (stage, supported) in STAGES.items():
        if column != "figure":
            assert set(supported) == set(get_args(hints[column])), stage
        assert {getattr(kind, column) for kind in KINDS.values()} <= set(supported), stage
    assert set(PROFILE_SECTIONS) == set(PROFILES)
    assert set(FIGURE_NAMES) == {figure.name for figure in FIGURES}
    assert all(kind.name == name for name, kind in KINDS.items())


def schema(room, name):
    return json.loads((files(f"hbench.report.{room}") / f"{name}.schema.json").read_text())


def listed_kinds(part):
    """Yield every list of kinds in a schema."""
    if isinstance(part, dict):
        if "steady" in part.get("enum", ()) and "hold" in part["enum"]:
            yield part["enum"]
        part = list(part.values())
    if isinstance(part, list):
        for item in part:
            yield from listed_kinds(item)


@pytest.mark.parametrize("room, name", [("campaign", "results"), ("diagnosis", "diagnosis")])
def test_the_schemas_list_the_kinds_of_the_table(room, name):
    lists = list(listed_kinds(schema(room, name)))
    assert lists and all(sorted(kinds) == sorted(KINDS) for kinds in lists)


@pytest.mark.parametrize("column", STAGES)
def test_check_refuses_a_kind_that_a_stage_does_not_support(column, monkeypatch, tmp_path):
    """Its example is that of steps, and all its other columns too."""
    made_up = replace(KINDS["steps"], name="creep", **{column: "made_up"})
    monkeypatch.setitem(KINDS, "creep", made_up)
    monkeypatch.setitem(EXAMPLES, "creep", EXAMPLES["steps"])
    schedule = schedule_file(tmp_path, "steady", "creep")
    refused = CliRunner().invoke(app, ["run", str(schedule), "--check"]).exception
    assert isinstance(refused, ConfigError)
    message = refused.message
    assert str(schedule) in message
    assert "experiments.1.kind = 'creep'" in message
    if column != "profile":  # without which the file has no keys to read
        assert f"{column} 'made_up'" in message


def test_a_kind_of_supported_values_alone_is_a_row_and_nothing_else(
    monkeypatch, tmp_path, on_the_rig, undrawn
):
    monkeypatch.setitem(KINDS, "creep", replace(KINDS["steps"], name="creep"))
    monkeypatch.setitem(EXAMPLES, "creep", EXAMPLES["steps"])
    campaign = on_the_rig(schedule_file(tmp_path, "creep"), tmp_path / "campaign")
    results = workflow.report(campaign.folder)
    assert {curve.kind for curve in results.curves} == {"creep"}
    assert {level.kind for level in results.motions.levels} == {"creep"}


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_is_planned_and_encoded_for_the_board(kind, tmp_path):
    experiment = workflow.load_experiment(schedule_file(tmp_path, kind), None)
    plans = plan_runs(experiment.schedule, experiment.bench, "schedule.yaml").runs
    assert plans and {plan.kind for plan in plans} == {kind}
    for upload in uploads(plans, BOARD):
        for name, rows in (("write_segment", upload.segments), ("write_step", upload.steps)):
            assert rows
            for index, row in enumerate(rows):
                values, fields = {"index": index, **row}, BY_NAME[name].request
                assert unpack(fields, pack(fields, values)) == pytest.approx(values, rel=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_is_screened_analysed_and_drawn(kind, campaign, results):
    runs = [one for one in results.runs if one.run.plan.kind == kind]
    assert len(runs) >= 2 and all(one.accepted for one in runs), [one.reasons for one in runs]
    motions = results.motions
    products = (*results.curves, *motions.loops, *motions.levels, *motions.leakages)
    products += motions.breakaways
    assert (kind in {product.kind for product in products}) == bool(KINDS[kind].figure)
    drawn = [path.name for path in (campaign.folder / "results" / "figures").glob("*.svg")]
    few = kind == "breakaway" and len(motions.breakaways) <= 2  # a table says as much
    assert few or any(name.startswith(KINDS[kind].figure) for name in drawn)


def test_runs_are_counted_in_words_that_agree_with_their_number():
    one = [kind.counted(1) for kind in KINDS.values()]
    two = [kind.counted(2) for kind in KINDS.values()]
    assert one[:1] + two[:1] == ["1 steady", "2 steady"]
    assert {"1 hold", "1 zero check", "1 steps", "1 ramp"} <= set(one)
    assert {"2 holds", "2 zero checks", "2 steps", "2 ramps", "2 breakaways"} <= set(two)


def test_the_results_of_all_kinds_fit_their_schema(campaign, results):
    document = json.loads((campaign.folder / "results" / "results.json").read_text())
    assert {run["kind"] for run in document["runs"]} == set(KINDS)
    Draft202012Validator(schema("campaign", "results")).validate(document)


def test_exported_runs_of_all_kinds_are_imported_by_their_index(campaign, tmp_path, clock):
    workflow.export(campaign.folder, tmp_path / "csv", "csv")
    workflow.import_runs(tmp_path / "csv", tmp_path / "imported", None, clock)
    imported = load_campaign(tmp_path / "imported")
    assert [plan.kind for plan in imported.plans] == [plan.kind for plan in campaign.plans]
    assert {one.run.plan.kind for one in derive(imported).runs} == set(KINDS)
