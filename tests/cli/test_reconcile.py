"""``hbench reconcile`` as a user calls it; the diagnosis is one of runs that were made here."""

import json
import re
from dataclasses import replace

import pytest
import yaml
from typer.main import get_command
from typer.testing import CliRunner

from hbench.cli.main import app
from hbench.errors import ConfigError
from hbench.reconcile.separation.missing_data import MISSING
from hbench.reconcile.strokes.stroke_diagnosis import FEWEST_LOADS
from hbench.records.reconcile.diagnosis import MATERIAL
from hbench.report.diagnosis.names import keys_in_words
from hbench.report.render.terminal_text import plain
from tests.support import ROOT
from tests.support.reconcile import made_diagnosis as made
from tests.support.reconcile.thinned import thinned

MODEL = ROOT / "configs" / "model-aau.yaml"
LEAKING = ROOT / "data_samples" / "blind" / "internal_leakage-clear-1"
SAMPLE = ROOT / "data_samples" / "stribeck-small"

pytestmark = pytest.mark.usefixtures("undrawn")


def run(*arguments):
    return CliRunner().invoke(app, ["reconcile", *map(str, arguments)])


@pytest.fixture
def finds(monkeypatch):
    """Return a function that sets what the search will find."""

    def set_(found):
        monkeypatch.setattr("hbench.workflow.campaign_diagnosis.diagnosed", lambda *given: found)

    return set_


@pytest.fixture
def tasks(monkeypatch):
    """The tasks that the command has diagnosed."""
    found = []

    def diagnose(task):
        found.append(task)
        return made.named()

    monkeypatch.setattr("hbench.workflow.campaign_diagnosis.diagnose", diagnose)
    return found


def test_the_verdict_is_on_stdout_and_the_page_in_the_folder(finds, tmp_path):
    finds(made.named())
    result = run(SAMPLE, "--model", MODEL, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert result.stdout.startswith("Internal leakage found: ")
    assert (tmp_path / "out" / "report.html").is_file()
    log = (tmp_path / "out" / "reconcile.log").read_text().splitlines()
    assert log[0].endswith(f"reading {SAMPLE}") and log[-1].endswith("  finished")


def test_values_of_zero_in_the_model_file_are_refitted_from_small_ones(tasks, tmp_path):
    """No viscous friction and no dead volumes are what a user writes who does not know them."""
    model = tmp_path / "model.yaml"
    text = MODEL.read_text().replace("tank: 2 bar", "tank: 0 bar")
    model.write_text(re.sub(r"viscous: 2500 N s/m", "viscous: 0 N s/m", text))
    result = run(SAMPLE, "--model", model, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    (task,) = tasks
    assert task.plant.supply.tank == pytest.approx(0.125e5)
    assert task.plant_data["supply"]["tank"] == "0.125 bar"
    assert task.plant.friction.test.viscous == pytest.approx(112.5)
    assert task.plant.friction.load.viscous == pytest.approx(3000.0)
    words = " ".join(result.stdout.split())
    assert (
        "The model file has 0, or no value, for supply.tank and friction.test.viscous. A refit "
        "multiplies values, so it started from 0.125 bar and 112.5 N s/m."
    ) in words


def test_values_that_the_flows_contradict_are_replaced_by_the_measured_ones(tasks, tmp_path):
    """Oil alone is twenty times as stiff as this bench with its hoses; no refit gets so far."""
    model = tmp_path / "model.yaml"
    text = MODEL.read_text().replace("bulk_modulus: 700 bar", "bulk_modulus: 1.4 GPa")
    model.write_text(text.replace("gain: 7.43e-7", "gain: 1.5e-6"))
    result = run(SAMPLE, "--model", model, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    (task,) = tasks
    assert task.plant.oil.bulk_modulus == pytest.approx(700e5, rel=0.2)
    assert task.plant.valve.gain == pytest.approx(7.43e-7, rel=0.05)
    oil, valve = task.plant_data["oil"], task.plant_data["valve"]
    assert oil["density"] == "870 kg/m^3"
    words = " ".join(result.stdout.split())
    for path, value, given in (
        ("oil.bulk_modulus", oil["bulk_modulus"], "14000 bar"),
        ("valve.gain", valve["gain"], "1.5e-06 m^2/V"),
    ):
        assert f"The measured flows show {path} = {value}; the model file has {given}." in words
    assert words.count("Wrong dead volumes look the same") == 1
    assert words.count("A wrong scale of the commands in the import map looks the same") == 1


def test_edges_of_two_sizes_that_the_flows_contradict_are_replaced_by_the_measured_ones(
    tasks, tmp_path
):
    model = tmp_path / "model.yaml"
    model.write_text(
        f"{MODEL.read_text()}\neffects: {{valve_trim: {{ports: 25 %, leak: 0.01 V}}}}\n"
    )
    result = run(SAMPLE, "--model", model, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    (task,) = tasks
    trim = task.plant_data["effects"]["valve_trim"]
    assert trim["leak"] == "0.01 V"
    assert float(trim["ports"].removesuffix(" %")) == pytest.approx(0.0, abs=4.0)
    assert (
        f"The measured flows show effects.valve_trim.ports = {trim['ports']}; the model file has "
        "25 %."
    ) in " ".join(result.stdout.split())


def test_a_value_in_the_model_file_that_no_bench_has_is_noted(monkeypatch, tmp_path):
    monkeypatch.setattr("hbench.workflow.campaign_diagnosis.diagnose", lambda task: made.named())
    model = tmp_path / "model.yaml"
    model.write_text(MODEL.read_text().replace("stiction: 450 N", "stiction: 45 N"))
    result = run(SAMPLE, "--model", model, "-o", tmp_path / "out")
    assert (
        "Implausible in the model file: friction.test.stiction = 45 N; static friction is at least "
        "coulomb = 80 N."
    ) in " ".join(result.stdout.split())


def test_deviations_that_do_not_matter_are_those_of_the_library():
    (option,) = (p for p in get_command(app).commands["reconcile"].params if p.name == "material")
    assert option.default == pytest.approx(100 * MATERIAL)


def test_json_on_stdout_is_the_file(finds, tmp_path):
    finds(made.named())
    result = run(SAMPLE, "--model", MODEL, "-o", tmp_path / "out", "--json")
    written = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert json.loads(result.stdout) == written


@pytest.mark.parametrize("verdict", ["named", "none"])
def test_with_fail_only_a_model_without_a_gap_exits_with_0(finds, tmp_path, verdict):
    finds(replace(made.named(), verdict=verdict))
    result = run(SAMPLE, "--model", MODEL, "-o", tmp_path / "out", "--fail")
    assert result.exit_code == (0 if verdict == "none" else 6)


def test_too_few_runs_get_what_is_missing_instead_of_a_guess(tmp_path):
    """Steady runs alone, with faults of every kind."""
    result = run(SAMPLE.with_name("bad-runs"), "--model", MODEL, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "verdict: unknown)" in result.stdout.splitlines()[0]
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert found["effects"] == [] and found["not_tried"]
    assert MISSING["hold"] in found["missing"]
    shown = " ".join(result.stdout.split())
    for words in (*found["missing"], *found["not_tried"].values(), *found["not_tried"]):
        assert plain(keys_in_words(words)) in shown


def speed_of_60_mm_s(plan):
    return plan.kind == "steady" and abs(plan.v_ref_m_s) == 0.06


LACKING = {
    "one speed": (speed_of_60_mm_s, (), [MISSING["speeds"]]),
    "one load": (lambda plan: plan.f_load_n == 5000, (), [MISSING["loads"]]),
    "few points": (
        lambda plan: plan.kind == "triangle", (), ["at least 8 operating points"]
    ),
    "one chamber": (
        lambda plan: True,
        ("p_tr", "p_lp", "p_lr"),
        [MISSING["chambers"], "p_tr, p_lp, p_lr"],
    ),
    "no pressure, no load cell": (
        lambda plan: True,
        ("p_tp", "p_tr", "p_lp", "p_lr", "f_applied"),
        [MISSING["chambers"], "f_applied"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("lacking", LACKING)
def test_too_little_is_told_in_text_json_and_page_and_nothing_is_named(lacking, tmp_path):
    """Of a campaign with a leak that is named from all of it."""
    keep, without, words = LACKING[lacking]
    campaign = thinned(LEAKING, tmp_path / "campaign", keep, without)
    result = run(campaign, "--model", MODEL, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "verdict: unknown)" in result.stdout.splitlines()[0]
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert (found["verdict"], found["effects"], found["alternatives"]) == ("unknown", [], [])
    page = (tmp_path / "out" / "report.html").read_text()
    page = re.sub("<sub>(.*?)</sub>", r"_\1", page).replace("&#39;", "'")
    for word in words:
        assert plain(keys_in_words(word)) in " ".join(result.stdout.split())
        assert any(word in line for line in found["missing"])
        shown = word.replace("f_applied", "load cell's force")
        assert shown.lower() in page.lower()  # a symbol, or the beginning of a sentence
    assert found["missing"][0] in found["why"]


def test_a_model_with_an_effect_that_is_not_in_the_catalogue_is_refused(tmp_path):
    model = tmp_path / "model.yaml"
    model.write_text(yaml.safe_dump({"effects": {"gremlins": {"many": "1 N"}}}))
    error = run(SAMPLE, "--model", model, "-o", tmp_path / "out").exception
    assert isinstance(error, ConfigError)
    assert "model.yaml: effects.gremlins" in error.message


def test_foreign_runs_without_what_friction_needs_name_nothing(tmp_path):
    logs = tmp_path / "logs"
    logs.mkdir()
    (logs / "runs.csv").write_text("run,file,kind,trial,v_ref_m_s\n1,1.csv,steady,1,0.1\n")
    (logs / "1.csv").write_text("t_s,x_m\n0,0\n0.1,0.01\n0.2,0.02\n")
    imported = CliRunner().invoke(app, ["import", str(logs), "-o", str(tmp_path / "campaign")])
    assert imported.exit_code == 0, imported.output
    result = run(tmp_path / "campaign", "--model", MODEL, "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "verdict: unknown)" in result.stdout.splitlines()[0]
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    force, loads = found["missing"][:2]
    assert force.startswith("the applied force")
    assert loads.startswith(f"at least {FEWEST_LOADS} loads")
    assert all("missing_channel" in text for text in found["left_out"])


def test_a_series_is_of_imported_campaigns_alone(tmp_path):
    found = run(SAMPLE, "--model", MODEL, "-o", tmp_path / "out", "--series", "NAPN").exception
    assert isinstance(found, ConfigError)
