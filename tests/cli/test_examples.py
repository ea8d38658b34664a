"""The example in each command's help runs as it stands there."""

import json
import re
import shlex
import shutil
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
import typer.main
from typer.testing import CliRunner

from hbench.cli.main import app
from tests.support.board.stm32_rom_standin import (
    FLASH,
    RomLine,
    Stm32Rom,
    elf,
    program,
    running,
)
from tests.support.cut_campaign import one_load
from tests.support.waiting import killed_in_the_end

ROOT = Path(__file__).parents[2]
COMMANDS = typer.main.get_command(app).commands
SERVERS = {"rig": ("--socket", "localhost:0"), "watch": ("--port", "0")}  # any free port
WITHOUT_JSON = {"rig", "watch"}  # they print an address and go on


def example(name: str) -> list[str]:
    (line,) = re.findall(r"^ *Example: hbench (.+)$", COMMANDS[name].help, re.M)
    command, *arguments = shlex.split(line)
    assert command == name
    return arguments


@pytest.fixture
def world(tmp_path, quick_schedule, monkeypatch, undrawn):
    """An empty folder where what the examples name is there; with a board and no serial port."""
    schedule = quick_schedule()
    (tmp_path / "configs").mkdir()
    shutil.move(schedule, tmp_path / "configs" / "demo.yaml")
    shutil.move(tmp_path / "bench.yaml", tmp_path / "configs" / "bench.yaml")
    shutil.copy(ROOT / "configs" / "import-csv.yaml", tmp_path / "configs")
    rom = Stm32Rom(program=running())
    monkeypatch.setattr(
        "hbench.workflow.board.SerialPort", lambda name, rate, parity: RomLine(rom, rate)
    )
    monkeypatch.setattr("hbench.workflow.board.system_ports", lambda: [])
    monkeypatch.chdir(tmp_path)
    return tmp_path


def campaigns(*names):
    def make(world):
        for name in names:
            one_load(world / name)

    return make


def line(world):
    for name in ("A", "B"):
        shutil.copytree(ROOT / "data_samples" / "bad-runs", world / "line-1" / name)


def limits(world, make=one_load):
    make(world / "demo")
    bench_file(world)
    for name in ("limits.yaml", "certificate.yaml"):
        shutil.copy(ROOT / "configs" / name, world / "my-bench")


def whole(world):
    """A certificate is given to a whole campaign alone."""
    limits(world, partial(shutil.copytree, ROOT / "data_samples" / "stribeck-small"))


def bench_file(world):
    (world / "my-bench").mkdir()
    shutil.copy(ROOT / "configs" / "bench-aau.yaml", world / "my-bench")


def logs(world):
    """One stroke at 50 mm/s after a second of rest without load, as the map says."""
    rows = ["Messung", "Zeit;Weg;p_A;p_B;Kraft", "ms;mm;bar;bar;kN"]
    for i in range(700):
        moving = max(i - 200, 0)
        p_a, p_b, force = (24 + i % 2, 8, 2 + 0.001 * (i % 3)) if moving else (0, 0, 0.012)
        rows.append(f"{5 * i};{10 + 0.25 * moving:.2f};{p_a};{p_b};{force}")
    (world / "logs").mkdir()
    (world / "logs" / "NBR_50mm_s_2000N_1.csv").write_text("\n".join(rows).replace(".", ","))


def image(world):
    (world / "hbench-stm32f4.elf").write_bytes(elf([(FLASH, program(600))]))


def too_few_runs(world):
    """Answered without a search: what is missing."""
    shutil.copytree(ROOT / "data_samples" / "bad-runs", world / "telling")
    bench_file(world)


def nothing(world):
    pass


# What an example needs, and what it leaves.
EXAMPLES = {
    "accept": (limits, ["demo/results/acceptance.json", "demo/results/acceptance.xml"]),
    "analyze": (campaigns("demo"), ["demo/results/results.json"]),
    "certificate": (whole, ["certificate.pdf"]),
    "compare": (campaigns("before", "after"), ["comparison/comparison.html"]),
    "design": (bench_file, []),
    "export": (campaigns("demo"), ["demo-mat/campaign.mat", "demo-mat/curves.mat"]),
    "flash": (image, []),
    "fleet": (line, ["fleet/fleet.html", "fleet/fleet.parquet", "fleet/fleet.json"]),
    "identify": (campaigns("dynamics"), ["laws/identification.html", "laws/identification.json"]),
    "import": (logs, ["campaign/campaign.yaml"]),
    "init": (nothing, ["my-bench/bench-aau.yaml", "my-bench/demo.yaml"]),
    "ports": (nothing, []),
    "reconcile": (too_few_runs, ["diagnosis/diagnosis.json", "diagnosis/report.html"]),
    "report": (campaigns("demo"), ["demo/results/report.html"]),
    "run": (nothing, ["demo/campaign.yaml", "demo/runs/0004.dat"]),
    "simulate": (nothing, ["stick-slip/stick-slip.html"]),
}


def test_every_command_has_an_example_that_is_run_here():
    assert set(EXAMPLES) | set(SERVERS) == set(COMMANDS)


@pytest.mark.parametrize("name", EXAMPLES)
def test_the_example_runs_and_leaves_what_it_should(name, world):
    prepare, left = EXAMPLES[name]
    prepare(world)
    result = CliRunner().invoke(app, [name, *example(name), "--json"])
    if "config/examples" in str(getattr(result.exception, "message", "")):
        pytest.skip("the examples are put in place when hbench is installed")
    assert result.exit_code == 0, (result.output, result.exception)
    assert json.loads(result.stdout)["schema"].startswith("hbench.")
    assert all((world / path).is_file() for path in left)


@pytest.mark.parametrize("name", SERVERS)
def test_the_example_of_a_server_tells_its_address_and_ends_with_ctrl_c(name, world):
    campaigns("demo")(world)
    command = [sys.executable, "-m", "hbench", name]
    arguments, (option, free_port) = example(name), SERVERS[name]
    if option in arguments:
        at = arguments.index(option)
        del arguments[at : at + 2]
    started = subprocess.Popen(
        [*command, *arguments, option, free_port], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True,
    )  # fmt: skip
    with killed_in_the_end(started) as process:
        address = process.stdout.readline().strip()
        if not address and "config/examples" in (told := process.communicate(timeout=60)[1]):
            pytest.skip(f"the examples are put in place when hbench is installed: {told}")
        assert re.fullmatch(r"(socket|http)://(localhost|127\.0\.0\.1):\d+/?", address)
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 0


@pytest.mark.parametrize("name", sorted(COMMANDS))
def test_every_command_prints_one_object_with_json(name):
    options = {option for parameter in COMMANDS[name].params for option in parameter.opts}
    assert ("--json" in options) == (name not in WITHOUT_JSON)
