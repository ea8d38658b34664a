"""Campaigns that ended early, or that are still running, are reported as incomplete."""

import pytest

from hbench import workflow
from hbench.report.campaign.terminal import summary_text


def check(results, name):
    return {check.name: check for check in results.quality.checks}[name]


def test_an_interrupted_campaign_reports_the_runs_and_points_that_are_missing(
    quick_schedule, tmp_path, on_the_rig
):
    """While it runs, after it was interrupted, and no longer when it is complete."""
    folder, live = tmp_path / "campaign", []

    def interrupt(progress):
        if progress.runs_done == 1 and not live:
            live.append(workflow.analyze(folder))
        if progress.runs_done == 2 and abs(progress.v_m_s) > 0.05:
            raise KeyboardInterrupt

    schedule = quick_schedule()
    with pytest.raises(KeyboardInterrupt):
        on_the_rig(schedule, folder, report=interrupt)
    assert live[0].quality.completeness.not_completed == ("0002", "0003", "0004")
    cut = workflow.analyze(folder)
    assert cut.quality.completeness.not_completed == ("0003", "0004")  # 0003 was aborted
    assert (check(cut, "complete").count, check(cut, "complete").of) == (2, 4)
    assert check(cut, "complete").grade == "poor"
    (point,) = cut.quality.completeness.short_points
    assert (point.v_ref_m_s, point.accepted, point.planned) == (0.12, 0, 2)
    assert check(cut, "trials_per_point").value == 0
    text = " ".join(summary_text(cut).split())
    assert "ABORTED CAMPAIGN: 2 of 4 planned runs were completed. Run 0003 (steady, 120" in text
    assert "ended early: interrupted by the operator." in text
    assert "1 point has no accepted trial. Next step: continue the campaign" in text

    on_the_rig(schedule, folder, resume=True)
    whole = workflow.analyze(folder)
    assert whole.quality.completeness.not_completed == whole.quality.completeness.short_points == ()
    assert check(whole, "complete").grade == "good" and "ABORTED" not in summary_text(whole)


def test_adaptive_speeds_that_are_not_decided_count_as_the_most_runs_that_may_follow(
    quick_schedule, tmp_path, on_the_rig
):
    speeds = {
        "strategy": "adaptive",
        "first": "80 mm/s",
        "last": "120 mm/s",
        "min_step": "10 mm/s",
        "max_step": "40 mm/s",
        "tolerance": "5 N",
    }
    folder = tmp_path / "campaign"

    def interrupt(progress):
        if progress.runs_done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        on_the_rig(quick_schedule(velocities=speeds), folder, report=interrupt)
    found = workflow.analyze(folder).quality.completeness
    assert found.at_most and found.planned == len(found.not_completed) + 3
    on_the_rig(quick_schedule(velocities=speeds), folder, resume=True)
    found = workflow.analyze(folder).quality.completeness
    assert not found.at_most and found.not_completed == ()


def test_a_schedule_that_can_not_be_read_leaves_the_plan_unknown_with_a_note(
    quick_schedule, tmp_path, on_the_rig
):
    folder = tmp_path / "campaign"
    on_the_rig(quick_schedule(), folder)
    journal = folder / "campaign.yaml"
    journal.write_text(journal.read_text().replace("- 80 mm/s", "- 8000 mm/s", 1))
    results = workflow.analyze(folder)
    assert results.quality.completeness.planned is None
    assert "complete" not in {check.name for check in results.quality.checks}
    assert any("planned runs are not known" in note for note in results.notes)
