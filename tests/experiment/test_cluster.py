"""A fleet on a Dask cluster: real scheduler and worker processes, which are killed."""

import os
import re
import shutil
import signal
from datetime import UTC, datetime
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from hbench import workflow
from hbench.errors import ConfigError, DeviceError
from hbench.parallel import dask_cluster
from tests.support.faults.loopback import Loopback

SAMPLE = Path(__file__).parents[2] / "data_samples" / "bad-runs"
TABLE = "fleet.parquet"


@pytest.fixture
def loopback(tmp_path):
    """Return a function that starts a cluster."""
    pytest.importorskip("distributed")
    started = []

    def start(workers, **options):
        folder = tmp_path / f"cluster-{len(started)}"
        folder.mkdir()
        started.append(Loopback(folder, workers, **options))
        return started[-1]

    yield start
    for one in started:
        one.close()


@pytest.fixture(scope="module")
def unharmed(tmp_path_factory):
    """A cluster of one worker for tests that leave its processes alive."""
    pytest.importorskip("distributed")
    cluster = Loopback(tmp_path_factory.mktemp("cluster"), 1)
    yield cluster
    cluster.close()


@pytest.fixture
def line(tmp_path):
    """Return a function that makes campaigns of these names, two of them spoilt in two ways."""

    def make(*names) -> Path:
        for name in names:
            shutil.copytree(SAMPLE, tmp_path / "line" / name)
        journal = tmp_path / "line" / names[1] / "campaign.yaml"
        journal.write_bytes(journal.read_bytes()[:700])
        (tmp_path / "line" / names[2] / "campaign.yaml").unlink()
        return tmp_path / "line"

    return make


def rows(folder) -> dict[str, dict]:
    found = pq.read_table(folder / TABLE).to_pylist()
    return {os.path.basename(row["path"]): row for row in found}


def analyze(folder, out, scheduler=None, note=lambda words: None):
    return workflow.analyze_fleet(
        [str(folder)],
        out,
        scheduler=scheduler,
        speed_m_s=None,
        report=lambda *_: None,
        note=note,
    )


def test_a_worker_killed_in_the_middle_leaves_a_table_identical_to_the_local_one(
    loopback, line, tmp_path, one_process
):
    folder = line(*(f"slow-{i:02d}" for i in range(8)))
    dask = loopback(2)
    host = dask.hbench("fleet", folder, "-o", tmp_path / "far", "--scheduler", dask.address)
    dask.wait_for_campaigns(host, 3)
    os.kill(dask.workers[0].pid, signal.SIGKILL)
    code, told = dask.ended(host)
    assert code == 0 and "Traceback" not in told, told
    assert dask.workers[0].poll() == -signal.SIGKILL and dask.workers[1].poll() is None
    assert "8/8 campaigns, 2 failed" in told

    near = analyze(folder, tmp_path / "near")
    assert (near.campaigns, near.failed) == (8, 2)
    assert (tmp_path / "far" / TABLE).read_bytes() == (tmp_path / "near" / TABLE).read_bytes()
    found = rows(tmp_path / "far")
    assert list(found) == sorted(found) and len(found) == 8
    assert [name for name, row in found.items() if row["failed"]] == ["slow-01", "slow-02"]


@pytest.mark.slow
def test_a_campaign_that_kills_its_worker_each_time_is_a_failed_row_and_no_other_is(
    loopback, line, tmp_path, one_process
):
    folder = line("e", "b", "c", "deadly")
    dask = loopback(1, nanny=True, forgiven=0)
    for out, scheduler in (("far", ["--scheduler", dask.address]), ("near", [])):
        code, told = dask.ended(dask.hbench("fleet", folder, "-o", tmp_path / out, *scheduler))
        assert code == 0 and "4/4 campaigns, 3 failed" in told, told
    assert (tmp_path / "far" / TABLE).read_bytes() == (tmp_path / "near" / TABLE).read_bytes()
    found = rows(tmp_path / "far")
    assert [name for name, row in found.items() if row["failed"]] == ["b", "c", "deadly"]
    assert "killed" in found["deadly"]["failed"]
    again = analyze(folder, tmp_path / "near")  # by a process that it does not kill
    assert again.failed == 2 and not rows(tmp_path / "near")["deadly"]["failed"]


def test_a_lost_scheduler_ends_it_with_a_cause_and_the_rest_can_be_done_elsewhere(
    loopback, line, tmp_path, one_process
):
    folder = line(*(f"slow-{i:02d}" for i in range(7)))
    dask = loopback(1)
    out = tmp_path / "out"
    host = dask.hbench("fleet", folder, "-o", out, "--scheduler", dask.address)
    dask.wait_for_campaigns(host, 3)
    os.kill(dask.scheduler.pid, signal.SIGKILL)
    code, told = dask.ended(host)
    assert code == 3, told
    assert re.search(rf"^error: {dask.address}: .*\nhint: ", told, re.M)
    assert "Traceback" not in told and not (out / TABLE).exists()
    notes = []
    analyze(folder, out, note=notes.append)
    assert any(" of 7 campaigns" in words for words in notes), notes
    analyze(folder, tmp_path / "near")
    assert (out / TABLE).read_bytes() == (tmp_path / "near" / TABLE).read_bytes()


def test_ctrl_c_keeps_what_is_done_and_frees_the_cluster(unharmed, line, tmp_path):
    folder = line(*(f"slow-{i:02d}" for i in range(10)))
    dask = unharmed
    host = dask.hbench("fleet", folder, "-o", tmp_path / "out", "--scheduler", dask.address)
    dask.wait_for_campaigns(host, 4)
    host.send_signal(signal.SIGINT)
    code, told = dask.ended(host)
    assert code == 130 and "interrupted" in told, told
    assert "Traceback" not in told
    notes = []
    analyze(folder, tmp_path / "out", dask.address, notes.append)
    assert any("of 10 campaigns" in words for words in notes), notes


def profiles(client) -> list[bool]:
    """Tell of each worker whether it makes profiles."""

    def makes(dask_worker):
        made = [dask_worker.periodic_callbacks.get(name) for name in ("profile", "profile-cycle")]
        return all(each is not None and each.is_running() for each in made)

    return list(client.run(makes).values())


def test_workers_make_no_profiles_while_hbench_is_connected_also_those_that_join(unharmed):
    """Each second's is kept for an hour: a worker's memory would grow by some 50 kB a second."""
    from distributed import Client

    dask = unharmed
    with Client(dask.address, set_as_default=False) as other:
        assert profiles(other) == [True]
        with dask_cluster.connected(dask.address):
            assert profiles(other) == [False]
            dask.worker()
            other.wait_for_workers(2, timeout=60)
            assert profiles(other) == [False, False]
        assert profiles(other) == [True, True]


def test_no_worker_for_long_and_nobody_at_the_address_are_errors_with_a_hint(
    loopback, line, tmp_path, monkeypatch
):
    folder = line("a", "b", "c")
    monkeypatch.setattr(dask_cluster, "_PATIENCE_S", 1.5)
    monkeypatch.setattr(dask_cluster, "_CONNECT_S", 1.0)
    with pytest.raises(DeviceError, match="no worker") as error:
        analyze(folder, tmp_path / "out", loopback(0).address)
    assert "dask worker" in error.value.hint
    with pytest.raises(DeviceError, match="127.0.0.1:9") as error:
        analyze(folder, tmp_path / "out", "tcp://127.0.0.1:9")
    assert "dask scheduler" in error.value.hint
    for address in ("machine", "ftp://machine:1"):
        with pytest.raises(ConfigError, match=address):
            analyze(folder, tmp_path / "out", address)


def test_without_dask_it_says_what_to_install(line, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(ConfigError, match="installed") as error:
        analyze(line("a", "b", "c"), tmp_path / "out", "tcp://127.0.0.1:8786")
    assert "cluster" in error.value.hint


def test_a_worker_of_another_hbench_is_refused(line, tmp_path, monkeypatch):
    def other(*_, **__):
        row = workflow.fleet.FleetRow(str(tmp_path))
        yield workflow.fleet.AnalyzedCampaign(str(tmp_path), "", "0.0.9", row)

    monkeypatch.setattr(workflow.fleet, "map_on_cores", other)
    with pytest.raises(DeviceError, match=r"0\.0\.9"):
        analyze(line("a", "b", "c"), tmp_path / "out")


def test_the_moment_that_a_campaign_was_begun_is_in_its_row(line, tmp_path, one_process):
    analyze(line("a", "b", "c"), tmp_path / "out")
    assert rows(tmp_path / "out")["a"]["started"] == datetime(2026, 1, 1, tzinfo=UTC)
