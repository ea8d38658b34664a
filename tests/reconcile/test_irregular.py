"""A fault that no run repeats raises the scatter of the trials, by which a gap is judged."""

from dataclasses import replace

import numpy as np
import pytest

from hbench.config.files.loading import read_yaml
from hbench.reconcile.diagnose import diagnose
from hbench.reconcile.gaps.log_map import unexplained_gaps
from hbench.records import Gap
from hbench.report.diagnosis.verdict import verdict_words
from tests.support import ROOT
from tests.support.reconcile.blind import MODEL, task_of

NONE = ROOT / "data_samples" / "blind" / "none-5"


def sticking(run, rng):
    """Return a run in which the test valve's spool is off its command by up to 0.3 V.

    By another voltage every 0.2 to 0.6 s, so in no run at the same moments.
    """
    jumps = run.t_s[0] + np.cumsum(rng.uniform(0.2, 0.6, 200))
    off = rng.uniform(-0.3, 0.3, 201)[np.searchsorted(jumps, run.t_s)]
    return replace(run, u_t_v=run.u_t_v + off)


@pytest.fixture(scope="module")
def found():
    task, rng = task_of(NONE), np.random.default_rng(3)
    runs = tuple(sticking(run, rng) for run in task.runs)
    return diagnose(replace(task, bench=None, runs=runs, plant_data=read_yaml(MODEL)))


@pytest.mark.slow
def test_a_spool_that_sticks_is_unknown_and_not_nothing(found):
    assert found.verdict == "unknown"
    assert {gap.name for gap in found.rest} == {"flow_tp", "flow_tr"}
    assert all(gap.p_value > 0.01 and gap.deviation > 3 * gap.material for gap in found.rest)


@pytest.mark.slow
def test_the_page_tells_that_the_runs_differ_and_asks_for_no_more_steady_ones(found):
    words = verdict_words(found)
    assert "The deviations differ between runs of the same plan" in words
    assert "First inspect the test valve" in words
    assert "steady runs" not in words


@pytest.mark.parametrize(
    ("name", "limits", "expected"),
    [("flow_lr", 3.1, 1), ("flow_lr", 2.9, 0), ("force_test", 5.0, 0), ("supply", 5.0, 0)],
)
def test_friction_may_differ_from_run_to_run_and_a_flow_may_not(name, limits, expected):
    gap = Gap(name, 1.2, 0.7, 1.0, 100, deviation=limits, material=1.0)
    assert len(unexplained_gaps([gap])) == expected
