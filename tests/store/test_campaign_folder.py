import os
import re
from datetime import date
from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench.analysis.screening.limitations import overdue
from hbench.config.schedule import Screening, parse_schedule
from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import StoredCampaign, load_campaign, write_results
from hbench.store.campaign.stored_acceptance import stored_checks, stored_decision
from hbench.store.campaign.writer import CampaignWriter
from hbench.store.dsp_logs.dsp_log import parse_words

CONFIGS = Path(__file__).parents[2] / "configs"


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "campaign"


@pytest.fixture
def writer(folder, header):
    return CampaignWriter.create(folder, header)


@pytest.fixture
def make(make_plan, at):
    """Make one run from start to stop."""

    def make(writer, words, run="0001", outcome="done", why=""):
        writer.start_run(make_plan(run), at(1))
        writer.finish_run(make_plan(run), words, outcome, why, at(2))

    return make


def only(folder):
    (raw,) = load_campaign(folder).raw_runs()
    return raw


def test_a_run_comes_back(folder, writer, words, make_plan, make):
    make(writer, words)
    raw = only(folder)
    assert raw.plan == make_plan()
    assert raw.words.tolist() == words.tolist()
    assert [channel.name for channel in raw.channels] == ["run", "index", "x"]
    assert (raw.rate_hz, raw.flags, raw.outcome, raw.warnings) == (100.0, ("last",), "done", ())


def test_log_is_on_disk_before_the_stop_part(folder, writer, words, monkeypatch, make_plan, at):
    writer.start_run(make_plan(), at(1))
    real = os.replace

    def replace(source, target):
        assert "stop:" not in (folder / "campaign.yaml").read_text()
        real(source, target)

    monkeypatch.setattr(os, "replace", replace)
    writer.finish_run(make_plan(), words, "done", "", at(2))
    assert "stop:" in (folder / "campaign.yaml").read_text()


def test_run_without_stop_part_has_no_outcome(folder, writer, words, make_plan, at, make):
    make(writer, words)
    writer.start_run(make_plan("0002"), at(3))
    campaign = load_campaign(folder)
    crashed = list(campaign.raw_runs())[1]
    assert crashed.outcome is None
    assert crashed.words.shape == (0, 3)
    assert [w.split()[:2] for w in crashed.warnings] == [["missing:", "runs/0002.dat"]]
    assert campaign.done == {"0001"}


def test_run_made_again_counts_and_the_first_log_is_kept(folder, writer, words, make):
    make(writer, words[:2], outcome="aborted", why="operator")
    first = (folder / "runs" / "0001.dat").read_bytes()
    again = CampaignWriter.resume(folder)
    make(again, words)
    campaign = load_campaign(folder)
    assert [entry.stop.outcome for entry in campaign.entries] == ["aborted", "done"]
    assert only(folder).words.tolist() == words.tolist()
    assert (folder / "runs" / "0001~1.dat").read_bytes() == first
    make(again, words[:3], outcome="failed", why="x")
    assert len(list((folder / "runs").iterdir())) == 3


def test_stopped_attempt_wins_over_a_later_crash_even_when_its_log_was_moved(
    folder, writer, words, make_plan, at, make
):
    make(writer, words, outcome="failed", why="line lost")
    again = CampaignWriter.resume(folder)
    again.start_run(make_plan(), at(5))
    (folder / "runs" / "0001.dat").rename(folder / "runs" / "0001~1.dat")
    raw = only(folder)
    assert (raw.outcome, raw.why, raw.warnings) == ("failed", "line lost", ())
    assert raw.words.tolist() == words.tolist()


def test_resume_after_a_tear_at_any_byte_goes_on_to_a_valid_journal(
    folder, writer, words, make_plan, at, make
):
    path = folder / "campaign.yaml"
    start = len(path.read_bytes())
    make(writer, words)
    text = path.read_bytes()
    for length in range(start, len(text)):
        path.write_bytes(text[:length])
        CampaignWriter.resume(folder).start_run(make_plan("0002"), at(9))
        runs = yaml.load(path.read_text(), Loader=yaml.CSafeLoader)["runs"]
        assert runs[-1]["run"] == "0002"
        warnings = load_campaign(folder).warnings
        assert not any("half-written" in words for words in warnings)
        # The log of an entry that was torn off with its start is left out, and said so.
        assert len(warnings) == ("0001" not in [run["run"] for run in runs])


def test_missing_log_of_a_done_run_is_told(folder, writer, words, make):
    make(writer, words)
    (folder / "runs" / "0001.dat").unlink()
    raw = only(folder)
    assert (raw.outcome, raw.words.shape) == ("done", (0, 3))
    assert [w.split()[:2] for w in raw.warnings] == [["missing:", "runs/0001.dat"]]


def test_changed_log_is_told(folder, writer, words, make):
    make(writer, words)
    path = folder / "runs" / "0001.dat"
    path.write_bytes(path.read_bytes().replace(b"000b", b"000c"))
    assert [w.split(":")[0] for w in only(folder).warnings] == ["changed"]


def test_cut_log_keeps_its_whole_records(folder, writer, words, make):
    make(writer, words)
    path = folder / "runs" / "0001.dat"
    path.write_bytes(path.read_bytes()[:-7])
    raw = only(folder)
    assert raw.words.tolist() == words[:3].tolist()
    codes = [warning.split(":")[0] for warning in raw.warnings]
    assert codes[0] == "changed" and set(codes[1:]) == {"truncated"}
    assert raw.warnings[-1].startswith("truncated: ") and "3 of 4" in raw.warnings[-1]


def test_unreadable_log_spoils_its_own_run_alone(folder, writer, words, make):
    make(writer, words, "0001")
    make(writer, words, "0002")
    (folder / "runs" / "0001.dat").write_text("1651 1 0 0 2\n0001\noops\n")
    first, second = load_campaign(folder).raw_runs()
    assert first.words.shape == (0, 3)
    assert "unreadable: runs/0001.dat: line 3: found 'oops'" in first.warnings[-1]
    assert second.warnings == ()


def test_raw_log_is_a_ccs_file_of_16_bit_words(folder, writer, words, make):
    make(writer, words)
    data = (folder / "runs" / "0001.dat").read_bytes()
    assert data.startswith(b"1651 1 0 0 c\n0000\n0001\n")
    assert parse_words(data, "")[0].tolist() == words.ravel().tolist()


def test_campaign_is_not_written_over(folder, writer, header):
    with pytest.raises(ConfigError, match=re.escape(str(folder))):
        CampaignWriter.create(folder, header)


def test_bench_and_screening_come_from_the_files_as_written(folder, header):
    bench = yaml.safe_load((CONFIGS / "bench-aau.yaml").read_text())
    schedule = yaml.safe_load((CONFIGS / "demo.yaml").read_text())
    schedule["screening"] = {"min_window": "0.7 s"}
    header["bench"] = {"file": "bench-aau.yaml", "content": bench}
    header["schedule"] = {"file": "demo.yaml", "content": schedule}
    CampaignWriter.create(folder, header)
    campaign = load_campaign(folder)
    assert campaign.bench().supply.pressure == pytest.approx(150e5)
    assert campaign.screening() == Screening(min_window="0.7 s")
    provenance = campaign.provenance()
    assert provenance.bench == bench["name"]
    assert provenance.firmware == "version core 1, board host"
    assert provenance.details == {"port": "sim", "seed": 7}


def test_header_without_log_layout_is_refused(folder, header):
    del header["log"]
    CampaignWriter.create(folder, header)
    with pytest.raises(DataError, match="campaign.yaml: log: "):
        list(load_campaign(folder).raw_runs())


def test_results_lie_below_results(folder, writer):
    write_results(folder, {"results.json": b"{}", "figures/a.png": b"png"})
    assert (folder / "results" / "figures" / "a.png").read_bytes() == b"png"
    with pytest.raises(DataError, match=r"\.\."):
        write_results(folder, {"../campaign.yaml": b""})


def test_finishing_another_run_than_the_one_started_is_refused(
    folder, writer, words, make_plan, at
):
    writer.start_run(make_plan("0001"), at(1))
    with pytest.raises(ValueError, match="0002"):
        writer.finish_run(make_plan("0002"), words, "done", "", at(2))
    assert np.array_equal(os.listdir(folder), ["campaign.yaml"])


def test_damaged_logs_are_looked_for_without_reading_the_journal_anew_for_each_run(
    folder, writer, words, make, monkeypatch
):
    """With 3600 runs that took 8 s."""
    for number in range(1, 21):
        make(writer, words, run=f"{number:04d}")
    campaign, latest, times = load_campaign(folder), StoredCampaign.latest.fget, []
    monkeypatch.setattr(
        StoredCampaign, "latest", property(lambda self: times.append(1) or latest(self))
    )
    assert not campaign.damaged()
    assert 0 < len(times) < 5


def test_a_log_without_an_entry_is_told(folder, writer, words, make_plan, make):
    make(writer, words)
    (folder / "runs" / "0002.dat").write_bytes(b"")
    (warning,) = load_campaign(folder).warnings
    assert "0002.dat" in warning and "(1 log)" in warning


def test_a_log_of_absurd_size_is_flagged_before_it_is_read(folder, writer, words, make):
    make(writer, words)
    os.truncate(folder / "runs" / "0001.dat", 40_000_000_000)  # sparse
    (raw,) = load_campaign(folder).raw_runs()
    assert len(raw.words) == 0
    assert re.search(r"0001\.dat: .*\b40000 MB.* 40 MB", raw.warnings[0])


def test_a_journal_of_absurd_size_is_refused_before_it_is_read(folder, writer):
    os.truncate(folder / "campaign.yaml", 40_000_000_000)
    with pytest.raises(DataError, match=r"campaign\.yaml: .*\b40000 MB.* 8 MB"):
        load_campaign(folder)


def test_a_schedule_adds_to_the_bench_files_identity_and_an_overdue_calibration_is_noted(
    folder, header
):
    bench = yaml.safe_load((CONFIGS / "bench-aau.yaml").read_text())
    schedule = yaml.safe_load((CONFIGS / "demo.yaml").read_text())
    bench["specimen"] = {"serial": "none", "seals": "NBR 70"}
    bench["instruments"]["force"]["calibration"] = {"due": date(2026, 1, 15)}
    schedule["specimen"] = {"serial": "4711"}
    schedule["test"] = {"number": "T-8", "date": date(2026, 2, 1)}
    header["bench"] = {"file": "bench-aau.yaml", "content": bench}
    header["schedule"] = {"file": "demo.yaml", "content": schedule}
    CampaignWriter.create(folder, header)
    campaign = load_campaign(folder)
    settings = campaign.provenance().settings
    assert settings["specimen"] == {"serial": "4711", "seals": "NBR 70"}
    assert settings["test"] == {"number": "T-8", "date": "2026-02-01"}
    assert list(settings)[:3] == ["specimen", "test", "oil"]
    instruments = campaign.setup().instruments
    assert instruments.force.calibration.due == date(2026, 1, 15)
    (note,) = overdue(instruments, "2026-02-01T08:00:00+00:00")
    assert "load cell" in note and "2026-01-15" in note
    assert not overdue(instruments, "2026-01-15T08:00:00+00:00")


def test_an_identity_that_cannot_be_printed_names_its_key(folder, header):
    with pytest.raises(ConfigError, match=r"s\.yaml: specimen\.serial = .*printable"):
        schedule = yaml.safe_load((CONFIGS / "demo.yaml").read_text())
        parse_schedule(schedule | {"specimen": {"serial": "a\x00"}}, "s.yaml")
    for altered in (7, 1.5):  # of 007, 1.50
        with pytest.raises(ConfigError, match="quotes"):
            parse_schedule(schedule | {"specimen": {"serial": altered}}, "s.yaml")


@pytest.mark.parametrize(
    ("given", "message", "hint"),
    [
        ("logs/a.csv", "logs/a.csv: is a file, not a campaign", "`hbench import {}/logs --s"),
        (
            "logs",
            "logs/campaign.yaml: No such file",
            "`hbench import {}/logs --s",
        ),
        ("campaign/runs", "runs/campaign.yaml: No such file", "Give {}/campaign, the campaign"),
        ("campaign/runs/0001.dat", "0001.dat: is a file, not a c", "Give {}/campaign, the"),
        ("campaign/campaign.yaml", "yaml: is a file, not a campaign", "Give {}/campaign, the"),
        ("nowhere", "nowhere/campaign.yaml: No such file", "a folder written by `hbench run`"),
    ],
)
def test_a_path_that_is_no_campaign_is_refused_with_what_to_give(
    tmp_path, writer, words, make, given, message, hint
):
    make(writer, words)
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs" / "a.csv").write_text("t,x\n0,1\n")
    with pytest.raises(DataError) as caught:
        load_campaign(tmp_path / given)
    assert message in caught.value.message
    assert hint.format(tmp_path) in caught.value.hint


def test_an_unreadable_results_folder_holds_no_decision(folder):
    """One campaign's permissions do not end the evaluation of a whole fleet."""
    (folder / "results").mkdir(parents=True)
    (folder / "results" / "acceptance.json").write_text("{}")
    (folder / "results").chmod(0)
    try:
        if os.access(folder / "results", os.X_OK):
            pytest.skip("this user reads every folder")
        assert (stored_decision(folder), stored_checks(folder)) == ("", ())
    finally:
        (folder / "results").chmod(0o755)
