"""``analyze`` of a quarter of the 360-run campaign, against plain pandas and lmfit."""

import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from hbench import workflow
from hbench.store.campaign.folder import load_campaign
from hbench.workflow.fleet import FleetTask, analyzed
from tests.support.analysis.plain_analysis import intervals_and_held_out_errors, plain_pipeline
from tests.support.benchmarks import CLEAR, best_seconds
from tests.support.rig_campaign import measure_on_rig

CONFIGS = Path(__file__).parents[2] / "configs"
LOADS = 1  # of four: 90 runs
ROUNDS = 10
MOST, MOST_WITH_FITS = 0.6, 0.4  # of the plain pipeline's time, and of that with the same fits


def clear(ours, plain, more=np.inf):
    return ours < CLEAR * min(MOST * plain, MOST_WITH_FITS * (plain + more))


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    folder = tmp_path_factory.mktemp("speed") / "campaign"
    schedule = yaml.safe_load((CONFIGS / "stribeck.yaml").read_text())
    schedule["experiments"] = schedule["experiments"][1:-1]  # without its zero checks
    for one in schedule["experiments"]:
        one["loads"] = one["loads"][:LOADS]
    (folder.parent / "part.yaml").write_text(yaml.safe_dump(schedule))
    measure_on_rig(
        workflow.load_experiment(folder.parent / "part.yaml", CONFIGS / "bench-aau.yaml"), folder
    )
    return folder


@pytest.mark.filterwarnings("ignore:Bound reached:UserWarning", "ignore:rel_change:UserWarning")
def test_analyze_is_faster_than_a_plain_pipeline_and_finds_the_same_friction(campaign):
    """CPU time, without start-up; ``analyze`` also screens, and has the budget of uncertainty.

    The same fits have the intervals and the held-out errors of ``analyze``'s.
    """
    results, points = workflow.analyze(campaign), plain_pipeline(campaign)
    fits = intervals_and_held_out_errors(points)
    ours, plain, more = best_seconds(
        lambda: workflow.analyze(campaign),
        lambda: plain_pipeline(campaign),
        lambda: intervals_and_held_out_errors(points),
        rounds=ROUNDS,
        clear=clear,
    )
    same = plain + more
    print(f"\nanalyze {ours:.2f} s, plain pandas and lmfit {plain:.2f} s: {plain / ours:.2f} times")
    print(f"pandas and lmfit with the same fits {same:.2f} s: {same / ours:.2f} times")
    found = [point.friction_n for curve in results.curves for point in curve.points]
    np.testing.assert_allclose(np.sort(found), np.sort(points.friction), atol=5.0)
    assert len(fits) == sum(len(curve.fits) for curve in results.curves)
    assert ours < MOST * plain
    assert ours < MOST_WITH_FITS * same


def test_a_campaign_of_a_fleet_takes_less_time_than_a_plain_pipeline(campaign):
    """CPU time of one more campaign, in a process that has started."""
    task = FleetTask(str(campaign), None)
    assert not analyzed(task).row.failed
    ours, plain = best_seconds(
        lambda: analyzed(task), lambda: plain_pipeline(campaign), rounds=ROUNDS, clear=clear
    )
    print(f"\na campaign of a fleet {ours:.2f} s, plain pandas and lmfit {plain:.2f} s")
    assert ours < MOST * plain


def test_memory_does_not_grow_with_the_number_of_runs(campaign):
    """Peak of a quarter of the runs and of all: the samples would be 3.5 MB more."""
    whole = load_campaign(campaign)
    peaks = []
    for part in (whole.entries[: len(whole.entries) // 4], whole.entries):
        tracemalloc.start()
        workflow.results.derive(replace(whole, entries=part))
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    print(f"\npeak {peaks[0] / 1e6:.1f} MB of 22 runs, {peaks[1] / 1e6:.1f} MB of 90")
    assert peaks[1] - peaks[0] < 1.2e6
