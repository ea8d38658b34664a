"""A command that is killed leaves its inputs as they were, and the next call completes.

Real processes, killed with SIGKILL at random moments.
"""

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from tests.support import ROOT

LIMIT_S = 300.0
GONE_S = 10.0
SAMPLE = ROOT / "data_samples" / "stribeck-small"
LEAKING = ROOT / "data_samples" / "blind" / "internal_leakage-clear-1"
MODEL = ROOT / "configs" / "model-aau.yaml"


class Command:
    """``hbench ...`` as the leader of a session."""

    def __init__(self, *arguments):
        self._process = subprocess.Popen(
            [sys.executable, "-m", "hbench", *map(str, arguments)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            start_new_session=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
        )

    def kill_after(self, seconds: float) -> bool:
        """Kill the first process alone; return whether it was still running."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)
        self._process.kill()
        killed = self._process.wait() == -signal.SIGKILL
        deadline = time.monotonic() + GONE_S
        while self._group_lives():
            assert time.monotonic() < deadline, "processes of the killed command go on"
            time.sleep(0.05)
        self._process.stderr.close()
        return killed

    def ended(self) -> tuple[int, str]:
        _, told = self._process.communicate(timeout=LIMIT_S)
        return self._process.returncode, told.decode()

    def _group_lives(self) -> bool:
        with suppress(ProcessLookupError):
            os.killpg(self._process.pid, 0)
            return True
        return False


def digest(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def exported(tmp_path: Path) -> Path:
    folder = tmp_path / "exported"
    assert Command("export", SAMPLE, "-o", folder).ended()[0] == 0
    return folder


def several(tmp_path: Path) -> Path:
    for number in range(6):
        shutil.copytree(SAMPLE, tmp_path / "line" / f"{number}")
    return tmp_path / "line"


# Input, then arguments with the output's folder, then the document in it.
COMMANDS = {
    "analyze": (lambda tmp: shutil.copytree(SAMPLE, tmp / "in"), ["report"], None),
    "import": (exported, ["import"], "campaign.yaml"),
    "identify": (lambda tmp: SAMPLE, ["identify"], None),
    "fleet": (several, ["fleet"], "fleet.json"),
    "reconcile": (lambda tmp: LEAKING, ["reconcile", "--model", MODEL], "diagnosis.json"),
}


def kill_often(name, kills, longest_s, tmp_path):
    make, command, document = COMMANDS[name]
    source = make(tmp_path)
    out = tmp_path / "out"
    own = name == "analyze"  # results are in the campaign's folder
    before = digest(source)
    rng = np.random.default_rng(1)
    outcomes = Counter()
    arguments = [*command, source, *([] if own else ["-o", out])]
    for _ in range(kills):
        killed = Command(*arguments).kill_after(rng.uniform(0.3, longest_s))
        outcomes["killed" if killed else "ended before"] += 1
        assert digest(source).items() >= before.items()
        for path in tmp_path.rglob("*.json"):
            json.loads(path.read_bytes())  # whole, where there is one
        if name == "import" and (out / "campaign.yaml").exists():
            shutil.rmtree(out)
    code, told = Command(*arguments).ended()
    assert code == 0, told
    assert digest(source).items() >= before.items()
    assert document is None or (out / document).stat().st_size > 100
    left = [path for path in tmp_path.rglob(".*") if path.name.endswith(".part")]
    print(f"\n{name}: {dict(outcomes)}, files left behind: {len(left)}")
    assert not left
    return outcomes


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "kills", "longest_s"),
    [
        ("import", 20, 1.5),
        ("analyze", 20, 4.0),
        ("identify", 20, 4.0),
        ("fleet", 20, 10.0),
        ("reconcile", 8, 40.0),
    ],
)
def test_a_command_that_is_killed_at_any_moment_changes_no_input_and_completes(
    tmp_path, name, kills, longest_s
):
    assert kill_often(name, kills, longest_s, tmp_path)["killed"] > kills / 2


@pytest.mark.slow
def test_of_two_fleets_at_once_one_is_refused_or_both_give_the_same_table(tmp_path):
    source, out = several(tmp_path), tmp_path / "out"
    both = [Command("fleet", source, "-o", out) for _ in range(2)]
    ended = [command.ended() for command in both]
    assert 0 in [code for code, _ in ended], ended
    for code, told in ended:
        assert code == 0 or (code == 2 and "in use by another hbench" in told), told
    assert json.loads((out / "fleet.json").read_text())["campaigns"] == 6
