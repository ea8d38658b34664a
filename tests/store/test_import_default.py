"""Import of the default layout: runs.csv and one CSV a run, in SI."""

import hashlib
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench.errors import ConfigError, DataError
from hbench.store.campaign.folder import load_campaign
from hbench.store.importing.importer import import_folder

CONFIGS = Path(__file__).parents[2] / "configs"
HEAD = "t_s,x_m,p_tp_pa,p_tr_pa,f_applied_n\n"
ROWS = "0,0.1,5e6,1e6,3000\n0.01,0.10003,5.1e6,1e6,3001\n0.023,0.1005,5.2e6,1e6,3002.123456789\n"
INDEX = "run,file,kind,trial,v_ref_m_s,a_ref_m_s2,f_load_n,p_lr_ref_pa\n"


@pytest.fixture
def source(tmp_path):
    folder = tmp_path / "logs"
    (folder / "sub").mkdir(parents=True)
    (folder / "a.csv").write_text(HEAD + ROWS)
    (folder / "sub" / "b.csv").write_text("t_s,x_m,v_ref_m_s\n0,0.3,0\n0.1,0.2,-0.05\n")
    (folder / "runs.csv").write_text(
        INDEX + "A-1,a.csv,steady,1,0.03,1,500,1.5e6\nB.2,sub/b.csv,,,-0.05,,,\n"
    )
    return folder


@pytest.fixture
def bring_in(source, tmp_path, at):
    def bring_in():
        summary = import_folder(source, tmp_path / "out", None, {"hbench": "0.1.0"}, at(0))
        return summary, load_campaign(tmp_path / "out")

    return bring_in


def test_runs_come_in_with_their_references_and_every_digit(bring_in):
    summary, campaign = bring_in()
    assert (summary.runs, summary.files) == (2, 2)
    assert campaign.imported
    first, second = campaign.runs()
    plan = first.plan
    assert (plan.run, plan.kind, plan.trial, plan.direction) == ("A-1", "steady", 1, "extend")
    assert (plan.v_ref_m_s, plan.a_ref_m_s2) == (0.03, 1.0)
    assert (plan.f_load_n, plan.p_lr_ref_pa) == (500.0, 1.5e6)
    assert first.t_s.tolist() == [0, 0.01, 0.023]  # uneven times are kept
    assert first.f_applied_n.tolist() == [3000, 3001, 3002.123456789]
    assert first.p_lp_pa is None and first.at_reference is None
    assert second.plan.direction == "retract"
    assert second.plan.f_load_n is None
    assert second.at_reference.tolist() == [False, True]
    assert (first.truncated, second.truncated) == ("", "")


def test_journal_says_where_each_run_comes_from(bring_in, source):
    _, campaign = bring_in()
    origin = campaign.entries[1].origin
    assert origin["file"] == "sub/b.csv"
    assert origin["lines"] == [2, 3]
    assert origin["sha256"] == hashlib.sha256((source / "sub/b.csv").read_bytes()).hexdigest()
    assert campaign.provenance().source == "imported"


def test_cylinder_comes_from_the_bench_file(bring_in, source):
    text = (CONFIGS / "bench-aau.yaml").read_text()
    text = text.replace("piston_diameter: 40 mm", "piston_diameter: 50 mm", 1)
    (source / "bench.yaml").write_text(text)
    summary, campaign = bring_in()
    specimen = campaign.plans[0].specimen
    assert specimen.area_piston_m2 == pytest.approx(np.pi / 4 * 0.05**2)
    assert specimen.area_rod_m2 == pytest.approx(np.pi / 4 * (0.05**2 - 0.025**2))
    assert campaign.bench().name == yaml.safe_load(text)["name"]
    assert summary.notes == ()


def test_without_bench_file_the_reference_cylinder_is_taken_and_said_so(bring_in):
    summary, campaign = bring_in()
    assert campaign.plans[0].specimen.area_piston_m2 == pytest.approx(np.pi / 4 * 0.04**2, rel=1e-5)
    assert "bench.yaml" in summary.notes[0] and "40 mm piston" in summary.notes[0]
    assert campaign.warnings == summary.notes


def test_same_file_twice_is_noticed(bring_in, source):
    (source / "sub" / "b.csv").write_bytes((source / "a.csv").read_bytes())
    summary, _ = bring_in()
    assert any("sub/b.csv" in note and " a.csv" in note for note in summary.notes)


def test_unknown_columns_are_left_out_and_said_so(bring_in, source):
    (source / "a.csv").write_text("t_s,x_m,oil_temperature\n0,0.1,40\n0.1,0.2,\n")
    summary, campaign = bring_in()
    assert any(re.match("a.csv: .*: oil_temperature$", note) for note in summary.notes)


def test_missing_values_are_kept_as_such(bring_in, source):
    (source / "a.csv").write_text(HEAD + "0,0.1,5e6,,3000\n0.01,0.11,nan,1e6,3000\n")
    run = next(iter(bring_in()[1].runs()))
    assert np.isnan(run.p_tr_pa).tolist() == [True, False]
    assert np.isnan(run.p_tp_pa).tolist() == [False, True]


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("a.csv", HEAD + "0,0.1,5e6,1e6,3000\n0.01,0.1,x,1e6,3000\n", r"a.csv: line 3: .*'x'"),
        (
            "a.csv",
            HEAD + "0,0.1,5e6,1e6,3000\n0.01,0.1\n",
            r"a.csv: line 3: .*fewer.* 5",
        ),
        ("a.csv", HEAD + "0,,5e6,1e6,3000\n", r"a.csv: line 2: column x_m: found ''"),
        ("a.csv", HEAD + "0,inf,5e6,1e6,3000\n", r"a.csv: line 2: column x_m: found 'inf'"),
        ("a.csv", HEAD + ROWS + "0.02,0,0,0,0\n", r"a.csv: line 5: time goes from 0.023 s to 0.02"),
        ("a.csv", HEAD + ROWS + "0.023,0,0,0,0\n", r"a.csv: line 5: time goes from 0.023 s"),
        ("a.csv", HEAD, r"a.csv: no rows of data below the first line$"),
        ("a.csv", "", r"a.csv: no rows of data$"),
        ("a.csv", "t_s,p_tp_pa\n0,1\n", r"a.csv: .*'x_m'.*: t_s, p_tp_pa"),
        ("runs.csv", "run,file\nA,a.csv\n", r"runs.csv: .*'v_ref_m_s'"),
        ("runs.csv", INDEX + "A,a.csv,steady,1,0.1,,,\nB,b.csv\n", r"runs.csv: line 3: .* 8"),
        ("runs.csv", INDEX + "A,c.csv,steady,1,0.1,,,\n", r"c.csv: "),
        ("runs.csv", INDEX + "A,../../etc,steady,1,0.1,,,\n", r"logs/../../etc: "),
        ("runs.csv", INDEX + "A,/etc/passwd,steady,1,0.1,,,\n", r"/etc/passwd: "),
        ("runs.csv", INDEX + "../A,a.csv,steady,1,0.1,,,\n", r"line 2: run '../A' "),
        ("runs.csv", INDEX + "A,a.csv,creep,1,0.1,,,\n", r"line 2: kind 'creep': .*steady"),
        ("runs.csv", INDEX + "A,a.csv,steady,0,0.1,,,\n", r"line 2: trial '0': .* 1 "),
        ("runs.csv", INDEX + "A,a.csv,steady,1,,,,\n", r"line 2: v_ref_m_s '': "),
        ("runs.csv", INDEX + "A,a\0b,steady,1,0.1,,,\n", r"a\\x00b"),
        ("runs.csv", INDEX + f"A,{'a' * 5000},steady,1,0.1,,,\n", r"aaaa"),
        (
            "runs.csv",
            INDEX + "A,a.csv,steady,1,1e300,,,\n",
            r"line 2: v_ref_m_s '1e300': .* to 1000",
        ),
        ("runs.csv", INDEX + f"A,a.csv,steady,{'9' * 5000},1,,,\n", r"line 2: trial '9{60}':"),
        ("runs.csv", INDEX[:-1] + ",f_load_n\nA,a.csv,,,1,,5,,7\n", r"'f_load_n' .*\b2 "),
        ("a.csv", HEAD + ROWS + '"' + "1," * 100_000, r"a.csv: after line 4: "),
        ("a.csv", HEAD + "0,0.1,1e300,1e6,3000\n", r"a.csv: line 2: p_tp_pa .*1e.300 Pa"),
        ("a.csv", HEAD + ROWS + "1e9,0,0,0,0\n", r"a.csv: .*1e.09 s.* 1e.06 s"),
        ("runs.csv", INDEX + "A,a.csv,,,1,,,\nA,a.csv,,,1,,,\n", r"line 3: run 'A': .* line 2\b"),
    ],
)
def test_what_cannot_be_read_is_refused_and_nothing_is_left(
    bring_in, source, tmp_path, name, text, message
):
    (source / name).write_text(text)
    with pytest.raises(DataError, match=message):
        bring_in()
    assert not (tmp_path / "out").exists()


def test_campaign_is_not_imported_over(bring_in):
    bring_in()
    with pytest.raises(ConfigError, match="out: contains a campaign") as caught:
        bring_in()
    assert "-o" in caught.value.hint and "--resume" not in caught.value.hint


def test_missing_folder_is_named(tmp_path, at):
    with pytest.raises(ConfigError, match="nowhere: "):
        import_folder(tmp_path / "nowhere", tmp_path / "out", None, {}, at(0))
    (tmp_path / "log.csv").write_text("t_s,x_m\n")
    with pytest.raises(ConfigError, match=r"log.csv: "):
        import_folder(tmp_path / "log.csv", tmp_path / "out", None, {}, at(0))


@pytest.mark.parametrize(
    ("damage", "told"),
    [
        (lambda path: path.unlink(), "missing: runs/A-1.csv "),
        (lambda path: path.write_text("t_s,x_m\n0,oops\n"), "unreadable: runs/A-1.csv: line 2"),
        (lambda path: path.write_text("t_s,x_m\n0,1\n"), "changed: runs/A-1.csv "),
    ],
)
def test_damaged_run_says_so_and_spares_the_others(bring_in, tmp_path, damage, told):
    _, campaign = bring_in()
    damage(tmp_path / "out" / "runs" / "A-1.csv")
    first, second = campaign.runs()
    assert told in first.truncated
    assert second.truncated == ""


def test_a_log_that_the_index_lacks_is_told(bring_in, source):
    (source / "runs.csv").write_text(INDEX + "A-1,a.csv,steady,1,0.03,1,500,1.5e6\n")
    (source / "c.csv").write_text(HEAD + ROWS)
    assert any(re.match(r"runs.csv: .*\bc\.csv.*\(1 file\)", n) for n in bring_in()[0].notes)


def test_a_last_line_without_end_is_told_since_its_number_may_be_cut(bring_in, source):
    (source / "a.csv").write_text(HEAD + ROWS[:-5])
    assert any(re.search(r"\ba\.csv: .*\(1 file\)", note) for note in bring_in()[0].notes)
