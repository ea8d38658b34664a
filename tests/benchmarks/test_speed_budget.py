"""How long each command lets its user wait, beside what else would do the same.

``pytest -s -m slow tests/benchmarks/test_speed_budget.py`` prints the table; without ``-m slow`` it
is that of the small campaign alone. A command is a fresh process; its compiled code and bytecode
are on disk, as after its first use. Wall time, the median of some rounds in which both sides take
turns: a shared machine changes its speed from second to second. A result that is clearly below its
limit needs fewer rounds.
"""

import json
import math
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import pytest

from tests.support import ROOT

CONFIGS = Path(__file__).parents[2] / "configs"
PLAIN = ROOT / "tests" / "support" / "analysis"
HBENCH = [sys.executable, "-P", "-m", "hbench"]  # the installed one
# Else each start would compile the source of hbench.
AS_INSTALLED = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
REPORT_S = 4.0  # for 360 runs
CLEAR = 0.75  # share of a limit below which no further rounds follow


@dataclass(frozen=True)
class Row:
    """What is measured; a ratio at or above ``most`` fails."""

    task: str
    ours: list[str | Path]
    beside: str
    other: list[str | Path] | float  # a command, or how long the bench itself takes [s]
    most: float
    rounds: int = 1  # at most


def python(*arguments) -> list[str | Path]:
    return [sys.executable, *arguments]


def call(command) -> str:
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, env=AS_INSTALLED)
    assert done.returncode == 0, done.stderr
    return done.stdout


def start_up() -> Iterator[Row]:
    ours = [*HBENCH, "--help"]
    yield Row("start-up: --help", ours, "python -c pass", python("-c", "pass"), 20.0, 4)
    yield Row("start-up: --help", ours, "import pandas", python("-c", "import pandas"), 0.5, 4)
    yield Row("start-up: run --help", [*HBENCH, "run", "--help"], "hbench --help", ours, 1.3, 12)


def campaign(schedule: str, folder: Path) -> Iterator[Row]:
    """From the runs to the report. The first call compiles and leaves what the others read."""
    file, made = CONFIGS / f"{schedule}.yaml", folder / schedule
    told = json.loads(call([*HBENCH, "run", file, "-o", made, "--json"]))
    runs, bench_s = told["runs"], told["seconds"]
    again = [*HBENCH, "run", file, "-o", folder / f"{schedule}-again"]
    yield Row(f"run, {runs} runs", again, "the bench itself", bench_s, 0.03)
    analyze = [*HBENCH, "analyze", made]
    plain = python(PLAIN / "plain_analysis.py", made)
    yield Row(f"analyze, {runs} runs", analyze, "pandas and lmfit, plainly", plain, 0.6, 3)
    report = [*HBENCH, "report", made]
    call(report)
    plain = python(PLAIN / "plain_figures.py", made, folder)
    yield Row(f"report, {runs} runs", report, "as many figures, plainly", plain, 2.0, 3)


def reconciled(schedule: str, folder: Path) -> Iterator[Row]:
    made, model = folder / schedule, CONFIGS / "model-aau.yaml"
    told = json.loads(call([*HBENCH, "run", CONFIGS / f"{schedule}.yaml", "-o", made, "--json"]))
    ours = [*HBENCH, "reconcile", made, "--model", model, "-o", folder / "diagnosis"]
    task = f"reconcile, {told['runs']} runs"
    yield Row(task, ours, "the bench itself", told["seconds"], 0.15)


def fleet(schedule: str, folder: Path, campaigns: int) -> Iterator[Row]:
    """Many copies of a campaign; without ``hbench fleet`` one would analyze them in a loop."""
    line = [folder / "line" / str(number) for number in range(campaigns)]
    for copy in line:
        shutil.copytree(folder / schedule, copy)
    ours = [*HBENCH, "fleet", folder / "line", "-o", folder / "fleet"]
    loop = 'for campaign in "$@"; do "$0" -P -m hbench analyze "$campaign" > /dev/null; done'
    other = ["sh", "-c", loop, sys.executable, *line]
    yield Row(f"fleet, {campaigns} campaigns", ours, "analyze, in a loop", other, 0.5)


def measured(rows: Iterator[Row]) -> dict[str, float]:
    """Print the table as it comes; return the seconds of each task. A slow one fails at the end."""
    print(f"\n{'task':24}{'hbench':>8}   {'beside':28}{'':>8}{'ratio':>8}{'limit':>7}")
    seconds, slow = {}, []
    for row in rows:
        rounds, ratio = [], math.inf
        while len(rounds) < row.rounds and ratio >= CLEAR * row.most:
            other = row.other if isinstance(row.other, float) else timed(row.other)
            rounds.append((timed(row.ours), other))
            ratio = median(a / b for a, b in rounds)
        ours, other = (median(each) for each in zip(*rounds, strict=True))
        line = f"{row.task:24}{ours:7.2f} s   {row.beside:28}{other:7.2f} s{ratio:8.3g}{row.most:7}"
        print(line, flush=True)
        seconds[row.task] = min(ours, seconds.get(row.task, ours))
        if ratio >= row.most:
            slow.append(line)
    assert not slow, slow
    return seconds


def timed(command) -> float:
    begin = time.perf_counter()
    call(command)
    return time.perf_counter() - begin


def test_the_small_campaign_keeps_its_budget(tmp_path):
    def rows():
        yield from start_up()
        yield from campaign("demo", tmp_path)

    measured(rows())


@pytest.mark.slow
def test_the_whole_campaign_and_reconcile_keep_their_budget(tmp_path):
    """Seconds are those of a machine that has nothing else to do."""

    def rows():
        yield from start_up()
        yield from campaign("demo", tmp_path)
        yield from campaign("stribeck", tmp_path)
        yield from fleet("demo", tmp_path, 20)
        yield from reconciled("discriminate", tmp_path)

    seconds = measured(rows())
    assert max(s for task, s in seconds.items() if task.startswith("report")) < REPORT_S
