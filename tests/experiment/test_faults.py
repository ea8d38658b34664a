"""The link never loses a run: whatever happens to line, board and host, --resume completes."""

import shutil
import time
from collections import Counter

import pytest

from tests.support.faults.fault_story import play
from tests.support.faults.faulty_line import Octets, Script, random_script


def sweep(numbers, quick_experiment, tmp_path, clock):
    injected, sessions, begin = Counter(), Counter(), time.monotonic()
    for number in numbers:
        script = random_script(number)
        try:
            story = play(script, quick_experiment, tmp_path / f"{number}", clock)
        except BaseException as error:
            error.add_note(f"script {number}: {script}")
            raise
        shutil.rmtree(tmp_path / f"{number}")
        injected += story.injected
        sessions[story.sessions] += 1
    print(f"\n{len(numbers)} scripts, all complete, in {time.monotonic() - begin:.0f} s")
    print(f"sessions needed: {dict(sorted(sessions.items()))}")
    print(f"injected: {dict(injected)}")


def test_no_run_is_lost_or_made_twice_under_random_faults(quick_experiment, tmp_path, clock):
    sweep(range(12), quick_experiment, tmp_path, clock)


@pytest.mark.parametrize("fault", ["drop", "flip", "duplicate", "delay"])
def test_a_line_that_hurts_one_octet_in_a_hundred_carries_a_campaign(
    quick_experiment, tmp_path, clock, fault
):
    hurt = Octets(**{fault: 0.01})
    story = play(Script(1, hurt, hurt, baud=115_200), quick_experiment, tmp_path / "c", clock)
    assert story.injected[fault] > 50 and story.sessions <= 5, story.errors


@pytest.mark.slow
def test_no_run_is_lost_or_made_twice_in_a_long_sweep(quick_experiment, tmp_path, clock):
    sweep(range(1000, 1600), quick_experiment, tmp_path, clock)


@pytest.mark.nightly
def test_two_thousand_fault_scripts_lose_no_run(quick_experiment, tmp_path, clock):
    sweep(range(10_000, 12_000), quick_experiment, tmp_path, clock)
