"""A campaign on the virtual rig: whole, repeatable, and never lost when something goes wrong."""

import re

import pytest
import yaml

from hbench import workflow
from hbench.errors import ConfigError, DataError, DeviceError, ExitCode
from hbench.experiment.runner import FAULT_WORDS
from hbench.model.plant import V
from hbench.protocol.codec import BY_NAME
from hbench.protocol.dictionary import FAULTS
from hbench.protocol.frames import Frame, encode
from hbench.rig import virtual
from hbench.rig.client import BoardClient
from hbench.rig.firmware import HostFirmware
from hbench.store.campaign.folder import load_campaign
from hbench.store.campaign.writer import CampaignWriter
from tests.support.rig_campaign import measure_on_rig


@pytest.fixture
def measure(tmp_path, clock):
    """Run a schedule into a folder of ``tmp_path``."""

    def run(
        schedule,
        folder="campaign",
        *,
        seed=1,
        resume=False,
        plant=None,
        report=None,
        take_over=False,
    ):
        experiment = workflow.load_experiment(schedule, None)
        return measure_on_rig(
            experiment,
            tmp_path / folder,
            plant=plant,
            seed=seed,
            resume=resume,
            clock=clock,
            report=report or (lambda progress: None),
            take_over=take_over,
        )

    return run


def logs(folder):
    return {path.name: path.read_bytes() for path in sorted((folder / "runs").iterdir())}


def test_every_run_of_the_plan_is_done_and_its_log_ends_with_the_last_record(
    measure, short_schedule, tmp_path
):
    measure(short_schedule())
    campaign = load_campaign(tmp_path / "campaign")
    assert [(p.v_ref_m_s, p.trial) for p in campaign.plans] == [
        (0.06, 1), (0.06, 2), (0.12, 1), (0.12, 2)
    ]  # fmt: skip
    assert len(campaign.entries) == 4
    for raw in campaign.raw_runs():
        index = [c.name for c in raw.channels].index("index")
        flags = [c.name for c in raw.channels].index("flags")
        last = 1 << raw.flags.index("last")
        assert raw.outcome == "done" and not raw.warnings
        assert raw.words[:, index].tolist() == list(range(len(raw.words)))
        assert [bool(word & last) for word in raw.words[:, flags]] == [False] * (
            len(raw.words) - 1
        ) + [True]


def test_the_same_seed_gives_the_same_bytes_and_another_seed_does_not(
    measure, short_schedule, tmp_path
):
    schedule = short_schedule(velocities=["120 mm/s"], trials=1)
    for folder, seed in (("a", 1), ("b", 1), ("c", 2)):
        measure(schedule, folder, seed=seed)
    assert logs(tmp_path / "a") == logs(tmp_path / "b")
    assert logs(tmp_path / "a") != logs(tmp_path / "c")


def test_a_campaign_folder_is_not_overwritten(measure, short_schedule):
    schedule = short_schedule(velocities=["120 mm/s"], trials=1)
    measure(schedule)
    with pytest.raises(ConfigError, match="campaign: "):
        measure(schedule)


def test_an_interrupted_run_is_kept_as_aborted_and_made_again_on_resume(
    measure, short_schedule, tmp_path
):
    def interrupt(progress):
        if progress.runs_done == 2 and abs(progress.v_m_s) > 0.1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measure(short_schedule(), report=interrupt)
    campaign = load_campaign(tmp_path / "campaign")
    assert [e.stop.outcome for e in campaign.entries] == ["done", "done", "aborted"]
    assert campaign.entries[-1].stop.why.startswith("interrupted")
    before = logs(tmp_path / "campaign")

    measure(short_schedule(), resume=True)
    campaign = load_campaign(tmp_path / "campaign")
    assert campaign.done == {"0001", "0002", "0003", "0004"}
    assert [e.plan.run for e in campaign.entries] == ["0001", "0002", "0003", "0003", "0004"]
    after = logs(tmp_path / "campaign")
    assert after["0003~1.dat"] == before["0003.dat"]
    assert all(after[name] == before[name] for name in ("0001.dat", "0002.dat"))


def test_resume_makes_runs_with_missing_or_changed_logs_again_and_keeps_what_is_there(
    measure, short_schedule, tmp_path
):
    measure(short_schedule())
    folder = tmp_path / "campaign"
    before = logs(folder)
    (folder / "runs" / "0001.dat").unlink()
    spoilt = before["0003.dat"][:-20]
    (folder / "runs" / "0003.dat").write_bytes(spoilt)
    assert load_campaign(folder).damaged().keys() == {"0001", "0003"}

    summary = measure(short_schedule(), resume=True)
    assert summary.made_again.keys() == {"0001", "0003"} and summary.runs == 2
    campaign, after = load_campaign(folder), logs(folder)
    assert not campaign.damaged() and not campaign.warnings
    assert after["0003~1.dat"] == spoilt
    assert all(after[name] == before[name] for name in ("0002.dat", "0004.dat"))
    assert not measure(short_schedule(), resume=True).made_again


def test_a_journal_that_is_a_link_out_of_its_folder_is_refused(measure, short_schedule, tmp_path):
    measure(short_schedule())
    journal, other = tmp_path / "campaign" / "campaign.yaml", tmp_path / "other"
    other.mkdir()
    (other / "campaign.yaml").symlink_to(journal)
    with pytest.raises(DataError, match="outside"):
        load_campaign(other)


def test_a_fault_of_the_board_ends_the_campaign_with_its_cause_and_what_was_logged(
    measure, short_schedule, tmp_path
):
    """Too little friction to damp the loop: the speed swings beyond its limit on the way."""
    plant = tmp_path / "plant.yaml"
    plant.write_text("friction: {test: {viscous: 1300 N s/m}, load: {viscous: 1300 N s/m}}\n")
    schedule = short_schedule(bench={"limits": {"speed_max": "200 mm/s"}})
    with pytest.raises(DeviceError, match=r"run \d+: .*: speed: ") as error:
        measure(schedule, plant=plant)
    assert error.value.exit_code == ExitCode.DEVICE
    *before, entry = load_campaign(tmp_path / "campaign").entries
    assert all(earlier.stop.outcome == "done" for earlier in before)
    assert entry.stop.outcome == "failed" and "speed" in entry.stop.why
    assert entry.stop.records > 20


def test_a_lost_line_leaves_the_runs_before_it_and_what_was_pulled(
    measure, short_schedule, tmp_path, monkeypatch
):
    class Cable(virtual.VirtualRig):
        def write(self, data):
            if self.now() > 6.0:
                raise DeviceError("sim: the cable is out")
            super().write(data)

    monkeypatch.setattr(virtual, "VirtualRig", Cable)
    with pytest.raises(DeviceError, match="cable"):
        measure(short_schedule())
    campaign = load_campaign(tmp_path / "campaign")
    outcomes = [entry.stop.outcome for entry in campaign.entries]
    assert outcomes[-1] == "failed" and set(outcomes[:-1]) <= {"done"}


def test_a_hidden_plant_leaves_only_its_hash_in_the_campaign(measure, short_schedule, tmp_path):
    plant = tmp_path / "secret.yaml"
    plant.write_text("oil: {bulk_modulus: 654 bar}\n")
    measure(short_schedule(velocities=["120 mm/s"], trials=1), plant=plant)
    text = (tmp_path / "campaign" / "campaign.yaml").read_text()
    assert "sha256" in text and "654" not in text and "secret" not in text


def test_a_campaign_is_not_resumed_with_another_bench_or_plant(measure, short_schedule, tmp_path):
    measure(short_schedule(velocities=["120 mm/s"], trials=1))
    with pytest.raises(ConfigError, match="campaign: .*bench"):
        schedule = short_schedule(
            bench={"oil": {"density": "860 kg/m^3"}}, velocities=["120 mm/s"], trials=1
        )
        measure(schedule, resume=True)
    with pytest.raises(ConfigError, match="schedule.*velocities.0: .120.*60"):
        measure(short_schedule(velocities=["60 mm/s"], trials=1), resume=True)
    plant = tmp_path / "plant.yaml"
    plant.write_text("oil: {bulk_modulus: 654 bar}\n")
    with pytest.raises(ConfigError, match="campaign: .*plant"):
        measure(short_schedule(velocities=["120 mm/s"], trials=1), resume=True, plant=plant)


def test_a_resume_before_the_first_run_says_to_leave_the_option_out(
    measure, short_schedule, tmp_path
):
    schedule = short_schedule(velocities=["120 mm/s"], trials=1)
    with pytest.raises(DataError, match="campaign: no campaign to resume") as error:
        measure(schedule, resume=True)
    assert "without --resume" in error.value.hint
    assert measure(schedule).runs == 1


def test_a_finished_campaign_resumed_makes_nothing_and_changes_nothing(
    measure, short_schedule, tmp_path
):
    schedule = short_schedule(velocities=["120 mm/s"], trials=1)
    measure(schedule)
    before = (tmp_path / "campaign" / "campaign.yaml").read_bytes()
    assert measure(schedule, resume=True).runs == 0
    assert (tmp_path / "campaign" / "campaign.yaml").read_bytes() == before


def test_runs_of_which_the_log_ran_over_are_failed_and_made_again(
    measure, short_schedule, tmp_path, monkeypatch
):
    """The host is away for longer than the ring's 10.24 s holds; the board goes on."""
    rigs = []

    class Watched(virtual.VirtualRig):
        def __init__(self, *args):
            super().__init__(*args)
            rigs.append(self)

    def fall_silent(progress):
        if progress.runs_done == 1 and abs(progress.v_m_s) > 0.05 and len(away) == 0:
            away.append(progress.plan.run)
            while rigs[0].now() < 60.0:
                rigs[0].read(1.0)

    away = []
    monkeypatch.setattr(virtual, "VirtualRig", Watched)
    velocities = [f"{v} mm/s" for v in range(20, 32, 2)]
    schedule = short_schedule(
        bench={"limits": {"heartbeat": "60 s"}}, velocities=velocities, trials=1, window="3 s"
    )
    with pytest.raises(DeviceError, match="of 6 runs .*: 0002") as error:
        measure(schedule, report=fall_silent)
    assert "--resume" in error.value.hint
    campaign = load_campaign(tmp_path / "campaign")
    assert away == ["0002"]
    failed = {e.plan.run: e.stop.why for e in campaign.entries if e.stop.outcome == "failed"}
    assert len(failed) + len(campaign.done) == 6
    assert re.match(r"\d+ records ", failed["0002"])
    assert all("overwritten" in why for why in failed.values())
    assert any("all" in why for why in failed.values())
    for raw in campaign.raw_runs():
        if raw.outcome == "done":
            index = [c.name for c in raw.channels].index("index")
            assert raw.words[:, index].tolist() == list(range(len(raw.words)))
    measure(schedule, resume=True)
    assert len(load_campaign(tmp_path / "campaign").done) == 6


class Scripted(virtual.VirtualRig):
    """A rig to which something happens once, in the middle of the first run."""

    def __init__(self, *args):
        super().__init__(*args)
        self.happened = False

    def write(self, data):
        extends = self._bench.state[V] > 0.05  # the way back to the start is a retraction
        if extends and not self.happened:
            self.happened = True
            self.happen()
        super().write(data)


class PowerCycled(Scripted):
    def happen(self):
        self._board = HostFirmware(boots=2)


class StoppedFromElsewhere(Scripted):
    def happen(self):
        stop = encode(Frame(77, BY_NAME["stop"].code, b""))
        self._board.receive(stop)
        self._board.poll()
        self._board.transmit()


@pytest.mark.parametrize(
    ("event", "word"), [(PowerCycled, "reset"), (StoppedFromElsewhere, "elsewhere")]
)
def test_a_run_that_the_board_did_not_end_itself_is_failed_and_made_again(
    measure, short_schedule, tmp_path, monkeypatch, event, word
):
    with monkeypatch.context() as patch:
        patch.setattr(virtual, "VirtualRig", event)
        with pytest.raises(DeviceError, match=word):
            measure(short_schedule())
    (entry,) = load_campaign(tmp_path / "campaign").entries
    assert entry.stop.outcome == "failed" and word in entry.stop.why
    measure(short_schedule(), resume=True)
    assert load_campaign(tmp_path / "campaign").done == {"0001", "0002", "0003", "0004"}


def test_a_resumed_trial_is_no_copy_of_one_before(measure, short_schedule, tmp_path):
    schedule = short_schedule(velocities=["120 mm/s"])

    def interrupt(progress):
        if progress.runs_done == 1:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measure(schedule, report=interrupt)
    measure(schedule, resume=True)
    first, second = (raw.words for raw in load_campaign(tmp_path / "campaign").raw_runs())
    n = min(len(first), len(second))
    assert (first[:n, 3:] != second[:n, 3:]).mean() > 0.5


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"rate": "5 kHz"}, r"controllers\.rate = 5000 Hz.* 10000 Hz"),
        ({"log_rate": "1 kHz"}, "controllers.log_rate = 1000 Hz.* 1.0 s"),
    ],
)
def test_rates_that_the_board_does_not_have_are_refused_before_anything_moves(
    measure, short_schedule, tmp_path, change, words
):
    with pytest.raises(ConfigError, match=words):
        measure(short_schedule(bench={"controllers": change}))
    assert load_campaign(tmp_path / "campaign").entries == ()


def test_a_full_disk_does_not_keep_the_board_from_being_stopped(
    measure, short_schedule, monkeypatch
):
    stopped = []
    monkeypatch.setattr(BoardClient, "stop", lambda client: stopped.append(True))

    def full(*_):
        assert stopped, "the log was written before the board was told to stop"
        raise DataError("full")

    def interrupt(progress):
        monkeypatch.setattr(CampaignWriter, "finish_run", full)
        raise KeyboardInterrupt

    with pytest.raises(DataError, match="full"):
        measure(short_schedule(), report=interrupt)


def test_a_latched_fault_is_cleared_on_request_alone(
    measure, short_schedule, monkeypatch, tmp_path
):
    """The same board, with power on all the time."""
    rigs = []

    class Lasting(virtual.VirtualRig):
        def __new__(cls, *args):
            return rigs[0] if rigs else super().__new__(cls)

        def __init__(self, *args):
            if not rigs:
                super().__init__(*args)
                rigs.append(self)

        def close(self):
            pass

    monkeypatch.setattr(virtual, "VirtualRig", Lasting)
    schedule = short_schedule(velocities=["120 mm/s"], trials=1)

    def fall_silent(progress):
        rigs[0].read(3.0)

    with pytest.raises(DeviceError, match="heartbeat"):
        measure(schedule, report=fall_silent)
    with pytest.raises(DeviceError, match=": heartbeat: ") as error:
        measure(schedule, "another")
    assert "--resume" in error.value.hint and "--take-over" in error.value.hint
    assert not (tmp_path / "another").exists(), "nothing was begun"
    assert measure(schedule, resume=True).runs == 1
    with pytest.raises(DeviceError, match="heartbeat"):
        measure(schedule, "third", report=fall_silent)
    assert measure(schedule, "another", take_over=True).runs == 1


def test_every_fault_of_the_board_has_words():
    assert set(FAULT_WORDS) == set(FAULTS) - {"none", "stopped"}


@pytest.mark.parametrize("name", ["", "  ", "ä $x_{$"])
def test_a_campaign_of_any_name_can_be_read_again(quick_schedule, tmp_path, clock, name):
    file = quick_schedule(trials=1)
    file.write_text(yaml.safe_dump(yaml.safe_load(file.read_text()) | {"name": name}))
    measure_on_rig(workflow.load_experiment(file, None), tmp_path / "campaign", clock=clock)
    assert load_campaign(tmp_path / "campaign").header["name"] == name
    assert workflow.analyze(tmp_path / "campaign").provenance.name == name
