from datetime import UTC, datetime, timedelta

import numpy as np
import pytest
import yaml

from hbench.records import Motion, RunPlan, Segment, Specimen
from hbench.store.campaign.folder import load_campaign
from hbench.store.formats import reading
from hbench.store.importing.importer import import_folder

CHANNELS = ("run", "index", "x")


def plan_of(run="0001", **changes):
    fields = {
        "kind": "steady",
        "trial": 1,
        "v_ref_m_s": 0.1 + 0.2,  # needs all of its digits
        "specimen": Specimen(1.25664e-3, 7.65763e-4, 0.4),
        "a_ref_m_s2": 1.0,
        "f_load_n": -500.0,
        "p_lr_ref_pa": 1.5e6,
        "motion": Motion(0.02, 0.02, 0.37, 0.5, (Segment(0.1 + 0.2, 1.0, 1e-5),)),
    }
    return RunPlan(run, **{**fields, **changes})


def time_at(seconds):
    return datetime(2024, 5, 1, 12, tzinfo=UTC) + timedelta(seconds=seconds)


class InThisProcess:
    """Stands in for the process of readers: without limits, and with what a test has changed."""

    is_running = True

    def call(self, function, *arguments):
        return function(*arguments)


@pytest.fixture(autouse=True)
def in_this_process(monkeypatch):
    """Call the readers of foreign files in this process, which saves the start of another one."""
    monkeypatch.setattr(reading, "_process", InThisProcess())


@pytest.fixture
def make_plan():
    return plan_of


@pytest.fixture
def at():
    """Turn seconds from the campaign's beginning into a time."""
    return time_at


@pytest.fixture
def header():
    """A campaign's header as the command that runs one writes it."""
    channel = {"signed": False, "scale": 1.0, "unit": "1"}
    return {
        "name": "test",
        "source": "simulated",
        "created": time_at(0).isoformat(),
        "software": {"hbench": "0.1.0"},
        "firmware": {"version": "core 1", "board": "host"},
        "port": "sim",
        "seed": 7,
        "log": {
            "rate_hz": 100.0,
            "flags": ["last"],
            "channels": [{"name": name, **channel} for name in CHANNELS],
        },
    }


@pytest.fixture
def words():
    return np.arange(12, dtype=np.uint16).reshape(4, 3)


@pytest.fixture
def rules():
    """An import map of one file a.*; a test adds the columns."""
    return {
        "name": "others",
        "columns": {},
        "constants": {"p_tr_pa": "0 bar"},
        "series": [{"label": "", "files": "a.csv", "cylinder": {"piston_diameter": "25 mm"}}],
    }


@pytest.fixture
def import_by(tmp_path, at):
    """Import the files in ``logs`` by ``rules``; return the runs and the notes."""

    def import_by(rules, logs=tmp_path):
        (tmp_path / "map.yaml").write_text(yaml.safe_dump(rules))
        summary = import_folder(logs, tmp_path / "out", tmp_path / "map.yaml", {}, at(0))
        return list(load_campaign(tmp_path / "out").runs()), summary.notes

    return import_by
