"""``hbench run --specimen``: the serial number names campaign and folder."""

from types import SimpleNamespace

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


@pytest.mark.parametrize("serial", ["-A1", "../.A1"])
def test_a_folder_named_after_a_cylinder_is_neither_hidden_nor_an_option(run, tmp_path, serial):
    assert run("--specimen", serial).exit_code == 0
    (folder,) = [path for path in tmp_path.iterdir() if path.is_dir()]
    assert folder.name[0] not in "-."
    assert load_campaign(folder).provenance().settings["specimen"]["serial"] == serial


def test_an_output_folder_wins_and_no_serial_is_no_name(run, tmp_path):
    assert run("--specimen", "A1", "-o", "mine").exit_code == 0
    assert load_campaign(tmp_path / "mine").provenance().settings["specimen"] == {"serial": "A1"}
    for arguments in (["--specimen", " "], ["--specimen", ".."], []):
        assert run(*arguments).exit_code == 2
    assert isinstance(run("--specimen", "A\x1b[2J").exception, ConfigError)
    assert not list(tmp_path.glob("_*"))


def test_the_answer_is_the_first_line_with_text(run, tmp_path):
    done = run("--specimen", "?", "-o", "mine", typed="\n \r\nA1\r\n")
    assert done.exit_code == 0, done.output
    assert load_campaign(tmp_path / "mine").provenance().settings["specimen"] == {"serial": "A1"}


@pytest.mark.parametrize("closed", [False, True])
def test_without_an_answer_it_is_a_usage_error(run, monkeypatch, closed):
    if closed:
        monkeypatch.setattr("hbench.cli.commands.run.sys", SimpleNamespace(stdin=None))
    done = run("--specimen", "?", "--check", typed="\n")
    assert done.exit_code == 2
    assert "got no answer: standard input has ended" in done.stderr and not done.stdout


def test_a_refused_resume_names_the_key_that_differs_and_the_option_that_was_left_out(run):
    assert run("--specimen", "A1", "-o", "mine").exit_code == 0
    for arguments, now in (([], "nothing"), (["--specimen", "B2"], "'B2'")):
        error = run(*arguments, "-o", "mine", "--resume").exception
        assert isinstance(error, ConfigError)
        assert f"specimen.serial: 'A1' in the campaign, {now} now" in error.message
        assert "--specimen" in error.hint
    assert run("--specimen", "A1", "-o", "mine", "--resume").exit_code == 0
