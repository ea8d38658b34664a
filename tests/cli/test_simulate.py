"""``hbench simulate``: the list, one phenomenon on disk, an unknown name."""

import subprocess
import sys
from pathlib import Path

from hbench.experiment.phenomena import PHENOMENA

BENCH = Path(__file__).parents[2] / "configs" / "bench-aau.yaml"


def hbench(*arguments):
    command = [sys.executable, "-c", "from hbench.cli.main import main; main()", "simulate"]
    return subprocess.run([*command, *map(str, arguments)], capture_output=True, text=True)


def test_without_a_name_it_lists_what_there_is():
    done = hbench()
    assert done.returncode == 0 and done.stdout.split() == list(PHENOMENA)


def test_a_phenomenon_is_written_with_page_figures_and_data(tmp_path):
    done = hbench("--phenomenon", "lag", "--bench", BENCH, "-o", tmp_path / "out")
    assert done.returncode == 0 and done.stderr.strip().endswith("lag.html")
    names = {path.name for path in (tmp_path / "out").rglob("*.*")}
    parts = {
        f"lag-{panel}.{kind}" for panel in ("loops", "width") for kind in ("svg", "png", "csv")
    }
    assert names == {"lag.html", *parts}
    assert "Tustin's width at 2 Hz" in done.stdout


def test_an_unknown_name_is_a_usage_error_that_names_the_known():
    done = hbench("--phenomenon", "magic")
    assert done.returncode == 2
    assert "unknown phenomenon 'magic'" in done.stderr and "stick-slip" in done.stderr
