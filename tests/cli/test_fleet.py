"""``hbench fleet`` on this machine: spoilt campaigns, called again, changed, interrupted."""

import errno
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from typer.testing import CliRunner

from hbench.cli.main import app
from hbench.errors import ConfigError, DataError
from tests.support import ROOT
from tests.support.cut_campaign import two_curves

SAMPLES = Path(__file__).parents[2] / "data_samples"
DEADLY = ROOT / "tests" / "support" / "faults" / "deadly.py"
LIMIT_S = 300.0  # of a wait; it takes some seconds
ODD = "=1+1 <b>\"'; ä,"

pytestmark = pytest.mark.usefixtures("undrawn")


@pytest.fixture
def line(tmp_path):
    """Return a folder of campaigns, some of them spoilt."""
    folder = tmp_path / "line"
    for name in ("good", ODD, "cut", "binary", "nothing", "logless", "gone", "list"):
        shutil.copytree(SAMPLES / "bad-runs", folder / name)
    journal = {name: folder / name / "campaign.yaml" for name in os.listdir(folder)}
    journal["cut"].write_bytes(journal["cut"].read_bytes()[:500])
    journal["binary"].write_bytes(b"name: \xff\xfe\n")
    journal["nothing"].write_bytes(b"")
    journal["gone"].unlink()
    journal["list"].write_text("- 1\n- 2\n")
    shutil.rmtree(folder / "logless" / "runs")
    (folder / "empty").mkdir()
    return folder


def fleet(*arguments):
    return CliRunner().invoke(app, ["fleet", *map(str, arguments)])


def rows(out):
    return {Path(row["path"]).name: row for row in pq.read_table(out / "fleet.parquet").to_pylist()}


def test_spoilt_campaigns_are_rows_with_their_reasons_and_the_second_call_does_what_has_changed(
    line, tmp_path, monkeypatch
):
    out = tmp_path / "out"
    done = fleet(line, "-o", out, "--json")
    assert done.exit_code == 0, (done.output, done.exception)
    document = json.loads(done.stdout)
    assert document["schema"] == "hbench.fleet/1"
    assert (document["campaigns"], document["failed"]) == (8, 5)
    found = rows(out)
    assert list(found) == sorted(found) and "empty" not in found
    reasons = {name: row["failed"] for name, row in found.items() if row["failed"]}
    assert set(reasons) == {"cut", "binary", "nothing", "gone", "list"}
    assert all(words.startswith("campaign.yaml: ") for words in reasons.values())
    assert os.strerror(errno.ENOENT) in reasons["gone"] and "UTF-8" in reasons["binary"]
    assert found["good"]["accepted"] > 0 == found["logless"]["accepted"]
    kept = dict.fromkeys(("path", "started"))
    way_m, work_j = found["good"]["distance_m"], found["good"]["friction_work_j"]
    assert 0.5 < way_m < 20 and 200 < work_j / way_m < 2000  # some 20 runs; N
    assert found[ODD] | kept == found["good"] | kept
    page = (out / "fleet.html").read_text()
    assert '<b>"' not in page and "\u202e" not in page
    assert not any((line / name / "results").exists() for name in found), (
        "campaigns stay as they are"
    )

    before = (out / "fleet.parquet").read_bytes()
    again = fleet(line, "-o", out, "--fail")
    assert again.exit_code == 6 and "8 of 8 campaigns" in again.stderr
    assert (out / "fleet.parquet").read_bytes() == before

    shutil.copy(line / "good" / "campaign.yaml", line / "gone")
    shutil.rmtree(line / "cut")
    monkeypatch.setattr("hbench.workflow.fleet.map_on_cores", map)  # others took some seconds
    last = fleet(line / "*", "-o", out)
    assert last.exit_code == 0 and "6 of 7 campaigns" in last.stderr
    assert f"{line / 'empty'}" not in rows(out) and not rows(out)["gone"]["failed"]
    assert len(rows(out)) == 7


def test_nothing_to_analyze_and_nowhere_to_write_are_errors(line, tmp_path):
    with pytest.raises(DataError):
        CliRunner().invoke(
            app, ["fleet", str(line / "empty"), "-o", str(tmp_path / "o")], catch_exceptions=False
        )
    done = fleet(line / "good")
    assert done.exit_code == 2 and "--output" in done.output
    done = fleet(line / "good", "-o", line / "good")
    assert isinstance(done.exception, ConfigError)
    assert "contains a campaign already" in done.exception.message
    assert not (line / "good" / "fleet.sqlite").exists()
    for speed in ("0 mm/s", "fast"):
        done = fleet(line / "good", "-o", tmp_path / "o", "--speed", speed)
        assert isinstance(done.exception, ConfigError) and "--speed" in done.exception.message


def test_another_working_speed_makes_other_rows(line, tmp_path, one_process):
    out = tmp_path / "out"
    assert fleet(line / "good", "-o", out).exit_code == 0
    first = rows(out)["good"]["v_m_s"]
    done = fleet(line / "good", "-o", out, "--speed", "90 mm/s")
    assert "1 of 1 campaigns" not in done.stderr
    assert rows(out)["good"]["v_m_s"] == pytest.approx(0.09) != first


def test_a_copy_and_a_link_of_a_campaign_are_no_further_measurements(tmp_path):
    folder = tmp_path / "line"
    two_curves(folder / "a")
    two_curves(folder / "a copy")
    (folder / "link").symlink_to("a")
    done = fleet(folder / "a", folder / "a copy", folder / "link", "-o", tmp_path / "out", "--json")
    assert done.exit_code == 0, (done.output, done.exception)
    document = json.loads(done.stdout)
    assert (document["campaigns"], document["compared"], document["copies"]) == (3, 1, 2)
    assert len({row["logs_sha256"] for row in rows(tmp_path / "out").values()}) == 1
    page = (tmp_path / "out" / "fleet.html").read_text()
    assert "2 of 3 analysed campaigns are copies with the logs of another" in page


def test_without_pyarrow_it_says_what_to_install(line, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    done = fleet(line, "-o", tmp_path / "out")
    assert isinstance(done.exception, ConfigError) and "parquet" in done.exception.hint


def test_ctrl_c_keeps_what_is_done_and_the_same_command_goes_on(tmp_path, one_process):
    for i in range(7):
        shutil.copytree(SAMPLES / "bad-runs", tmp_path / "line" / f"slow-{i:02d}")
    told = tmp_path / "told"

    command = "fleet", tmp_path / "line", "-o", tmp_path / "out"
    host = subprocess.Popen(
        [sys.executable, DEADLY, *command],
        stdin=subprocess.DEVNULL, stdout=told.open("w"), stderr=subprocess.STDOUT,
        start_new_session=True, env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )  # fmt: skip
    try:
        while "/7 campaigns" not in told.read_text():
            assert host.poll() is None, told.read_text()
            time.sleep(0.02)
        os.killpg(host.pid, signal.SIGINT)
        assert host.wait(LIMIT_S) == 130
        text = told.read_text()
        assert "interrupted" in text and "Traceback" not in text
    finally:
        if host.poll() is None:
            os.killpg(host.pid, signal.SIGKILL)
    done = fleet(*command[1:])
    assert done.exit_code == 0 and re.search(r"^note: [1-9]\d* of 7 ", done.stderr, re.M)
    assert len(rows(tmp_path / "out")) == 7
