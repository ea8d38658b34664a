"""A session that meets a board which was left running, or whose start it did not hear of."""

import pytest

from hbench.errors import ConfigError, DeviceError
from hbench.protocol.codec import BY_NAME
from hbench.protocol.dictionary import STATES
from hbench.protocol.frames import Receiver
from hbench.rig import virtual
from hbench.rig.client import BoardClient
from hbench.store.campaign.folder import load_campaign
from tests.support.faults.fault_story import check_against_board
from tests.support.faults.faulty_line import Event, Kill, Killed, Script, World, attempts
from tests.support.rig_campaign import measure_on_rig


@pytest.fixture
def measure(quick_experiment, tmp_path, clock, monkeypatch):
    """Run the quick schedule on a world."""

    def run(world, folder="campaign", resume=False, report=lambda progress: None, line=None):
        monkeypatch.setattr(virtual, "VirtualRig", lambda *_: line or world.open())
        return measure_on_rig(
            quick_experiment, tmp_path / folder, resume=resume, clock=clock, report=report
        )

    return run


def state(world):
    return STATES[BoardClient(world.open()).status()["state"]]


def test_a_board_that_runs_for_a_dead_host_is_taken_over_by_resume_alone(
    quick_experiment, measure, tmp_path
):
    world = World(quick_experiment.bench, Script(kills=(Kill(0, call=100),)))
    with pytest.raises(Killed):
        measure(world)
    assert state(world) == "running"
    with pytest.raises(DeviceError, match="another host") as error:
        measure(world, "another")
    assert "--resume" in error.value.hint and state(world) == "running"
    measure(world, resume=True)
    check_against_board(tmp_path / "campaign", quick_experiment, attempts(world.truth.words()))


def test_records_of_a_start_whose_answer_was_lost_are_not_lost(quick_experiment, measure, tmp_path):
    """Until the host hears of it, the board is in the middle of its first run."""
    world = World(quick_experiment.bench, Script())
    line, receiver, logged = world.open(), Receiver(), []
    read, write, left = line.read, line.write, iter(())

    def deaf_read(timeout_s):
        said = read(timeout_s)
        return b"" if said and next(left, None) else said

    def heard_write(data):
        nonlocal left
        if not logged and any(f.code == BY_NAME["start"].code for f in receiver.feed(data)):
            logged.append(0)
            left = iter([True] * 6)  # of eight answers
        write(data)

    def report(progress):
        logged.append(len(world.truth.words()))

    line.read, line.write = deaf_read, heard_write
    measure(world, report=report, line=line)
    assert logged[1] > 0, "nothing had been logged before the host heard"
    check_against_board(tmp_path / "campaign", quick_experiment, attempts(world.truth.words()))
    assert len(load_campaign(tmp_path / "campaign").entries) == 4


@pytest.mark.parametrize(
    ("kind", "word"),
    [("reset", "reset"), ("vanish", "lost")],
)
def test_a_reset_and_a_lost_line_are_distinguished(quick_experiment, measure, tmp_path, kind, word):
    for at_s in (1.2, 1.3, 1.4, 1.5):  # between and in the middle of pulls
        world = World(quick_experiment.bench, Script(events=(Event(at_s, kind, 0.1),)))
        with pytest.raises(DeviceError, match=rf"run 000\d: .*{word}") as error:
            measure(world, f"{at_s}")
        assert "--resume" in error.value.hint
        (*_, entry) = load_campaign(tmp_path / f"{at_s}").entries
        assert entry.stop.outcome == "failed" and word in entry.stop.why


def test_a_bug_of_the_host_stops_the_board(quick_experiment, measure, tmp_path):
    def crash(progress):
        raise ZeroDivisionError

    world = World(quick_experiment.bench, Script())
    with pytest.raises(ZeroDivisionError):
        measure(world, report=crash)
    assert state(world) == "idle"
    (entry,) = load_campaign(tmp_path / "campaign").entries
    assert (entry.stop.outcome, entry.stop.why) == ("failed", "ZeroDivisionError")


def test_a_second_host_of_the_same_campaign_is_turned_away(quick_experiment, measure, tmp_path):
    world = World(quick_experiment.bench, Script())
    other = World(quick_experiment.bench, Script())
    refused = []

    def second(progress):
        if not refused:
            with pytest.raises(ConfigError, match="campaign: .*hbench") as error:
                measure(other, resume=True)
            refused.append(error)

    measure(world, report=second)
    assert refused and not len(other.truth.words())
    check_against_board(tmp_path / "campaign", quick_experiment, attempts(world.truth.words()))
    assert measure(world, resume=True).runs == 0


def test_a_campaign_that_could_not_begin_leaves_no_folder(quick_experiment, measure, tmp_path):
    world = World(quick_experiment.bench, Script(events=(Event(0.0, "vanish", 5.0),)))
    world.wait(1.0)
    with pytest.raises(DeviceError, match="device"):
        measure(world)
    assert not (tmp_path / "campaign").exists()
