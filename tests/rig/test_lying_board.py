"""A board that lies at any stage ends a campaign in a clear error, or changes nothing in it.

After it has told the truth again, ``--resume`` completes the campaign with the board's own records.
"""

import io
import json
import shutil
from collections import Counter

import pytest

from hbench.cli.progress import ProgressLine
from hbench.errors import DeviceError
from hbench.rig import virtual
from hbench.store.campaign.folder import load_campaign
from hbench.untrusted_text import CONTROL
from hbench.workflow.watching import live
from tests.support.faults.fault_story import LAST, check_nothing_rewritten, data_file
from tests.support.faults.faulty_line import FLAGS, RUN, Script, World, attempts
from tests.support.faults.lying_line import KINDS, Lie, LyingLine, applies
from tests.support.rig_campaign import measure_on_rig

STAGES = (  # each stage of a session: the request, and which of its replies
    *(("identify", 1), ("status", 1), ("write_settings", 2), ("write_segment", 1)),
    *(("write_step", 1), ("status", 2), ("start", 1), ("status", 6), ("read_log", 1)),
    *(("read_log", 9), ("status", 12), ("status", 20), ("read_log", 25)),
)
LONGEST_S = 60.0  # of the bench, for a session with a lying board
ALL = [
    Lie(kind, message, number, once)
    for kind in KINDS
    for message, number in STAGES
    if applies(kind, message)
    for once in (False, True)
]


@pytest.fixture
def tell(quick_experiment, tmp_path, clock, monkeypatch):
    """Function that plays a lie and then the truth; returns how the first session ended."""
    monkeypatch.setattr(live, "EVERY_S", 0.0)
    written = []
    monkeypatch.setattr(live, "write_live", lambda folder, state: written.append(strict(state)))

    def session(line, folder) -> str:
        shown = io.StringIO()
        with monkeypatch.context() as patch:
            patch.setattr(virtual, "VirtualRig", lambda *_: line)
            try:
                measure_on_rig(
                    quick_experiment,
                    folder,
                    resume=(folder / "campaign.yaml").exists(),
                    take_over=True,
                    clock=clock,
                    report=ProgressLine(shown),
                )
            except DeviceError as error:
                assert error.message
                return error.message
            finally:
                assert not CONTROL.search(shown.getvalue())
        return ""

    def play(lie: Lie, number: int = 0) -> str:
        folder = tmp_path / f"{number}"
        world = World(quick_experiment.bench, Script())
        line = LyingLine(world, lie)
        ended = session(line, folder)
        assert line.now() < LONGEST_S
        before = check_nothing_rewritten(folder, {})
        world.wait(3.0)
        for _ in range(2):  # a board that faulted is cleared, a false fault is not there
            if not (ended and session(LyingLine(world, Lie("NaN", "none")), folder)):
                break
        check_nothing_rewritten(folder, before)
        check_logs(folder, quick_experiment, attempts(world.truth.words()))
        world.rig.close()
        shutil.rmtree(folder)
        return "no lie" if not line.lies else "an error" if ended else "nothing changed"

    yield play


def strict(state) -> str:
    text = json.dumps(state, allow_nan=False)
    assert not CONTROL.search(text)
    return text


def check_logs(folder, experiment, motions):
    """The last word on each run is that it is done, with the records of a whole motion."""
    journal = load_campaign(folder)
    assert journal.done == {plan.run for plan in experiment.plans}
    whole = {(int(a[0, RUN]), data_file(a)) for a in motions if a[-1, FLAGS] & LAST}
    for run in journal.done:
        assert (int(run), (folder / "runs" / f"{run}.dat").read_bytes()) in whole


def sweep(tell, lies):
    outcomes = Counter()
    for number, lie in enumerate(lies):
        try:
            outcomes[tell(lie, number)] += 1
        except BaseException as error:
            error.add_note(repr(lie))
            raise
    print(f"\n{len(lies)} lies: {dict(outcomes)}")
    return outcomes


def test_a_lie_at_any_stage_ends_in_an_error_or_changes_nothing(tell):
    outcomes = sweep(tell, ALL[:: len(ALL) // 25])
    assert outcomes["an error"] >= 12


@pytest.mark.slow
def test_each_lie_at_each_stage_ends_in_an_error_or_changes_nothing(tell):
    sweep(tell, ALL)
