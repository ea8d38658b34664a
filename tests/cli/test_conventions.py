"""What holds for all commands: exit codes as the README tells them, completion, ``python -m``."""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main

from hbench import __version__, errors, workflow
from hbench.cli.main import app, main
from hbench.errors import ExitCode

README = Path(__file__).parents[2] / "README.md"
NAMED = "import sys; sys.argv[0] = 'hbench'; from hbench.cli.main import main; main()"


def test_the_readme_tells_every_exit_code():
    told = re.findall(r"^\| (\d+) \| [a-z]", README.read_text(), re.M)
    assert [int(code) for code in told] == [*ExitCode, 130]


def lines_of_the_readme():
    blocks = re.findall(r"^```sh\n(.*?)^```", README.read_text(), re.M | re.S)
    lines = [line for block in blocks for line in block.splitlines()]
    return [line for line in lines if line.startswith("hbench ")]


@pytest.mark.parametrize("line", lines_of_the_readme())
def test_each_line_of_the_readme_is_one_that_the_command_takes(line):
    """Its arguments are read as the command reads them; nothing is run."""
    name, *arguments = shlex.split(line, comments=True)[1:]
    command = typer.main.get_command(app).commands[name]
    command.make_context(name, arguments)


def test_the_readme_names_no_file_that_is_not_there():
    named = re.findall(r"\]\(([^)#:]+)\)", README.read_text())
    assert len(named) > 10
    assert [one for one in named if not (README.parent / one).exists()] == []


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (errors.ConfigError, 2),
        (errors.DeviceError, 3),
        (errors.DataError, 4),
        (errors.ConvergenceError, 5),
    ],
)
def test_each_kind_of_error_has_its_exit_code_words_and_hint(error, code, monkeypatch, capsys):
    def fail(*_):
        raise error("it is so", "Do this.")

    monkeypatch.setattr(workflow, "analyze", fail)
    monkeypatch.setattr("sys.argv", ["hbench", "analyze", "demo"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == code
    assert capsys.readouterr() == ("", "error: it is so\nhint: Do this.\n")


def test_a_bug_is_exit_code_1_with_a_traceback_and_ctrl_c_130():
    for error, code, words in (("KeyError(3)", 1, "KeyError: 3"), ("KeyboardInterrupt", 130, "")):
        spoilt = (
            f"from hbench import workflow\ndef fail(*_): raise {error}\nworkflow.analyze = fail"
        )
        done = subprocess.run(
            [sys.executable, "-c", f"{spoilt}\n{NAMED}", "analyze", "demo"],
            capture_output=True,
            text=True,
        )
        assert done.returncode == code and words in done.stderr and not done.stdout
        assert ("Traceback" in done.stderr) == (code == 1)


@pytest.mark.parametrize(
    ("typed", "offered"),
    [("hbench an", {"analyze"}), ("hbench export demo --fo", {"--format"})],
)
def test_a_shell_completes_commands_and_options(typed, offered):
    asked = {
        "_HBENCH_COMPLETE": "complete_bash",
        "COMP_WORDS": typed,
        "COMP_CWORD": str(len(typed.split()) - 1),
    }
    done = subprocess.run(
        [sys.executable, "-c", NAMED], env=os.environ | asked, capture_output=True, text=True
    )
    assert set(done.stdout.split()) == offered


def test_the_shells_script_is_given():
    asked = {"_HBENCH_COMPLETE": "source_bash"}
    done = subprocess.run(
        [sys.executable, "-c", NAMED], env=os.environ | asked, capture_output=True, text=True
    )
    assert "complete -o default -F _hbench_completion hbench" in done.stdout


def test_python_m_hbench_is_hbench():
    command = [sys.executable, "-m", "hbench", "--version"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"{__version__}\n")
