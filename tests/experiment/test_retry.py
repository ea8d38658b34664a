"""Each run is judged as it ends, and one that is rejected can be made again at once."""

import pytest

from hbench import workflow
from hbench.model.plant import V
from hbench.model.sensors import SENSORS
from hbench.rig import virtual
from hbench.store.campaign.checksums import sha256
from hbench.store.campaign.folder import load_campaign
from tests.support.rig_campaign import measure_on_rig

LOAD_CELL = SENSORS.index("f_applied")


class LooseWire(virtual.VirtualRig):
    """A rig whose load cell reads its highest code during some strokes, counted from 1."""

    strokes: tuple[int, ...] = ()

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self._sound = self._bench.sensors
        self._stroke, self._moved = 0, False

    def read(self, timeout_s):
        extends = self._bench.state[V] > 0.03  # the way back to the start is a retraction
        self._stroke += extends and not self._moved
        self._moved = extends
        zeros = list(self._sound.zero)
        if extends and self._stroke in self.strokes:
            zeros[LOAD_CELL] = 1e9
        self._bench = self._bench._replace(sensors=self._sound._replace(zero=tuple(zeros)))
        return super().read(min(timeout_s, 0.05))


@pytest.fixture
def measure(tmp_path, clock, short_schedule, monkeypatch):
    """Make the short schedule with a wire that is loose during ``strokes``; give its campaign."""

    def make(strokes, *, report=lambda progress: None, resume=False, **options):
        monkeypatch.setattr(LooseWire, "strokes", strokes)
        monkeypatch.setattr(virtual, "VirtualRig", LooseWire)
        measure_on_rig(
            workflow.load_experiment(short_schedule(), None),
            tmp_path / "campaign",
            resume=resume,
            clock=clock,
            report=report,
            **options,
        )
        return load_campaign(tmp_path / "campaign")

    return make


def attempts(campaign):
    return [entry.plan.run for entry in campaign.entries]


def test_the_verdict_on_the_spot_is_that_of_analyze(measure, tmp_path):
    seen = []
    measure((2, 3), report=lambda progress: seen.extend(progress.ended))
    results = workflow.analyze(tmp_path / "campaign")
    assert [one.plan for one in seen] == [one.run.plan for one in results.runs]
    assert [one.reasons for one in seen] == [one.reasons for one in results.runs]
    assert [bool(one.reasons) for one in seen] == [False, True, True, False]
    assert [one.friction_n for one in seen] == [one.means.friction_n for one in results.runs]


def test_without_retry_a_rejected_run_is_made_once(measure):
    assert attempts(measure((2,))) == ["0001", "0002", "0003", "0004"]


def test_a_rejected_run_is_made_again_before_the_next_and_counts(measure, tmp_path):
    seen = []
    campaign = measure((2,), retry=1, report=lambda progress: seen.extend(progress.ended))
    assert attempts(campaign) == ["0001", "0002", "0002", "0003", "0004"]
    assert [(one.plan.run, one.attempt, one.again) for one in seen][1:3] == [
        ("0002", 1, True),
        ("0002", 2, False),
    ]
    results = workflow.analyze(tmp_path / "campaign")
    assert len(results.runs) == 4 and all(one.accepted for one in results.runs)
    assert any("0002 (sensor_saturated" in note for note in results.notes), "a choice of trials"


def test_the_log_of_each_attempt_is_kept_as_it_was_pulled(measure, tmp_path):
    campaign = measure((2, 3), retry=2)
    assert attempts(campaign).count("0002") == 3
    kept = {sha256(path.read_bytes()) for path in (tmp_path / "campaign" / "runs").iterdir()}
    assert kept == {entry.stop.sha256 for entry in campaign.entries} and len(kept) == 6
    assert [bool(entry.after_rejection) for entry in campaign.entries][1:4] == [False, True, True]


def test_a_run_that_stays_bad_is_given_up_after_its_retries(measure, tmp_path):
    campaign = measure((2, 3, 4), retry=2)
    assert attempts(campaign) == ["0001", *["0002"] * 3, "0003", "0004"]
    verdicts = [one.accepted for one in workflow.analyze(tmp_path / "campaign").runs]
    assert verdicts == [True, False, True, True]


def test_a_campaign_interrupted_in_a_second_attempt_is_resumed(measure, tmp_path):
    def interrupt(progress):
        if progress.attempt == 2 and progress.v_m_s > 0.05:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measure((2,), retry=1, report=interrupt)
    stopped = load_campaign(tmp_path / "campaign")
    assert [entry.stop.outcome for entry in stopped.entries] == ["done", "done", "aborted"]
    assert stopped.done == {"0001"}
    campaign = measure((), retry=1, resume=True)
    assert attempts(campaign) == ["0001", "0002", "0002", "0002", "0003", "0004"]
    assert all(one.accepted for one in workflow.analyze(tmp_path / "campaign").runs)


def test_one_run_at_a_time_measures_what_a_whole_schedule_does(measure, tmp_path):
    """The board rests between two runs; friction must not notice."""
    measure(())
    whole = [one.means.friction_n for one in workflow.analyze(tmp_path / "campaign").runs]
    (tmp_path / "campaign").rename(tmp_path / "whole")
    measure((), retry=1)
    single = [one.means.friction_n for one in workflow.analyze(tmp_path / "campaign").runs]
    assert single == pytest.approx(whole, rel=0.06)  # four sigma of the strokes' 1.5 %


def test_progress_tells_trials_rejections_and_the_time_left(measure):
    seen = []
    measure((2,), retry=1, report=seen.append)
    assert {(p.plan.trial, p.trials) for p in seen} == {(1, 2), (2, 2)}
    assert [p.runs_done for p in seen] == sorted(p.runs_done for p in seen)
    assert (seen[-1].runs_done, seen[-1].runs_total, seen[-1].rejected) == (4, 4, 1)
    assert seen[-1].last_rejected.plan.run == "0002" and seen[-1].seconds_left == 0
    assert seen[0].seconds_left is None and all(p.seconds_left is not None for p in seen[-20:])
    settled = [p for p in seen if p.phase == "steady" and p.plan.run == "0004"][-1]
    assert settled.v_ref_m_s == pytest.approx(0.12, abs=1e-6)
    assert settled.f_load_n == pytest.approx(2000, rel=0.1)
    assert settled.pressures_pa["p_lr"] == pytest.approx(15e5, rel=0.1)
    assert settled.pressures_pa["p_s"] == pytest.approx(150e5, rel=0.02)
    assert settled.pressure_max_pa == 230e5
