"""Trials in a row and as passes over the plan, and trials of an experiment listed twice."""

import pytest
import yaml

from hbench import workflow


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
