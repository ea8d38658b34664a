"""After a power cut at any moment of a measurement, ``--resume`` completes the campaign.

The system calls of a campaign are recorded. Each prefix of them is turned into the folders that a
power cut may leave (``tests/support/faults/power_cut.py``), and each is resumed.
"""

import shutil
from collections import Counter

import pytest

from hbench.errors import DataError
from hbench.store.campaign.checksums import sha256
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.watching import live
from tests.support.faults.power_cut import Trace, leftovers, write_tree
from tests.support.rig_campaign import measure_on_rig

NAME = "new/campaign"  # both folders are made


@pytest.fixture
def measure(quick_experiment, clock, monkeypatch):
    monkeypatch.setattr(live, "EVERY_S", 1e9)

    def run(folder, report=lambda progress: None):
        return measure_on_rig(
            quick_experiment,
            folder,
            resume=(folder / "campaign.yaml").exists(),
            clock=clock,
            report=report,
        )

    return run


@pytest.fixture
def traced(measure, tmp_path):
    """Function that makes a campaign; its calls, and the runs that were done after each of them."""

    def make(before):
        root = tmp_path / "traced"
        write_tree(root, before)
        trace, reported = Trace(root), {}

        def report(progress):
            reported[len(trace.calls)] = progress.runs_done

        with trace.recording():
            measure(root / NAME, report)
        shutil.rmtree(root)
        return trace.calls, reported

    return make


def check_and_resume(measure, root, runs, done):
    """The runs done before the cut are there, and only the others are made."""
    folder = root / NAME
    before = {}
    if (folder / "campaign.yaml").exists():
        campaign = load_campaign(folder)
        assert not campaign.damaged(), "a stop part was durable before its log"
        before = {e.plan.run: e.stop.sha256 for e in campaign.latest if e.plan.run in campaign.done}
    assert len(before) >= done, "a run that was reported as done is lost"
    logs = {sha256(path.read_bytes()) for path in folder.glob("runs/*.dat")}
    made = measure(folder).runs
    assert made == runs - len(before)
    campaign = load_campaign(folder)
    assert len(campaign.done) == runs and not campaign.damaged()
    after = {e.plan.run: e.stop.sha256 for e in campaign.latest}
    assert after.items() >= before.items()
    assert {sha256(path.read_bytes()) for path in folder.glob("runs/*.dat")} >= logs
    assert not any("edited" in warning for warning in campaign.warnings)


def cut_everywhere(measure, traced, tmp_path, before, runs, every=1):
    calls, reported = traced(before)
    outcomes = Counter()
    for made, kind, tree in leftovers(before, calls)[::-every]:  # the last one too
        done = max((n for at, n in reported.items() if at <= made), default=0)
        root = tmp_path / "cut"
        write_tree(root, tree)
        try:
            check_and_resume(measure, root, runs, done)
        except (AssertionError, DataError) as error:
            error.add_note(f"{kind}, after {made} of {len(calls)}: {calls[made - 1 : made]}")
            raise
        outcomes[kind] += 1
        shutil.rmtree(root)
    print(f"\n{len(calls)} calls, {sum(outcomes.values())} folders resumed: {dict(outcomes)}")


def test_a_power_cut_costs_no_run_that_was_done(measure, traced, tmp_path, quick_experiment):
    cut_everywhere(measure, traced, tmp_path, {}, len(quick_experiment.plans), every=10)


@pytest.mark.slow
def test_a_power_cut_at_every_call_costs_no_run_that_was_done(
    measure, traced, tmp_path, quick_experiment
):
    cut_everywhere(measure, traced, tmp_path, {}, len(quick_experiment.plans))


@pytest.mark.slow
def test_a_second_power_cut_while_an_interrupted_campaign_is_resumed(
    measure, tmp_path, traced, quick_experiment
):
    calls, _ = traced({})
    for made in (len(calls) // 3, len(calls) // 2):
        before = [tree for at, _, tree in leftovers({}, calls) if at == made][-1]
        cut_everywhere(measure, traced, tmp_path, before, len(quick_experiment.plans))
