"""The recorder believes the mark of a run's last record only where nothing contradicts it."""

import numpy as np
import pytest

from hbench.errors import DeviceError
from hbench.experiment.recorder import FALSE_END, Recorder
from hbench.protocol.dictionary import PHASES, RECORD, RECORD_FLAGS, STATES

WORDS = [word.name for word in RECORD]
LAST = 1 << RECORD_FLAGS.index("last")


class Outcomes:
    """A journal that keeps what it is given."""

    def __init__(self):
        self.started = []
        self.finished = []

    def start_run(self, plan, at, after_rejection=""):
        self.started.append(plan.run)

    def finish_run(self, plan, words, outcome, why, at):
        self.finished.append((plan.run, len(words), outcome, why))


@pytest.fixture
def journal():
    return Outcomes()


@pytest.fixture
def recorder(quick_experiment, clock, journal):
    return Recorder(quick_experiment.plans, quick_experiment.bench, journal, clock)


def records(run, first, until, marked=()):
    words = np.zeros((until - first, len(RECORD)), np.uint16)
    words[:, WORDS.index("run")] = run
    words[:, WORDS.index("index")] = np.arange(first, until)
    words[np.subtract(marked, first).astype(int), WORDS.index("flags")] = LAST
    return words


def status(run, phase, state="running"):
    return {"run": run, "phase": PHASES.index(phase), "state": STATES.index(state)}


AFTER = [status(1, "brake"), status(2, "return"), status(1, "none", "done")]


@pytest.mark.parametrize("after", AFTER, ids=["brakes", "returns", "has ended"])
def test_a_marked_record_ends_its_run_once_the_board_says_that_the_run_is_over(
    recorder, journal, after
):
    recorder.feed(records(1, 0, 50, [49]))
    assert not journal.finished
    recorder.follow(after)
    assert journal.finished == [("0001", 50, "done", "")]


def test_a_record_of_the_next_run_ends_it_too_and_records_lost_between_are_of_neither(
    recorder, journal
):
    recorder.feed(records(1, 0, 50, [49]))
    recorder.lose(7)
    recorder.feed(records(2, 0, 9))
    recorder.follow(status(2, "steady"))
    recorder.feed(records(2, 9, 50, [49]))
    recorder.follow(status(2, "brake"))
    assert journal.finished == [("0001", 50, "done", ""), ("0002", 50, "done", "")]


def test_a_false_mark_inside_a_run_does_not_end_it_and_the_run_is_failed(recorder, journal):
    """In the middle of a reply, at its end, and at the end of all that was logged until then."""
    recorder.feed(records(1, 0, 50, [20, 49]))
    recorder.follow(status(1, "brake"))
    recorder.feed(records(2, 0, 20, [19]))
    recorder.feed(records(2, 20, 50, [49]))
    recorder.follow(status(2, "brake"))
    recorder.feed(records(3, 0, 20, [19]))
    recorder.follow(status(3, "steady"))
    assert len(journal.finished) == 2
    recorder.feed(records(3, 20, 50, [49]))
    recorder.follow(status(3, "brake"))
    assert journal.finished == [(run, 50, "failed", FALSE_END) for run in ("0001", "0002", "0003")]
    with pytest.raises(DeviceError, match="3 of 4 runs failed|4 of 4"):
        recorder.close()


def test_a_run_that_logs_more_than_its_motion_can_last_ends_in_an_error(recorder, quick_experiment):
    longest = quick_experiment.plans[0].motion.duration_s * recorder.bench.controllers.log_rate
    parts = (records(1, 7 * n, 7 * (n + 1)) for n in range(10_000))
    with pytest.raises(DeviceError, match=f"run 0001: the board sent .* {longest:.0f}\n"):
        for part in parts:
            recorder.feed(part)


def test_a_run_whose_records_go_on_after_its_end_was_confirmed_is_not_made(recorder, journal):
    """The board's status lies as well. The journal's last word on the run is that it failed."""
    recorder.feed(records(1, 0, 20, [19]))
    recorder.follow(status(1, "brake"))
    with pytest.raises(DeviceError, match="records of run 0001 after its last") as error:
        recorder.feed(records(1, 20, 50, [49]))
    recorder.abandon(error.value)
    assert journal.started == ["0001", "0001"]
    assert [(run, outcome) for run, _, outcome, _ in journal.finished] == [
        ("0001", "done"),
        ("0001", "failed"),
    ]
