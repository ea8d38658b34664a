"""Plays a fault script until its campaign is complete, and checks the campaign against the board.

The host of a session is killed in-process: from then on neither its port nor its disk does
anything for it, so no clean-up of its own can help.
"""

import hashlib
import os
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from hbench.errors import DeviceError
from hbench.protocol.dictionary import RECORD_FLAGS as FLAG_NAMES
from hbench.rig import virtual
from hbench.store.campaign import writer
from hbench.store.campaign.folder import load_campaign
from hbench.store.files import atomic
from tests.support.faults.faulty_line import FLAGS, INDEX, RUN, Killed, Script, World, attempts
from tests.support.rig_campaign import measure_on_rig

LAST = 1 << FLAG_NAMES.index("last")
MOST_SESSIONS = 150  # most of them while the port is gone, by an operator without patience


@dataclass
class Story:
    """What came of a script."""

    sessions: int = 0
    injected: Counter = field(default_factory=Counter)
    errors: list[str] = field(default_factory=list)


def play(script: Script, experiment, folder: Path, clock) -> Story:
    """Run and resume a campaign under a script until it is complete; check it."""
    world = World(experiment.bench, script)
    story, before = Story(injected=world.counts), {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(virtual, "VirtualRig", lambda *_: world.open())
        while True:
            story.sessions += 1
            assert story.sessions <= MOST_SESSIONS, story.errors
            with patch.context() as mortal:
                mortal_disk(mortal, world)
                complete = session(experiment, folder, clock, story)
            before = check_nothing_rewritten(folder, before)
            if complete:
                break
            world.wait(script.pauses_s[story.sessions % len(script.pauses_s)])
    world.wait(3.0)
    check_against_board(folder, experiment, attempts(world.truth.words()))
    world.rig.close()
    return story


def session(experiment, folder: Path, clock, story: Story) -> bool:
    """Run or resume; True when the campaign is complete. Any other error than these is a bug."""
    try:
        measure_on_rig(experiment, folder, resume=(folder / "campaign.yaml").exists(), clock=clock)
    except DeviceError as error:
        story.errors.append(error.message)
        return False
    except (Killed, KeyboardInterrupt) as end:
        story.errors.append(type(end).__name__)
        return False
    return True


def mortal_disk(patch, world: World) -> None:
    """Let the host die in the middle of a write, as its script says; the dead write nothing.

    Flushing is left out: a killed process loses nothing that it has given to the system.
    """
    writes = iter(range(10**6))
    rename = writer.rename

    def dies() -> bool:
        world.check_alive()
        kill = world.kill()
        return bool(kill) and kill.write is not None and kill.write == next(writes)

    def mortal_flush(file):
        before = os.fstat(file.fileno()).st_size
        file.flush()
        if dies():
            written = os.fstat(file.fileno()).st_size - before
            os.ftruncate(file.fileno(), before + round(world.kill().part * written))
            world.die()

    def mortal_rename(path, name):
        end = dies()
        if not end or world.kill().part > 0.5:
            rename(path, name)
        if end:
            world.die()

    def mortal_flush_folder(folder):
        if dies():
            world.die()

    patch.setattr(atomic, "_flush", mortal_flush)
    patch.setattr(atomic, "_flush_folder", mortal_flush_folder)
    patch.setattr(writer, "rename", mortal_rename)


def check_nothing_rewritten(folder: Path, before: dict) -> dict:
    """Every log of before is still there, byte for byte, and the journal only grew."""
    after = {"logs": Counter(), "journal": b""}
    for path in (folder / "runs").glob("[!.]*"):
        after["logs"][hashlib.sha256(path.read_bytes()).hexdigest()] += 1
    if (folder / "campaign.yaml").exists():
        after["journal"] = (folder / "campaign.yaml").read_bytes()
    if before:
        assert not before["logs"] - after["logs"]
        old = before["journal"]
        whole = old[: old.rfind(b"\n- run:") + 1] if b"\n- run:" in old else b""
        assert after["journal"].startswith(whole)
    return after


def data_file(words: np.ndarray) -> bytes:
    """A Code Composer Studio data file, hex, written out by hand."""
    digits = "".join(f"{word:04x}\n" for word in words.ravel().tolist())
    return f"1651 1 0 0 {words.size:x}\n{digits}".encode()


def check_against_board(folder: Path, experiment, motions: list[np.ndarray]) -> None:
    """Each run is done once, its log the board's own; what failed is part of what was logged."""
    journal = load_campaign(folder)
    assert not journal.warnings
    plans = [plan.run for plan in experiment.plans]
    finished = [e.plan.run for e in journal.entries if e.stop and e.stop.outcome == "done"]
    assert sorted(finished) == plans

    by_run = {run: [a for a in motions if a[0, RUN] == int(run)] for run in plans}
    for attempt in motions:
        assert (attempt[:, INDEX] == np.arange(len(attempt))).all()
    for run in plans:
        final = by_run[run][-1]
        assert final[-1, FLAGS] & LAST, f"run {run}: the board made it again after it was done"
        assert (folder / "runs" / f"{run}.dat").read_bytes() == data_file(final)
        kept = {p.name: p.read_bytes() for p in (folder / "runs").glob(f"{run}~*.dat")}
        for name, data in kept.items():
            words = data.count(b"\n") - 1
            assert any(data == data_file(a[: words // a.shape[1]]) for a in by_run[run]), (
                f"{name} is not the beginning of any attempt"
            )
        entries = [entry for entry in journal.entries if entry.plan.run == run]
        hashes = {hashlib.sha256(data).hexdigest() for data in kept.values()}
        for entry in entries[:-1]:
            assert entry.stop is None or (entry.stop.why and entry.stop.sha256 in hashes)
        assert entries[-1].stop.outcome == "done"
        assert len(kept) <= len(entries) - 1
