"""``hbench run --specimen``: the serial number names campaign and folder."""

import pytest
from typer.testing import CliRunner

from hbench.cli.main import app
from hbench.errors import ConfigError
from hbench.store.campaign.folder import load_campaign


@pytest.fixture
def run(quick_schedule, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    schedule = quick_schedule(velocities=["100 mm/s"], trials=1)

    def call(*arguments, typed=None):
        return CliRunner().invoke(app, ["run", str(schedule), *arguments], input=typed)

    return call


@pytest.mark.parametrize(("option", "typed"), [("SN 12/7", None), ("?", "SN 12/7\n")])
def test_the_folder_is_named_after_the_cylinder_and_its_serial_is_in_the_campaign(
    run, tmp_path, option, typed
):
    done = run("--specimen", option, typed=typed)
    assert done.exit_code == 0, done.output
    (folder,) = tmp_path.glob("SN_12_7_????-??-??_??????")
    assert load_campaign(folder).provenance().settings["specimen"]["serial"] == "SN 12/7"


def test_an_output_folder_wins_and_no_serial_is_no_name(run, tmp_path):
    assert run("--specimen", "A1", "-o", "mine").exit_code == 0
    assert load_campaign(tmp_path / "mine").provenance().settings["specimen"] == {"serial": "A1"}
    for arguments in (["--specimen", " "], ["--specimen", ".."], []):
        assert run(*arguments).exit_code == 2
    assert isinstance(run("--specimen", "A\x1b[2J").exception, ConfigError)
    assert not list(tmp_path.glob("_*"))
