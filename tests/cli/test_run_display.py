"""What ``hbench run`` tells: a block in a terminal, a line a run in a pipe."""

import io
import os
import re
import signal
import subprocess
import sys

import pytest
import yaml

from hbench.cli.bench_display import BenchDisplay
from hbench.experiment.progress import Ended, Progress
from hbench.records import RunPlan, Specimen
from hbench.store.campaign.folder import load_campaign
from tests.support.commands import hbench
from tests.support.report.terminal import Terminal, screen

TOO_STRICT = {"low_speed_error": "0.001 mm/s", "low_speed_error_relative": 1e-6}


@pytest.fixture
def picky_schedule(quick_schedule):
    """A schedule of four runs, none of which is good enough."""
    path = quick_schedule()
    data = yaml.safe_load(path.read_text())
    data["screening"] |= TOO_STRICT
    path.write_text(yaml.safe_dump(data))
    return path


def in_a_pipe(tmp_path, *arguments):
    return subprocess.run(
        [sys.executable, "-m", "hbench", "run", *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )


def test_a_pipe_gets_one_line_a_run(quick_schedule, tmp_path):
    done = in_a_pipe(tmp_path, quick_schedule(), "-o", "out")
    assert done.returncode == 0
    _, *lines, after = done.stderr.splitlines()
    assert after.split()[-3:] == ["hbench", "report", "out"]
    pattern = (
        r"{0} of 4: 000{0} steady \+{1}\.0 mm/s, \+2000 N, trial {2}: accepted, "
        r"friction \+\d+\.\d N; \d+:\d\d left"
    )
    expected = [(1, 80, 1), (2, 80, 2), (3, 120, 1), (4, 120, 2)]
    assert len(lines) == 4 and "\x1b" not in done.stderr and "\r" not in done.stderr
    for line, numbers in zip(lines, expected, strict=True):
        assert re.fullmatch(pattern.format(*numbers), line), line
    assert lines[-1].endswith("0:00 left")
    assert done.stdout.startswith("out: 4 runs ")
    assert not (tmp_path / "out" / "live.json").exists()


def test_a_pipe_gets_each_rejection_with_its_reason(picky_schedule, tmp_path):
    done = hbench("run", picky_schedule, "-o", tmp_path / "out", "--retry", "1")
    assert done.returncode == 0
    _, *lines, _ = done.stderr.splitlines()
    assert len(lines) == 8
    assert all("rejected: off_reference: " in line for line in lines)
    assert [line.endswith("repeated") for line in lines] == [True, False] * 4
    assert len(load_campaign(tmp_path / "out").entries) == 8


def test_a_terminal_shows_a_block_and_keeps_the_rejections(picky_schedule, tmp_path):
    with Terminal(["run", picky_schedule, "-o", "out"], tmp_path, columns=90) as terminal:
        assert terminal.end() == 0
    blocks = terminal.shown.decode().replace("\r", "").split("\x1b[J")
    first = blocks[1].splitlines()
    assert [line.split()[0] for line in first[1:6]] == [
        "run", "speed", "force", "pressure", "rejected"
    ]  # fmt: skip
    assert re.match(r"run +1 of 4, \w+ 1 of 2: steady \+80\.0 mm/s, \+2000 N; ", first[1])
    assert re.fullmatch(r"speed     [+-]\d+\.\d of [+-]\d+\.\d mm/s", first[2])
    assert re.fullmatch(r"force     F_L [+-]\d+ of \+2000 N, .* [+-]\d+ N", first[3])
    sides = "  ".join(rf"{name} \d+\.\d" for name in ("P_Tp", "P_Tr", "P_Lp", "P_Lr", "P_S"))
    assert re.fullmatch(rf"pressure  {sides} bar, limit 230", first[4])
    assert any(re.search(r"^rejected  [1-4]; 000\d: off_reference: ", b, re.M) for b in blocks)
    assert all(len(line) < 90 for block in blocks for line in block.splitlines()[-6:])
    end = screen(terminal.shown)
    kept = [line for line in end if "rejected: off_reference" in line]
    assert [line[:4] for line in kept] == ["0001", "0002", "0003", "0004"]
    assert not any(line.startswith(("[", "speed", "pressure")) for line in end), "a block is left"
    assert end[-3].startswith("out: 4 runs ")


def test_ctrl_c_at_the_terminal_takes_the_block_away_and_leaves_nothing_live(
    short_schedule, tmp_path
):
    schedule = short_schedule(  # 400 runs: some seconds, however late the test reads the terminal
        velocities=[f"{speed} mm/s" for speed in range(50, 150, 5)], trials=20, window="5 s"
    )
    with Terminal(["run", schedule, "-o", "out"], tmp_path) as terminal:
        terminal.wait_for(b"constant speed")
        os.kill(terminal.process.pid, signal.SIGINT)
        assert terminal.end() == 130
    end = screen(terminal.shown)
    assert end[-2].startswith("interrupted") and "--resume" in end[-2]
    assert "Traceback" not in "\n".join(end)
    assert not any(line.startswith(("[", "speed", "pressure")) for line in end), "a block is left"
    assert not (tmp_path / "out" / "live.json").exists()
    stop = load_campaign(tmp_path / "out").entries[-1].stop
    assert stop is None or stop.outcome == "aborted"  # None: it came while a run's start was noted


def test_ramps_of_different_accelerations_have_different_lines():
    def line(kind, acceleration):
        plan = RunPlan("0001", kind, 1, 0.2, Specimen(0.0, 0.0), a_ref_m_s2=acceleration)
        stream = io.StringIO()
        ended = (Ended(plan, 1, (), None),)
        BenchDisplay(stream)(Progress(1, 1, plan, 0.0, 0.0, ended=ended))
        return stream.getvalue()

    assert "ramp +200.0 mm/s at 0.0335 m/s^2, trial 1" in line("ramp", 0.0335)
    assert "ramp +200.0 mm/s at 0.067 m/s^2, trial 1" in line("ramp", 0.067)
    assert "m/s^2" not in line("steady", 1.0)


def test_a_speed_below_1_mm_s_keeps_two_digits():
    plan = RunPlan("0001", "steady", 1, 0.00038, Specimen(0.0, 0.0), f_load_n=0.0)
    stream = io.StringIO()
    BenchDisplay(stream)(Progress(1, 1, plan, 0.0, 0.0, ended=(Ended(plan, 1, (), None),)))
    assert "steady +0.38 mm/s, +0 N, trial 1" in stream.getvalue()
