"""``hbench simulate``: the list, one phenomenon on disk, an unknown name; a campaign replayed."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
import yaml

from hbench.store.campaign.folder import load_campaign
from hbench.studies.catalogue import PHENOMENA
from hbench.workflow import write_diagnosis
from tests.support import commands
from tests.support.reconcile import made_diagnosis as made
from tests.support.reconcile import rounds

BENCH = Path(__file__).parents[2] / "configs" / "bench-aau.yaml"


def hbench(*arguments, command=("simulate",)):
    return commands.hbench(*command, *arguments)


def test_without_a_name_it_lists_what_there_is():
    done = hbench()
    assert done.returncode == 0 and done.stdout.split() == list(PHENOMENA)


def test_a_phenomenon_is_written_with_page_figures_and_data(tmp_path):
    done = hbench("--phenomenon", "lag", "--bench", BENCH, "-o", tmp_path / "out")
    assert done.returncode == 0 and done.stderr.strip().endswith("lag.html")
    names = {path.name for path in (tmp_path / "out").rglob("*.*")}
    parts = {f"lag-{panel}.{kind}" for panel in ("loops", "width") for kind in ("svg", "csv")}
    assert names == {"lag.html", *parts}
    assert "Tustin" in done.stdout and "2 Hz" in done.stdout


def test_an_unknown_name_is_a_usage_error_that_names_the_known():
    done = hbench("--phenomenon", "magic")
    assert done.returncode == 2
    assert "'magic'" in done.stderr and "stick-slip" in done.stderr


@pytest.fixture(scope="module")
def leaking(tmp_path_factory):
    """A campaign of a bench with a leak, and what reconcile writes of the same."""
    folder = tmp_path_factory.mktemp("leaking")
    schedule, plant = folder / "schedule.yaml", folder / "plant.yaml"
    content = rounds.schedule(trials=1, speeds=("60 mm/s",)) | {"bench": str(BENCH)}
    schedule.write_text(yaml.safe_dump(content))
    plant.write_text(yaml.safe_dump({"effects": made.LEAK}))
    done = hbench("-o", folder / "campaign", "--plant", plant, command=("run", schedule))
    assert done.returncode == 0, done.stderr
    write_diagnosis(folder / "diagnosis", replace(made.named(), overlays=(), where=()))
    return folder


def test_reconciles_model_follows_the_measured_commands_better_than_todays(leaking, tmp_path):
    off = {}
    for name, model in (("today", BENCH), ("revised", leaking / "diagnosis" / "model.yaml")):
        asked = (leaking / "campaign", "--model", model, "-o", tmp_path / name)
        done = hbench(*asked, "--json")
        assert done.returncode == 0, done.stderr
        found = json.loads(done.stdout)
        assert found["simulated"] is True and not found["left_out"]
        assert json.loads((tmp_path / name / "replay.json").read_text()) == found
        off[name] = {one["signal"]: one["off"] for one in found["off"]}
    assert off["today"]["p_tp"] > 3 * off["revised"]["p_tp"]
    assert off["today"]["x"] > 3 * off["revised"]["x"]


def test_a_replay_comes_back_as_a_campaign_that_says_it_is_simulated(leaking, tmp_path):
    model = leaking / "diagnosis" / "model.yaml"
    done = hbench(leaking / "campaign", "--model", model, "-o", tmp_path / "replay")
    assert done.stdout.startswith("SIMULATED: ")
    done = hbench(tmp_path / "replay", "-o", tmp_path / "again", command=("import",))
    assert done.returncode == 0, done.stderr
    assert done.stderr.endswith(f" hbench report {tmp_path / 'again'}\n")
    again = load_campaign(tmp_path / "again")
    assert len(again.plans) == len(load_campaign(leaking / "campaign").plans)
    assert all(re.search("SIMULATED.*model.yaml", plan.label) for plan in again.plans)
    assert (
        again.provenance().bench.endswith("model.yaml") and "SIMULATED" in again.provenance().bench
    )


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["campaign"], "--model"),
        (["--model", "model.yaml"], "CAMPAIGN"),
        (["campaign", "--model", "model.yaml", "--phenomenon", "lag"], "--phenomenon"),
    ],
)
def test_a_replay_needs_a_campaign_and_a_model_and_no_phenomenon(arguments, words):
    done = hbench(*arguments)
    assert done.returncode == 2 and words in done.stderr


@pytest.mark.slow
def test_reconcile_then_simulate_as_a_user_calls_them(tmp_path):
    sample = BENCH.parents[1] / "data_samples" / "blind" / "internal_leakage-clear-1"
    today = BENCH.with_name("model-aau.yaml")
    asked = (sample, "--model", today, "-o", tmp_path / "diagnosis")
    assert hbench(*asked, command=("reconcile",)).returncode == 0
    off = []
    for model in (today, tmp_path / "diagnosis" / "model.yaml"):
        found = json.loads(hbench(sample, "--model", model, "--json").stdout)
        off.append({one["signal"]: one["off"] for one in found["off"]})
    print(off)
    assert all(off[0][name] > 2 * off[1][name] for name in off[0])
