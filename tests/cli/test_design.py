"""``hbench design`` as a user calls it."""

import json
import re
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest
import yaml
from typer.testing import CliRunner

from hbench import workflow
from hbench.cli.main import app
from hbench.control.grid import LOADS, SPEEDS
from hbench.errors import ExitCode, HbenchError
from hbench.workflow import controllers
from tests.support.commands import computed_once, hbench

BENCH = Path(__file__).parents[2] / "configs" / "bench-aau.yaml"


@pytest.fixture
def design(tmp_path, monkeypatch):
    """Return a function that calls ``hbench design`` in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return partial(hbench, "design")


@pytest.fixture
def slow_valve(tmp_path):
    """A bench whose valve is too slow for its speeds."""
    data = yaml.safe_load(BENCH.read_text())
    data["valve"]["bandwidth"] = "30 Hz"
    data["supply"]["pressure"] = "100 bar"
    path = tmp_path / "slow.yaml"
    path.write_text(yaml.safe_dump(data))
    return path


def test_a_bench_gets_a_table_of_loops_figures_page_and_json(design, tmp_path, undrawn):
    done = design(BENCH, "--operating-point", "v=-80 mm/s, load=-2 kN, x=150 mm", "-o", "out")
    assert done.returncode == 0, done.stderr
    shown = " ".join(done.stdout.split())
    assert "x 150 mm, v -80 mm/s, load -2000 N" in shown and done.stdout.isascii()
    assert f"up to {100 * max(LOADS):.0f} % of the supply pressure on the rod side" in shown
    assert max(SPEEDS) == 0.5 and "half of limits.speed_max" in shown
    board = [line for line in done.stdout.splitlines() if re.search(r"\bboard +\d", line)]
    gain = min((line.split()[3] for line in board), key=float)
    assert re.search(rf"velocity: gain margin {gain} >= 6 dB", shown)
    assert "agree" not in done.stdout  # the source's numbers are for the source's bench
    out = tmp_path / "out"
    numbers = json.loads((out / "design.json").read_text())
    assert numbers["schema"] == "hbench.design/1" and numbers["proposal"] is None
    gains = [low for what, (low, _) in numbers["margin_ranges"].items() if "gain" in what]
    everywhere = r"a check at \d+ of 54 operating points, worst with \d+ deg .* and ([\d.]+) dB"
    (worst,) = re.findall(everywhere, shown)
    assert float(worst) == pytest.approx(min(gains), abs=0.05) and min(gains) < float(gain)
    assert [loop["name"] for loop in numbers["loops"]] == [
        "velocity",
        "rod pressure",
        "piston pressure",
    ]
    assert re.search(
        r"dB \(limit 6 dB\) in the piston pressure loop at position \d+ mm, speed [+-]\d+ mm/s, "
        r"load [+-]\d+ N",
        shown,
    )
    page = (out / "design.html").read_text()
    assert page.count("<figure") == 13 and "http" not in page.split("<body>")[1]
    figures = {path.name for path in (out / "figures").iterdir()}
    kinds = {"locus", "bode", "step", "poles"}
    assert figures == {
        f"{loop}-{kind}.{suffix}"
        for loop in ("velocity", "rod-pressure", "piston-pressure")
        for kind in kinds
        for suffix in ("svg", "csv")
    } | {"margins.svg", "margins.csv"}
    assert len(numbers["points"]) == 54
    assert sum(not point["holds"] for point in numbers["points"]) == numbers["points_failed"]


def test_without_a_point_the_loops_are_those_of_the_worst_one(design, monkeypatch):
    computed_once(monkeypatch, "design")
    numbers = json.loads(design(BENCH, "--json").stdout)
    phases = {what: low for what, (low, _) in numbers["margin_ranges"].items() if "phase" in what}
    worst = min(phases, key=phases.get)
    (loop,) = (each for each in numbers["loops"] if worst.startswith(each["name"]))
    assert loop["chains"][-1]["phase_margin_deg"] == pytest.approx(phases[worst], rel=0.05)
    shown = " ".join(design(BENCH).stdout.split())
    assert "To pass there alone, lower the gain K_c of the" in shown


def test_without_a_bench_the_source_is_reproduced(design):
    done = design("--json")
    if "examples" in done.stderr:
        pytest.skip("the examples are put in place when hbench is installed")
    numbers = json.loads(done.stdout)
    widths = [loop["chains"][0]["bandwidth_rad_s"] for loop in numbers["loops"]]
    assert widths == pytest.approx([378, 151, 87], rel=0.01)
    contradictions = [n for n in numbers["reproduced"] if "contradiction" in n["note"]]
    assert len(contradictions) == 3 and not any(n["agrees"] for n in contradictions)


def test_a_proposal_that_fails_says_so_and_is_no_error_by_itself(design, slow_valve, monkeypatch):
    ratios = controllers.RATIOS[:2]
    monkeypatch.setattr(controllers, "RATIOS", ratios)
    done = design(slow_valve, "--propose")
    assert done.returncode == 0
    words = " ".join(done.stdout.split())
    assert re.search(r"verdict: FAIL: .* [1-9]\d* of \d+ checks", words)
    assert "runs, " in done.stderr and "runs, " not in done.stdout  # progress


@pytest.mark.parametrize(("holds", "code"), [(True, 0), (False, 6)])
def test_fail_turns_a_negative_verdict_into_exit_code_6(monkeypatch, holds, code):
    found = SimpleNamespace(proposal=SimpleNamespace(holds=holds))
    monkeypatch.setattr(workflow, "design", lambda *args, **more: found)
    monkeypatch.setattr("hbench.report.design.text.design_text", lambda found: "text")
    done = CliRunner().invoke(app, ["design", str(BENCH), "--propose", "--fail"])
    assert done.exit_code == code and done.stdout == "text\n"


def test_proposed_gains_can_be_pasted_into_the_bench_file(design, tmp_path, monkeypatch):
    """Without runs with the firmware, in which ``test_propose`` has such gains."""
    monkeypatch.setattr("hbench.experiment.design_verification.verify", lambda bench, report: ())
    done = design(BENCH, "--propose", "--fail")
    assert done.returncode == 0 and "verdict: PASS: " in done.stdout
    lines = done.stdout.splitlines()
    start = lines.index("controllers:")
    gains = yaml.safe_load("\n".join(lines[start : lines.index("", start)]))["controllers"]
    data = yaml.safe_load(BENCH.read_text())
    for loop, values in gains.items():
        data["controllers"][loop] = values
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(data))
    again = json.loads(design("mine.yaml", "--json").stdout)
    for loop in again["loops"]:
        board = loop["chains"][-1]
        assert board["phase_margin_deg"] > 45 and board["gain_margin_db"] > 6


def test_proposed_gains_are_written_into_the_bench_file_with_its_comments(tmp_path):
    mine, gains = tmp_path / "mine.yaml", {"velocity": (912.0, 0.0123)}
    mine.write_text(BENCH.read_text())
    proposal = SimpleNamespace(gains=gains, holds=True)
    workflow.write_gains(mine, SimpleNamespace(proposal=proposal))
    before, after = (path.read_text().splitlines() for path in (BENCH, mine))
    changed = [new for old, new in zip(before, after, strict=True) if new != old]
    assert [line.split("#")[0].strip() for line in changed] == [
        "gain: 912 V/m",
        "time_constant: 12.3 ms",
    ]
    with pytest.raises(HbenchError) as refused:
        workflow.write_gains(mine, SimpleNamespace(proposal=SimpleNamespace(holds=False)))
    assert refused.value.exit_code == ExitCode.USAGE and mine.read_text().splitlines() == after


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("nothing.yaml",), "nothing.yaml"),
        ((BENCH, "--operating-point", "speed=5 mm/s"), "speed"),
        ((BENCH, "--operating-point", "v=5"), "v = '5' "),
        ((BENCH, "--operating-point", "load=40 kN"), "bar"),
        ((BENCH, "--fail"), "--propose"),
        ((BENCH, "--write"), "--propose"),
        (("--propose", "--write"), "BENCH"),
        ((BENCH, "--propose", "--ratio", "0.5"), "--ratio"),
    ],
)
def test_what_can_not_be_used_is_refused_with_exit_code_2(design, arguments, words):
    done = design(*arguments)
    assert done.returncode == 2 and words in done.stderr and not done.stdout
