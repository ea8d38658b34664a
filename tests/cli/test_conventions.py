"""What holds for all commands: exit codes as the README tells them, completion, ``python -m``."""

import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main

from hbench import __version__, errors, workflow
from hbench.cli.main import app, main
from hbench.errors import ExitCode

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
PAGES = [README, *ROOT.glob("configs/README.md"), *ROOT.glob("firmware/**/README.md")]
PAGES += sorted(ROOT.glob("hbench/*/README.md"))
NAMED = "import sys; sys.argv[0] = 'hbench'; from hbench.cli.main import main; main()"


def test_the_readme_tells_every_exit_code():
    told = re.findall(r"^\| (\d+) \| [a-z]", README.read_text(), re.M)
    assert [int(code) for code in told] == [*ExitCode, 130]


def lines_of_the_pages():
    blocks = [
        block
        for page in PAGES
        for block in re.findall(r"^```sh\n(.*?)^```", page.read_text(), re.M | re.S)
    ]
    lines = [line for block in blocks for line in block.splitlines()]
    return [line for line in lines if line.startswith("hbench ")]


@pytest.mark.parametrize("line", lines_of_the_pages())
def test_each_line_of_a_page_is_one_that_the_command_takes(line):
    """Its arguments are read as the command reads them; nothing is run."""
    name, *arguments = shlex.split(line.partition(" > ")[0], comments=True)[1:]
    command = typer.main.get_command(app).commands[name]
    command.make_context(name, arguments)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_links_to_files_that_are_there_and_to_headings_that_are_in_them(page):
    linked = re.findall(r"\]\(([^)#:]*)(?:#([^)]+))?\)", page.read_text())
    for file, heading in linked:
        there = page.parent / file if file else page
        assert there.exists(), file
        titles = re.findall(r"^#+ (.*)$", there.read_text(), re.M) if heading else []
        assert not heading or heading in [
            re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-") for title in titles
        ]


def test_all_pages_can_be_reached_from_the_readme():
    named = re.findall(r"\]\(([^)#:]+)", README.read_text())
    reached = {(ROOT / one / "README.md" if (ROOT / one).is_dir() else ROOT / one) for one in named}
    assert len(PAGES) > 7
    assert set(PAGES) - reached - {README} == set()


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
    def fail(*_, **_options):
        raise error("wrong", "Right.")

    monkeypatch.setattr(workflow, "analyze", fail)
    monkeypatch.setattr("sys.argv", ["hbench", "analyze", "demo"])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == code
    assert capsys.readouterr() == ("", "error: wrong\nhint: Right.\n")


def test_a_bug_is_exit_code_1_with_a_traceback_and_ctrl_c_130():
    for error, code, words in (("KeyError(3)", 1, "KeyError: 3"), ("KeyboardInterrupt", 130, "")):
        fail = f"def fail(*_, **_more): raise {error}"
        spoilt = f"from hbench import workflow\n{fail}\nworkflow.analyze = fail"
        done = subprocess.run(
            [sys.executable, "-c", f"{spoilt}\n{NAMED}", "analyze", "demo"],
            capture_output=True,
            text=True,
        )
        assert done.returncode == code and words in done.stderr and not done.stdout
        assert ("Traceback" in done.stderr) == (code == 1)


@pytest.mark.skipif(sys.platform != "linux", reason="limits of memory are observed on Linux only")
@pytest.mark.parametrize("options", [["--map", "map.yaml", "-o", "out"], ["--suggest"]])
def test_a_log_that_needs_more_memory_than_there_is_is_no_bug(tmp_path, options):
    (tmp_path / "logs").mkdir()
    with open(tmp_path / "logs/a.csv", "wb") as log:
        log.truncate(150_000_000)
    (tmp_path / "map.yaml").write_text(
        "name: a\ncolumns: {t_s: {column: t_s}, x_m: {column: x_m}, f_drive_n: {column: f_drive_n}}"
        "\nseries: [{label: a, files: a.csv}]\n"
    )
    limited = (
        "import resource; from pathlib import Path; import hbench.workflow.imports\n"
        "pages = int(Path('/proc/self/statm').read_text().split()[0])\n"
        "size = pages * resource.getpagesize() + 100_000_000\n"
        "resource.setrlimit(resource.RLIMIT_AS, (size, size))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", f"{limited}\n{NAMED}", "import", "logs", *options],
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert done.returncode == 4 and not done.stdout
    assert "not enough memory\nhint: Free memory" in done.stderr


@pytest.mark.parametrize(
    ("command", "given", "named"),
    [
        ("import", "logs --map a.yaml -o out --map b.yaml", "--map"),
        ("export", "demo -o a --output b", "-o / --output"),
        ("report", "demo --speed=1 --speed=1", "--speed"),
        ("compare", "a b --same-instruments --other-instruments", "--other-instruments"),
    ],
)
def test_a_repeated_option_is_refused(command, given, named, monkeypatch, capsys):
    """Its last value would replace the others, although the user may expect all to count."""
    monkeypatch.setattr("sys.argv", ["hbench", command, *given.split()])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == ExitCode.USAGE
    assert f"{named}' is given more than once" in capsys.readouterr().err


def test_a_repeated_flag_and_several_arguments_are_no_repeated_option():
    context = typer.main.get_command(app).commands["fleet"].make_context
    given = context("fleet", ["a", "b", "-o", "c", "--json", "--json"]).params
    assert given["patterns"] == ["a", "b"] and given["as_json"]


@pytest.mark.parametrize(
    "arguments", [["analyze", "PATH"], ["init", "PATH"], ["compare", "PATH", "PATH"]]
)
def test_a_path_that_the_system_refuses_is_an_error_with_its_name(arguments, monkeypatch, capsys):
    path = "x" * 5000
    monkeypatch.setattr("sys.argv", ["hbench", *(path if a == "PATH" else a for a in arguments)])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == ExitCode.DATA
    out, words = capsys.readouterr()
    assert not out
    error, hint = words.splitlines()
    assert re.fullmatch(r"error: x+\.\.\.: File name too long", error) and len(error) < 200
    assert hint == "hint: Choose a shorter name."


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root reads every folder")
def test_a_folder_of_another_user_is_an_error_with_its_name(tmp_path, monkeypatch, capsys):
    (tmp_path / "closed").mkdir(mode=0)
    monkeypatch.setattr("sys.argv", ["hbench", "analyze", str(tmp_path / "closed" / "demo")])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == ExitCode.DATA
    assert "closed" in capsys.readouterr().err


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
    assert re.search(r"^complete .* _hbench_completion hbench$", done.stdout, re.MULTILINE)


def test_python_m_hbench_is_hbench():
    command = [sys.executable, "-m", "hbench", "--version"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, f"{__version__}\n")


@pytest.mark.parametrize("where", ["typer", "hbench.cli.main", "hbench.parallel.one_thread"])
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_while_the_command_line_is_loaded_ends_without_a_traceback(where, number):
    """The interrupt arrives while a module is imported; another one while Python shuts down."""
    code = f"""
import atexit, os, runpy, signal, sys
class Interrupting:
    def find_spec(self, name, path=None, target=None):
        if name == {where!r}:
            os.kill(os.getpid(), {int(number)})
sys.meta_path.insert(0, Interrupting())
sys.argv = ["hbench", "analyze", "demo"]
AGAIN
runpy.run_module("hbench", run_name="__main__")
"""
    again = f"atexit.register(lambda: os.kill(os.getpid(), {int(number)}))"
    for second, codes in (("", 130), (again, -number)):
        done = subprocess.run(
            [sys.executable, "-c", code.replace("AGAIN", second)], capture_output=True, text=True
        )
        assert (done.returncode, done.stdout, done.stderr) == (codes, "", "")


def test_a_second_ctrl_c_after_a_command_ends_the_process_at_once():
    code = """
import atexit, os, runpy, signal, sys
from hbench import workflow
def interrupted(*_, **_options): raise KeyboardInterrupt
workflow.analyze = interrupted
sys.argv = ["hbench", "analyze", "demo"]
atexit.register(lambda: os.kill(os.getpid(), signal.SIGINT))
runpy.run_module("hbench", run_name="__main__")
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == -signal.SIGINT and "Traceback" not in done.stderr
