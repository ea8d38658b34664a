"""A campaign whose plan grows while it runs: its bounds, its resume, the board in between."""

import pytest
import yaml

from hbench import workflow
from hbench.errors import ConfigError
from hbench.experiment import runner
from hbench.experiment.plan import plan_runs
from hbench.protocol.dictionary import STATES

ADAPTIVE = {
    "strategy": "adaptive",
    "first": "60 mm/s",
    "last": "130 mm/s",
    "min_step": "10 mm/s",
    "max_step": "30 mm/s",
    "tolerance": "5 N",
}


@pytest.fixture
def schedule(short_schedule):
    """The short schedule with adaptive velocities: at most eight speeds, two trials each."""
    return short_schedule(velocities=ADAPTIVE)


@pytest.fixture
def measure(tmp_path, clock, on_the_rig):
    """Run a schedule into a folder of ``tmp_path``; return the campaign."""

    def run(schedule, folder="campaign", **options):
        return on_the_rig(schedule, tmp_path / folder, clock=clock, **options)

    return run


def test_before_anything_is_measured_the_plan_tells_the_most_runs_that_there_can_be(schedule):
    experiment = workflow.load_experiment(schedule, None)
    assert [plan.v_ref_m_s for plan in experiment.plan.runs] == [0.06, 0.06]
    speeds = [plan.v_ref_m_s for plan in experiment.plans[::2]]
    assert speeds == pytest.approx([0.06, 0.07, 0.08, 0.09, 0.10, 0.11, 0.12, 0.13])
    estimate = workflow.estimate(experiment)
    assert (estimate.runs, estimate.at_most) == (16, True)


def test_the_campaign_ends_at_the_last_speed_with_fewer_runs_and_goes_on_counting(
    measure, short_schedule
):
    """Two loads, each of which goes its own way."""
    plans = measure(short_schedule(velocities=ADAPTIVE, loads=["1000 N", "3000 N"])).plans
    assert [plan.run for plan in plans] == [f"{n:04d}" for n in range(1, len(plans) + 1)]
    assert [plan.trial for plan in plans] == [1, 2] * (len(plans) // 2)
    for load in (1000, 3000):
        speeds = [plan.v_ref_m_s for plan in plans if plan.f_load_n == load][::2]
        assert (speeds[0], speeds[-1]) == (0.06, 0.13) and speeds == sorted(speeds)
        assert len(speeds) < 8
    assert [plan.f_load_n for plan in plans] == sorted(plan.f_load_n for plan in plans)


def test_progress_counts_on_over_all_parts_and_its_total_only_falls(measure, schedule):
    seen = []
    campaign = measure(schedule, report=seen.append)
    done, totals = [p.runs_done for p in seen], [p.runs_total for p in seen]
    assert done == sorted(done) and totals == sorted(totals, reverse=True)
    assert (seen[0].runs_done, seen[0].runs_total, seen[0].at_most) == (0, 16, True)
    assert (seen[-1].runs_total, seen[-1].at_most) == (len(campaign.plans), False)


def test_between_two_speeds_the_board_is_done(measure, schedule, monkeypatch):
    states = []

    def run_campaign(plans, bench, client, *args, **kwargs):
        runner.run_campaign(plans, bench, client, *args, **kwargs)
        states.append(STATES[client.status()["state"]])

    monkeypatch.setattr(workflow.campaign, "run_campaign", run_campaign)
    campaign = measure(schedule)
    assert states == ["done"] * (len(campaign.plans) // 2)


def test_a_resumed_campaign_takes_the_speed_that_it_would_have_taken(measure, schedule, tmp_path):
    whole = measure(schedule, "whole")

    def interrupt(progress):
        if progress.plan.run == "0007":  # the first trial of the fourth speed
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measure(schedule, report=interrupt)
    campaign = measure(schedule, resume=True)
    before, again = (entry for entry in campaign.entries if entry.plan.run == "0007")
    assert before.stop.outcome == "aborted" and again.stop.outcome == "done"
    assert before.plan == again.plan == whole.plans[6]
    assert len(campaign.done) == len(campaign.plans)
    assert campaign.plans[-1].v_ref_m_s == 0.13


def test_a_finished_campaign_resumed_makes_nothing_and_changes_nothing(measure, schedule, tmp_path):
    measure(schedule)
    before = (tmp_path / "campaign" / "campaign.yaml").read_bytes()
    measure(schedule, resume=True)
    assert (tmp_path / "campaign" / "campaign.yaml").read_bytes() == before


def test_where_every_run_is_rejected_the_smallest_steps_lead_to_the_end(measure, schedule):
    data = yaml.safe_load(schedule.read_text())
    data["experiments"][0]["velocities"]["last"] = "90 mm/s"
    data["screening"] = {"speed_oscillation": "0.0001 mm/s", "speed_oscillation_relative": "0 %"}
    schedule.write_text(yaml.safe_dump(data))
    campaign = measure(schedule)
    results = workflow.analyze(campaign.folder)
    assert not any(run.accepted for run in results.runs)
    speeds = [plan.v_ref_m_s for plan in campaign.plans[::2]]
    assert speeds == pytest.approx([0.06, 0.07, 0.08, 0.09])


def test_a_run_made_at_another_speed_does_not_count_for_the_plan(schedule):
    """Such as one whose friction came out otherwise when it was made again."""
    experiment = workflow.load_experiment(schedule, None)
    first, others = experiment.plans[:2], experiment.plans[4:6]
    friction = dict.fromkeys((*first, *others), 400.0)
    plan = plan_runs(experiment.schedule, experiment.bench, "s", friction)
    assert [run.v_ref_m_s for run in plan.runs] == pytest.approx([0.06, 0.06, 0.07, 0.07])


def test_steps_too_small_for_one_campaign_are_refused_before_anything_moves(short_schedule):
    tiny = ADAPTIVE | {"min_step": "0.001 mm/s"}
    with pytest.raises(ConfigError, match="short.yaml: .*9999 runs") as error:
        workflow.load_experiment(short_schedule(velocities=tiny), None)
    assert "smallest" in error.value.hint
