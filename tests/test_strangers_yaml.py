"""YAML from strangers: schedules, benches, plants, fits, maps and campaigns.

It runs no code, takes no more memory and time than others, and names no device as its file.
"""

import os
from datetime import UTC, datetime
from pathlib import Path

import pytest
import yaml

from hbench import workflow
from hbench.config.files.yaml_text import DEEPEST, MOST_REPEATED
from hbench.errors import ConfigError, HbenchError

ROOT = Path(__file__).parents[1]
SAMPLE = ROOT / "data_samples" / "bad-runs"
AT = datetime(2026, 1, 1, tzinfo=UTC)


# What reads YAML that others write: each takes the path of such a file.
def _schedule(path):
    workflow.load_experiment(path, None)


def _bench(path):
    workflow.load_experiment(ROOT / "configs" / "demo.yaml", path)


def _plant(path):
    workflow.serve_rig(
        ROOT / "configs" / "bench-aau.yaml", plant=path, seed=1, image=None, address=None,
        full_speed=True, announce=lambda name: pytest.fail("the rig was served"),
    )  # fmt: skip


def _fit(path):
    workflow.analyze(SAMPLE, path)


def _map(path):
    workflow.import_runs(path.parent, path.parent / "out", path, lambda: AT)


def _bench_beside_logs(path):
    folder = path.parent / "logs"
    folder.mkdir()
    (folder / "runs.csv").write_text("run,file,v_ref_m_s\n1,a.csv,0.1\n")
    os.link(path, folder / "bench.yaml")
    workflow.import_runs(folder, path.parent / "out", None, lambda: AT)


def _journal(path):
    folder = path.parent / "campaign"
    folder.mkdir()
    os.link(path, folder / "campaign.yaml")
    workflow.analyze(folder)


READERS = (_schedule, _bench, _plant, _fit, _map, _bench_beside_logs, _journal)
LAUGHS = "a0: &a0 [lol, lol]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]\n" for n in range(1, 12)
)
MERGED = "a0: &a0 {k: v}\n" + "".join(
    f"a{n}: &a{n} {{<<: [{', '.join([f'*a{n - 1}'] * 10)}]}}\n" for n in range(1, 12)
)


@pytest.mark.parametrize("read", READERS, ids=lambda read: read.__name__.strip("_"))
def test_yaml_runs_no_code(read, tmp_path):
    marker, path = tmp_path / "ran", tmp_path / "file.yaml"
    path.write_text(f"name: !!python/object/apply:os.system ['touch {marker}']\n")
    with pytest.raises(HbenchError, match="python/object/apply"):
        read(path)
    assert not marker.exists()


@pytest.mark.parametrize("read", READERS, ids=lambda read: read.__name__.strip("_"))
@pytest.mark.parametrize(
    ("text", "words"),
    [
        (LAUGHS, rf"aliases.*\b{MOST_REPEATED}\b"),
        (MERGED, rf"aliases.*\b{MOST_REPEATED}\b"),
        ("a: &a [*a]\n", r"alias \*a\b"),
        ("a: " + "[" * 5000, rf"nest.*\b{DEEPEST}\b"),
        ("a: " + ":".join(["59"] * 100_000), r"unknown key|it has|no schema"),
        ("a: 0x" + "f" * 100_000, r"\bint\b"),
        ("a: " + "9" * 100_000 + ".5", r"\bfloat\b"),
        ('name: "\\e]0;owned\\a"', "control character"),
        ("a: x" + " " * 9_000_000, "MB"),
    ],
    ids="laughs merged itself deep sexagesimal hex digits escape large".split(),
)
def test_yaml_bombs_are_refused(read, tmp_path, text, words, limited):
    path = tmp_path / "file.yaml"
    path.write_text(text + "\nend: 1\n")
    with limited(), pytest.raises(HbenchError, match=words):
        read(path)


@pytest.mark.parametrize("kind", ["pipe", "zeros", "memory", "folder"])
@pytest.mark.parametrize("read", [_schedule, _bench, _fit, _map])
def test_what_is_no_regular_file_is_not_read(read, tmp_path, kind, limited):
    path = tmp_path / "file.yaml"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to({"zeros": "/dev/zero", "memory": "/proc/self/mem"}[kind])
    with limited(), pytest.raises(ConfigError, match=r"file\.yaml"):
        read(path)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"trials": 10**9}, "trials"),
        ({"loads": ["60 N"] * 20_000}, "loads"),
        ({"velocities": ["60 mm/s"] * 20_000}, "velocities"),
        ({"velocities": {"first": "5 mm/s", "last": "200 mm/s", "count": 10**9}}, "count"),
        ({"acceleration": "1e-300 m/s^2"}, "acceleration"),
        ({"hold": "1e300 s"}, "hold"),
        ({"velocities": ["1e-300 mm/s"]}, "velocities"),
    ],
    ids="trials loads velocities count acceleration hold slow".split(),
)
def test_absurd_numbers_in_a_schedule_are_refused_at_once(tmp_path, change, words, limited):
    schedule = yaml.safe_load((ROOT / "configs" / "demo.yaml").read_text())
    schedule["bench"] = str(ROOT / "configs" / "bench-aau.yaml")
    schedule["experiments"][0] |= change
    (tmp_path / "schedule.yaml").write_text(yaml.safe_dump(schedule))
    with limited(), pytest.raises(ConfigError, match=words):
        workflow.load_experiment(tmp_path / "schedule.yaml", None)
