"""Files from strangers: campaigns, schedules, logs and maps that somebody else made, or spoilt.

They may be refused or their runs rejected. They run nothing, write nothing elsewhere, read nothing
elsewhere, and take no more memory and time than others. More of it: their YAML in
test_strangers_yaml.py; that their words stay words in test_strangers_words.py; what compressed
files unpack to in store/test_unpacking.py; who can ask the page of ``hbench watch`` in
cli/test_watch.py; files that went bad by chance in store/test_mutated_campaigns.py.
"""

import csv
import io
import os
import re
import shutil
from datetime import UTC, datetime
from pathlib import Path

import pytest
import yaml

from hbench import workflow
from hbench.errors import ConfigError, DataError

ROOT = Path(__file__).parents[1]
SAMPLE = ROOT / "data_samples" / "bad-runs"
AT = datetime(2026, 1, 1, tzinfo=UTC)


@pytest.fixture
def campaign(tmp_path, undrawn):
    """A campaign as it came in the mail."""
    folder = tmp_path / "campaign"
    shutil.copytree(SAMPLE, folder, ignore=shutil.ignore_patterns("results"))
    return folder


@pytest.fixture
def logs(tmp_path, campaign):
    """A folder of logs to be imported, with its index ``runs.csv``."""
    workflow.export(campaign, tmp_path / "logs", "csv")
    return tmp_path / "logs"


def edit(folder, change):
    """Change the content of a campaign's journal."""
    path = folder / "campaign.yaml"
    content = yaml.safe_load(path.read_text())
    change(content)
    path.write_text(yaml.safe_dump(content, sort_keys=False))


def outside(tmp_path):
    """Return all that is not the campaign's, with its bytes."""
    own = tmp_path / "campaign"
    return {p: p.read_bytes() for p in tmp_path.rglob("*") if p.is_file() and own not in p.parents}


@pytest.mark.parametrize("target", ["/dev/zero", "pipe"])
@pytest.mark.parametrize("name", ["campaign.yaml", "runs/0001.dat"])
def test_a_campaign_of_devices_is_not_waited_for(campaign, tmp_path, name, target, limited):
    if target == "pipe":
        os.mkfifo(tmp_path / "pipe")
        target = tmp_path / "pipe"
    (campaign / name).unlink()
    (campaign / name).symlink_to(target)
    with limited():
        if name == "campaign.yaml":
            with pytest.raises(DataError, match=r"campaign\.yaml: .*(regular|outside)"):
                workflow.analyze(campaign)
        else:
            first = workflow.analyze(campaign).runs[0]
            assert re.match(r"(missing|unreadable): .*runs/0001\.dat", first.reasons[0])


@pytest.mark.parametrize(
    "run",
    ["../0001", "/etc/passwd", "..", ".hidden", "a/b", "a\\b", "C:x", "0001\x00", "", "x" * 200],
)
def test_a_run_can_not_be_named_like_a_path(campaign, logs, run):
    def change(content):
        content["runs"][0]["run"] = run

    edit(campaign, change)
    with pytest.raises(DataError, match=r"campaign\.yaml"):
        workflow.report(campaign)
    rows = list(csv.reader(io.StringIO((logs / "runs.csv").read_text())))
    rows[1][0] = run
    text = io.StringIO()
    csv.writer(text).writerows(rows)
    (logs / "runs.csv").write_text(text.getvalue())
    with pytest.raises(DataError, match=r"runs\.csv: line 2"):
        workflow.import_runs(logs, logs.parent / "out", None, lambda: AT)
    assert not (logs.parent / "out" / "campaign.yaml").exists()


def test_a_log_that_is_a_link_to_elsewhere_is_not_read(campaign, tmp_path):
    secret = tmp_path / "secret.dat"
    shutil.copy(campaign / "runs" / "0001.dat", secret)
    (campaign / "runs" / "0001.dat").unlink()
    (campaign / "runs" / "0001.dat").symlink_to(secret)
    first = workflow.analyze(campaign).runs[0]
    assert "0001.dat: " in first.reasons[0] and not first.accepted
    assert not first.reasons[0].endswith(": runs/0001.dat")  # there, and refused
    (campaign / "runs" / "0001.dat").unlink()
    (campaign / "runs" / "0001~1.dat").symlink_to(secret)  # as an earlier attempt's
    assert "missing" in workflow.analyze(campaign).runs[0].reasons[0]


@pytest.mark.parametrize("name", ["results", "results/figures"])
def test_results_that_are_a_link_to_elsewhere_are_not_written(campaign, tmp_path, name):
    target = tmp_path / "precious"
    target.mkdir()
    (campaign / "results").mkdir()
    if name == "results":
        (campaign / "results").rmdir()
    (campaign / name).symlink_to(target)
    with pytest.raises(DataError, match=rf"{name}\b.*: "):
        workflow.report(campaign)
    assert not list(target.iterdir())


def test_a_file_that_is_a_link_is_replaced_and_not_written_through(campaign, tmp_path):
    precious = tmp_path / "precious"
    precious.write_text("mine")
    (campaign / "results").mkdir()
    for name in ("report.html", ".report.html.part", ".runs.csv.part"):
        (campaign / "results" / name).symlink_to(precious)
    workflow.report(campaign)
    assert precious.read_text() == "mine"
    assert not (campaign / "results" / "report.html").is_symlink()


@pytest.mark.parametrize("name", ["campaign.yaml", "runs"])
def test_a_campaign_with_links_to_elsewhere_is_not_resumed(
    on_the_rig, short_schedule, tmp_path, name
):
    def interrupt(progress):
        if progress.runs_done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        on_the_rig(short_schedule(), tmp_path / "campaign", report=interrupt)
    (tmp_path / "campaign" / name).rename(tmp_path / "elsewhere")
    (tmp_path / "campaign" / name).symlink_to(tmp_path / "elsewhere")
    before = outside(tmp_path)
    with pytest.raises(DataError, match=rf"{name}\b.*: "):
        on_the_rig(short_schedule(), tmp_path / "campaign", resume=True)
    assert outside(tmp_path) == before


@pytest.mark.parametrize("file", ["../secret.csv", "/etc/passwd", "link.csv", "a\x00b", "x" * 5000])
def test_an_imported_index_names_no_file_elsewhere(logs, file):
    (logs.parent / "secret.csv").write_text("t_s,x_m\n0,0\n1,1\n")
    (logs / "link.csv").symlink_to(logs.parent / "secret.csv")
    (logs / "runs.csv").write_text(f"run,file,v_ref_m_s\nr1,{file},0.1\n")
    with pytest.raises(DataError):
        workflow.import_runs(logs, logs.parent / "out", None, lambda: AT)
    assert not (logs.parent / "out").exists()


@pytest.mark.parametrize("files", ["../secret_{trial}.txt", "/etc/passwd", "link_{trial}.txt"])
def test_an_import_map_names_no_file_elsewhere(tmp_path, files):
    folder = tmp_path / "logs"
    folder.mkdir()
    (tmp_path / "secret_1.txt").write_text("0 0\n1 1\n")
    (folder / "link_1.txt").symlink_to(tmp_path / "secret_1.txt")
    rules = yaml.safe_load((ROOT / "configs" / "tudelft.yaml").read_text())
    rules["series"] = [{**rules["series"][0], "files": files}]
    (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
    with pytest.raises((ConfigError, DataError), match="secret_1|link_1|passwd|series"):
        workflow.import_runs(folder, tmp_path / "out", tmp_path / "map.yaml", lambda: AT)
    assert not (tmp_path / "out").exists()


def test_file_names_in_a_campaign_s_header_are_told_and_never_opened(campaign, tmp_path, limited):
    traps = []
    for key in ("bench", "schedule"):
        traps.append(tmp_path / f"{key}-trap")
        os.mkfifo(traps[-1])  # to open it would hang

    def change(content):
        content["bench"]["file"] = str(traps[0])
        content["schedule"]["file"] = "../schedule-trap"
        content["schedule"]["content"]["bench"] = str(traps[0])

    edit(campaign, change)
    with limited():
        assert len(workflow.analyze(campaign).runs) > 1


def test_a_schedule_s_bench_must_be_a_bench_and_its_words_do_not_come_out(tmp_path):
    """A schedule may name a bench file elsewhere; what else there is gives nothing away."""
    (tmp_path / "secret").write_text("-----BEGIN PRIVATE KEY-----\nc2VjcmV0\n")
    schedule = yaml.safe_load((ROOT / "configs" / "demo.yaml").read_text())
    schedule["bench"] = "secret"
    (tmp_path / "schedule.yaml").write_text(yaml.safe_dump(schedule))
    with pytest.raises(ConfigError) as error:
        workflow.load_experiment(tmp_path / "schedule.yaml", None)
    assert "c2VjcmV0" not in error.value.message


def test_a_bench_s_programmer_is_run_by_flash_alone(campaign, tmp_path, on_the_rig, quick_schedule):
    marker = tmp_path / "ran"
    command = {"command": ["touch", str(marker), "{image}"], "timeout": "5 s"}
    edit(campaign, lambda content: content["bench"]["content"].update(programmer=command))
    workflow.report(campaign)
    schedule = quick_schedule()
    bench = yaml.safe_load((tmp_path / "bench.yaml").read_text())
    (tmp_path / "bench.yaml").write_text(yaml.safe_dump(bench | {"programmer": command}))
    on_the_rig(schedule, tmp_path / "made")
    assert not marker.exists()


def test_an_endless_firmware_image_is_not_read(limited):
    with limited(), pytest.raises(ConfigError, match="/dev/zero: .*regular"):
        workflow.load_image(Path("/dev/zero"))
