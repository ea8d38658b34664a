"""Trials in a row and as passes over the plan, and trials of an experiment listed twice."""

import itertools

import pytest
import yaml

from hbench import workflow
from hbench.errors import ConfigError


@pytest.fixture
def analyzed(tmp_path, clock, on_the_rig):
    """Run a schedule on the virtual rig; return the campaign and its results."""

    def run(schedule, folder):
        campaign = on_the_rig(schedule, tmp_path / folder, clock=clock)
        return campaign, workflow.analyze(tmp_path / folder)

    return run


def test_passes_give_the_same_curve_as_trials_in_a_row_within_the_rigs_scatter(
    analyzed, short_schedule
):
    speeds = ["60 mm/s", "90 mm/s", "120 mm/s"]
    row, row_results = analyzed(short_schedule(velocities=speeds, trials=3), "row")
    schedule = short_schedule(velocities=speeds, trials=3, order="passes")
    passes, results = analyzed(schedule, "passes")
    assert [plan.run for plan in passes.plans] == [f"{number:04d}" for number in range(1, 10)]
    assert [(plan.trial, plan.v_ref_m_s) for plan in passes.plans] == [
        (trial, speed) for trial in (1, 2, 3) for speed in (0.06, 0.09, 0.12)
    ]
    assert [(plan.trial, plan.v_ref_m_s) for plan in row.plans] == [
        (trial, speed) for speed in (0.06, 0.09, 0.12) for trial in (1, 2, 3)
    ]
    assert [entry.stop.outcome for entry in passes.entries] == ["done"] * 9
    (expected,), (curve,) = row_results.curves, results.curves
    scatter = 0.015 * (2 / 3) ** 0.5  # of the level (configs/bench-aau.yaml), of two means of 3
    for one, other in zip(curve.points, expected.points, strict=True):
        assert (one.n, one.trials) == (3, (1, 2, 3))
        assert one.friction_n == pytest.approx(other.friction_n, rel=3 * scatter)
        assert one.friction_n != other.friction_n  # other runs, not the same ones sorted


def test_an_experiment_listed_twice_adds_trials_to_the_same_points(analyzed, short_schedule):
    schedule = short_schedule()
    data = yaml.safe_load(schedule.read_text())
    data["experiments"] *= 2
    schedule.write_text(yaml.safe_dump(data))
    campaign, results = analyzed(schedule, "twice")
    assert [plan.trial for plan in campaign.plans] == [1, 2, 1, 2, 3, 4, 3, 4]
    (curve,) = results.curves
    assert [(point.trials, point.n) for point in curve.points] == [((1, 2, 3, 4), 4)] * 2


@pytest.fixture
def whole_plan(short_schedule):
    """Two directions with two trials each, as passes over both; four points."""
    schedule = short_schedule()
    data = yaml.safe_load(schedule.read_text())
    back = data["experiments"][0] | {
        "direction": "retract", "p_lr": "110 bar", "loads": ["-2000 N"]
    }  # fmt: skip
    schedule.write_text(
        yaml.safe_dump(data | {"order": "passes", "experiments": [*data["experiments"], back]})
    )
    return schedule


def points(results):
    return {
        (curve.direction, point.v_m_s > 0, point.n, point.trials)
        for curve in results.curves
        for point in curve.points
    }


def test_passes_over_the_whole_plan_are_averaged_by_point(analyzed, whole_plan):
    campaign, results = analyzed(whole_plan, "passes")
    assert [(plan.trial, plan.direction) for plan in campaign.plans] == [
        (trial, way) for trial in (1, 2) for way in ("extend",) * 2 + ("retract",) * 2
    ]
    assert all(run.accepted for run in results.runs)
    assert [len(curve.points) for curve in results.curves] == [2, 2]
    assert points(results) == {("extend", True, 2, (1, 2)), ("retract", False, 2, (1, 2))}


def test_passes_over_the_whole_plan_interrupted_in_the_second_go_on_there(
    analyzed, whole_plan, tmp_path, clock, on_the_rig
):
    """Who watches sees the trials of a point, and what was made until then."""
    seen = []

    def interrupt(progress):
        seen.append((progress.plan.run, progress.plan.trial, progress.trials, progress.runs_total))
        if progress.runs_done == 5 and abs(progress.v_m_s) > 0.05:
            raise KeyboardInterrupt

    folder = tmp_path / "campaign"
    with pytest.raises(KeyboardInterrupt):
        on_the_rig(whole_plan, folder, clock=clock, report=interrupt)
    assert seen[-1] == ("0006", 2, 2, 8)
    watch = workflow.Watch(folder)
    assert watch.state()["state"] == "ended"
    assert [row["run"] for row in watch.runs()["runs"]] == [f"000{n}" for n in range(1, 7)]
    campaign = on_the_rig(whole_plan, folder, clock=clock, resume=True)
    assert [entry.plan.run for entry in campaign.entries] == [
        *("0001", "0002", "0003", "0004", "0005", "0006"), *("0006", "0007", "0008")
    ]  # fmt: skip
    results = workflow.analyze(folder)
    assert points(results) == {("extend", True, 2, (1, 2)), ("retract", False, 2, (1, 2))}


def test_a_random_order_interrupted_goes_on_with_the_same_plan(
    analyzed, whole_plan, tmp_path, clock, on_the_rig
):
    """The seed is in the campaign, also the default one; another seed is another schedule."""

    def interrupt(progress):
        if progress.runs_done == 5:
            raise KeyboardInterrupt

    data = yaml.safe_load(whole_plan.read_text()) | {"order": "random"}
    whole_plan.write_text(yaml.safe_dump(data))
    whole = on_the_rig(whole_plan, tmp_path / "whole", clock=clock)
    assert whole.header["schedule"]["content"]["seed"] == 1
    folder = tmp_path / "campaign"
    with pytest.raises(KeyboardInterrupt):
        on_the_rig(whole_plan, folder, clock=clock, report=interrupt)
    whole_plan.write_text(yaml.safe_dump(data | {"seed": 2}))
    with pytest.raises(ConfigError, match="schedule differs"):
        on_the_rig(whole_plan, folder, clock=clock, resume=True)
    whole_plan.write_text(yaml.safe_dump(data | {"seed": 1}))
    assert on_the_rig(whole_plan, folder, clock=clock, resume=True).plans == whole.plans
    results = workflow.analyze(folder)
    assert all(run.accepted for run in results.runs)
    assert points(results) == {("extend", True, 2, (1, 2)), ("retract", False, 2, (1, 2))}
    assert [curve.direction for curve in results.curves] == ["extend", "retract"]


def test_the_journal_of_the_virtual_rig_has_the_rigs_time(whole_plan, tmp_path, on_the_rig):
    """Also in a second session, which begins while time on the clock has hardly passed."""

    def interrupt(progress):
        if progress.runs_done == 5:
            raise KeyboardInterrupt

    folder = tmp_path / "campaign"
    with pytest.raises(KeyboardInterrupt):
        on_the_rig(whole_plan, folder, report=interrupt)
    campaign = on_the_rig(whole_plan, folder, resume=True)
    times = list(campaign.start_times_s().values())
    assert len(times) == 8 and times[0] == 0.0 and times == sorted(times)
    steps = [later - earlier for earlier, later in itertools.pairwise(times)]
    assert min(steps) > 0.8 and 1.5 < sum(steps) / 7 < 6.0  # of a run of 2 s, and its return


def test_a_rejected_run_of_a_pass_is_made_again_before_the_next_point(
    whole_plan, tmp_path, clock, on_the_rig
):
    """A limit of ripple that no run keeps: each is made twice."""
    data = yaml.safe_load(whole_plan.read_text())
    limits = {"speed_oscillation": "1e-6 m/s", "speed_oscillation_relative": 0}
    whole_plan.write_text(yaml.safe_dump(data | {"screening": limits}))
    campaign = on_the_rig(whole_plan, tmp_path / "campaign", clock=clock, retry=1)
    assert [entry.plan.run for entry in campaign.entries] == [
        f"000{number}" for number in range(1, 9) for _ in range(2)
    ]
    assert all(entry.after_rejection for entry in campaign.entries[1::2])
