"""Log of a command's stages, under a clock that tests move."""

import io
import re
from datetime import UTC, datetime, timedelta
from itertools import pairwise
from pathlib import Path

import pytest

from hbench.cli.stage_log import StageLog, repeat_until, stage_log
from hbench.errors import DataError

LINE = re.compile(r"(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ) +([\d.]+) s  (.*)")


class Clock:
    """A clock that stands until it is moved."""

    def __init__(self):
        self.s = 1000.0

    def __call__(self):
        return self.s

    def date(self):
        return datetime(2026, 1, 1, 23, 59, 0, tzinfo=UTC) + timedelta(seconds=self.s - 1000)


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def stream():
    return io.StringIO()


@pytest.fixture
def log(stream, clock):
    return StageLog(stream, clock, clock.date)


def lines(stream):
    return [LINE.fullmatch(line).groups() for line in stream.getvalue().splitlines()]


def test_a_stage_has_the_time_of_day_and_the_seconds_since_the_start(log, stream, clock):
    log.stage("refitting")
    clock.s += 61.25
    log.stage("searching")
    assert lines(stream) == [
        ("2026-01-01T23:59:00Z", "0.0", "refitting"),
        ("2026-01-02T00:00:01Z", "61.2", "searching"),
    ]


def test_while_a_stage_lasts_a_line_comes_at_least_every_30_s(log, stream, clock):
    """Whatever the moments at which the waiting thread gets its turn: up to 4 s late here."""
    log.stage("searching")
    end, late = clock.s + 200, iter([0.0, 4.0, 1.0] * 20)

    def wait(seconds):
        assert 0 <= seconds <= 30
        clock.s += seconds + next(late)
        return clock.s >= end

    repeat_until(log, wait)
    times = [float(s) for _, s, _ in lines(stream)]
    assert len(times) > 5
    assert max(b - a for a, b in pairwise([*times, 200.0])) <= 30
    texts = [text for _, _, text in lines(stream)]
    assert texts[1] == "still searching: 25 s"
    assert all(text.startswith("still searching: ") for text in texts[1:])


def test_a_new_stage_puts_off_the_next_line_and_counts_from_itself(log, stream, clock):
    log.stage("refitting")
    clock.s += 20
    log.stage("simulating")
    log.counted(1, 3)
    clock.s += 20
    log.repeat()  # not due: 20 s since the last line
    clock.s += 5
    log.repeat()
    assert [text for _, _, text in lines(stream)] == [
        "refitting", "simulating", "still simulating: 25 s, 1 of 3 simulations",
    ]  # fmt: skip


def test_the_file_ends_with_the_end_or_with_the_error(tmp_path):
    path = tmp_path / "out" / "reconcile.log"
    with stage_log(path) as log:
        log.stage("reading")
        assert path.read_text().endswith("  reading\n")  # at once, not at the end
    assert [text for _, _, text in lines(io.StringIO(path.read_text()))] == ["reading", "finished"]
    with pytest.raises(ValueError, match="bad"), stage_log(path):
        raise ValueError("bad file")
    (only,) = lines(io.StringIO(path.read_text()))
    assert only[2] == "ended by ValueError: bad file"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="/dev/full is of Linux")
def test_a_full_disk_ends_a_command_with_its_own_error_and_not_with_that_of_the_log():
    with pytest.raises(DataError, match=r"report\.html"), stage_log(Path("/dev/full")) as log:
        log.stage("writing the page")
        raise DataError("report.html: can't be written")
    with stage_log(Path("/dev/full")) as log:  # the log alone is lost
        log.stage("reading")
