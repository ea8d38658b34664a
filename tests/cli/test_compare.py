"""``hbench compare`` on the sample campaigns."""

import json
import re
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hbench.cli.main import app
from hbench.errors import ConfigError, DataError

SAMPLE = Path(__file__).parents[2] / "data_samples" / "stribeck-small"

pytestmark = pytest.mark.usefixtures("undrawn", "fitted_once")


def run(*arguments):
    return CliRunner().invoke(app, ["compare", *map(str, arguments)])


def test_a_campaign_does_not_differ_from_its_copy(tmp_path):
    copy = tmp_path / "copy"
    shutil.copytree(SAMPLE, copy)
    result = run(SAMPLE, copy, "--json", "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    found = json.loads(result.stdout)
    assert found["same_instruments"] is True and len(found["curves"]) == 4
    for curve in found["curves"]:
        assert curve["friction_n"]["difference"] == 0.0
        assert curve["friction_n"]["real"] is False and curve["friction_n"]["ci95"] > 0
    assert "raw logs of A are also those of B: the same measurement" in found["notes"][0]
    assert (tmp_path / "out" / "comparison.html").exists()
    assert json.loads((tmp_path / "out" / "comparison.json").read_text()) == found


def test_a_campaign_is_not_compared_with_itself(tmp_path):
    (tmp_path / "link").symlink_to(SAMPLE)
    for other in (SAMPLE, SAMPLE / ".." / SAMPLE.name, tmp_path / "link"):
        error = run(SAMPLE, other).exception
        assert isinstance(error, ConfigError) and "are the same campaign" in error.message


def test_campaigns_without_a_common_curve_are_refused_with_what_each_has(tmp_path):
    other = tmp_path / "other"
    shutil.copytree(SAMPLE, other)
    journal = other / "campaign.yaml"
    text = journal.read_text()
    changed = re.sub(r"f_load_n: (-?)(\d+)", r"f_load_n: \g<1>1\2", text)
    assert changed != text
    journal.write_text(changed)
    error = run(SAMPLE, other).exception
    assert isinstance(error, DataError)
    assert str(SAMPLE) in error.message and str(other) in error.message
    assert "50001 N" in error.message or "5000 N" in error.message


def test_campaigns_in_folders_of_one_name_are_named_by_their_paths(tmp_path):
    for cylinder in ("cylinder-1", "cylinder-2"):
        shutil.copytree(SAMPLE, tmp_path / cylinder / "imported")
    result = run(tmp_path / "cylinder-1" / "imported", tmp_path / "cylinder-2" / "imported")
    text = " ".join(result.stdout.split())
    assert "A: cylinder-1/imported" in text and "B: cylinder-2/imported" in text
