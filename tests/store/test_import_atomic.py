"""An import writes a whole campaign or nothing."""

import shutil

import pytest
import yaml

from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.lock_file import campaign_lock
from hbench.store.importing.importer import import_folder
from tests.support.faults.power_cut import Trace, leftovers, write_tree

LOG = "t_s,x_m,p_tp_pa\n" + "".join(f"{n / 100},{n / 1000},5e5\n" for n in range(100))


@pytest.fixture
def bring_in(tmp_path, at):
    """Return a function that imports three logs to a folder; the last two can be spoilt."""

    def bring_in(folder, last=LOG):
        logs = tmp_path / "logs"
        logs.mkdir(exist_ok=True)
        for number, text in enumerate((LOG, last, last)):
            (logs / f"{number}.csv").write_text(text)
        rules = {
            "name": "whole",
            "columns": {name: {"column": name} for name in ("t_s", "x_m", "p_tp_pa")},
            "series": [
                {"label": "", "files": "{load}.csv", "cylinder": {"piston_diameter": "40 mm"}}
            ],
        }
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        import_folder(logs, folder, tmp_path / "map.yaml", {}, at(0))

    return bring_in


def below(folder):
    return sorted(path.relative_to(folder).as_posix() for path in folder.rglob("*"))


SPOILT = LOG.replace("0.5,", "?,")


def test_a_failed_import_leaves_no_folder(bring_in, tmp_path):
    with pytest.raises(DataError, match=r"1\.csv: line 52"):
        bring_in(tmp_path / "new" / "out", SPOILT)
    assert not (tmp_path / "new").exists()


def test_a_failed_import_leaves_a_folder_as_it_was(bring_in, tmp_path):
    (tmp_path / "out" / "runs").mkdir(parents=True)
    (tmp_path / "out" / "runs" / "0001.csv").write_text("mine")
    with pytest.raises(DataError):
        bring_in(tmp_path / "out", SPOILT)
    assert below(tmp_path / "out") == ["runs", "runs/0001.csv"]
    assert (tmp_path / "out" / "runs" / "0001.csv").read_text() == "mine"


def test_what_a_killed_import_left_is_removed(bring_in, tmp_path):
    (tmp_path / "out" / ".runs.part").mkdir(parents=True)
    (tmp_path / "out" / ".runs.part" / "0009.csv").write_text("half")
    bring_in(tmp_path / "out")
    runs = [f"runs/000{number}.csv" for number in (1, 2, 3)]
    assert below(tmp_path / "out") == ["campaign.yaml", "runs", *runs]
    assert len(list(load_campaign(tmp_path / "out").runs())) == 3


def test_a_second_import_to_the_same_folder_is_refused_while_the_first_writes(bring_in, tmp_path):
    with campaign_lock(tmp_path / "out"):
        with pytest.raises(ConfigError, match="out: another hbench is writing this campaign"):
            bring_in(tmp_path / "out")
    bring_in(tmp_path / "out")
    assert len(list(load_campaign(tmp_path / "out").runs())) == 3


def test_a_file_in_the_place_of_the_campaign_is_refused(bring_in, tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(ConfigError, match="out: is a file"):
        bring_in(tmp_path / "out")


@pytest.mark.parametrize("name", ["runs", ".runs.part"])
def test_nothing_is_written_or_removed_through_a_link(bring_in, tmp_path, name):
    precious = tmp_path / "precious"
    precious.mkdir()
    (precious / "0001.csv").write_text("mine")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).symlink_to(precious)
    with pytest.raises(DataError, match=name):
        bring_in(tmp_path / "out")
    assert (precious / "0001.csv").read_text() == "mine" and below(precious) == ["0001.csv"]


def test_a_power_cut_during_an_import_leaves_the_logs_and_a_whole_campaign_or_none(
    bring_in, tmp_path
):
    """At each system call. The same command then imports what it had not."""
    root = tmp_path / "root"
    trace = Trace(root)
    root.mkdir()
    with trace.recording():
        bring_in(root / "new" / "out")
    cuts = leftovers({}, trace.calls)
    assert len(cuts) > 20
    for _, _, tree in cuts:
        shutil.rmtree(root)
        write_tree(root, tree)
        if not (root / "new" / "out" / "campaign.yaml").exists():
            bring_in(root / "new" / "out")
        campaign = load_campaign(root / "new" / "out")
        assert len(campaign.done) == 3 and not campaign.damaged()
    assert (root / "new" / "out" / "campaign.yaml").exists()
