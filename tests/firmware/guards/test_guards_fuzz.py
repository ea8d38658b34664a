"""Fuzzing of host and sensors; play.c contains the invariants."""

import re
import subprocess
from contextlib import contextmanager

import pytest
from cobs import cobs

from hbench.protocol.dictionary import CONDITIONS, MESSAGES

CODES = {message.name: message.code for message in MESSAGES}
CLANG = (
    "-g -DPLAY_FUZZ -fsanitize=fuzzer,address,undefined -fno-sanitize-recover=all "
    "-fno-sanitize-coverage=trace-cmp"  # it would take three quarters of the time
)
LIMITS = (
    "-seed=1 -max_len=1000 -detect_leaks=0 -timeout=20 -entropic_scale_per_exec_time=1 "
    # A process counts the peak of its parent, here of all tests before, as its own.
    "-rss_limit_mb=0 -malloc_limit_mb=100"
)
_ROUNDS = 3
# Files whose branches the scripts must cover.
REACHED = (
    "commands.c",
    "core.c",
    "link.c",
    "safety.c",
    "schedule.c",
    "steps.c",
    "vent.c",
    "wire.c",
)


@pytest.fixture
def seeds(recorded_board, tmp_path):
    """Folder of scripts of a correct host, with short runs."""
    board, folder = recorded_board, tmp_path / "corpus"
    folder.mkdir()
    quick = {"a_m_s2": 50.0, "duration_s": 0.01}

    @contextmanager
    def scene(name, **settings):
        board.firmware.rows.clear()
        board.request("stop")
        board.request("clear_fault")
        board.write_settings(log_divider=3.0, acceleration_m_s2=50.0, **settings)
        board.write_motion(trials=2, hold_s=0.0, **quick)
        board.tick()
        yield
        rows = (opened(row) for row in board.firmware.rows)
        (folder / name).write_bytes(b"".join(rows))

    def ticks(count):
        for _ in range(count):
            board.tick()

    with scene("requests"):
        for name in CODES:
            board.request(name)
        board.firmware.rows += [b"S\x01\x01\x00", b"S\x02\x00\x01", b"R\x03\n?\n"]
        board.exchange(b"\x05line noise\x00")
    with scene("runs"):
        board.start()
        board.start(again=True)
        ticks(2400)
        board.read_log(0)
    with scene("steps"):
        for _ in range(2):
            board.write_motion(1, run=3, v_m_s=-0.1, hold_s=0.0, **quick)
        board.start()
        ticks(3600)
    for until, name in enumerate(CONDITIONS):
        with scene(name):
            row = ({"v_m_s": 0.1, **quick}, {"valves": 1, **quick}, {"v_m_s": -0.1, **quick})
            board.write_row(*row, cycles=5, until=until, within=0.5, hold_s=0.0)
            board.start()
            ticks(2400)
    with scene("pushes"):
        push = {"valves": 2, "force_rate_n_s": 1e3, "displacement_m": 1e-3}
        board.write_row({**push, **quick}, {"valves": 1, **quick}, trials=2, hold_s=0.0)
        board.start()
        ticks(2400)
    with scene("vents"):
        vent = {"valves": 3, "a_m_s2": 50.0, "duration_s": 0.3}  # to both sides, 0.25 s each
        board.write_row(vent, {"valves": 1, **quick}, trials=2)
        board.si["p_s"] = 2e5
        ticks(500)  # the filter's lag
        board.start()
        ticks(3200)
        board.si["p_s"] = 1.5e7
        ticks(500)
        board.start(again=True)
        ticks(100)
    with scene("faults"):
        board.start()
        ticks(2)
        board.firmware.rows.append(b"O")
        board.request("clear_fault")
        board.start()
        board.si["x"] += 0.3
        ticks(2)
        board.si["x"] -= 0.3
    # Gains at the upper limit, with which every word drives the valves to their limits.
    most = {f"{loop}_gain_v_pa_s": 1.0 for loop in ("rod", "piston")}
    with scene("steep", velocity_gain_v_m=1e6, velocity_time_constant_s=60.0, **most):
        board.start()
        ticks(300)
    with scene("huge", velocity_gain_v_m=3e38):  # refused
        board.start()
        ticks(2)
    # The load's references do not arrive: 0.1 s of ramps, with a sensor that starts at -1e9 Pa.
    low = {"gain_p_lr": 1e-3, "offset_p_lr": -1e9, "pressure_max_pa": 4e6}
    with scene("load", pressure_slew_pa_s=1e10, heartbeat_s=9.0, **low):
        board.start()
        ticks(3900)
    return folder


def opened(row: bytes) -> bytes:
    """A command of a script; frames are decoded so that the fuzzer can change their fields."""
    if row[:1] != b"R":
        return row
    try:
        body = cobs.decode(row[2:-1])
    except cobs.DecodeError:
        return row
    if body[1] == CODES["start"] and len(body) == 8:
        return b"S" + body[:1] + b"\0\0"
    return b"F" + body[:2] + bytes((len(body) - 4,)) + body[2:-2]


def fuzz(runs, seeds, build, tmp_path, require_tool, optimize) -> str:
    """Run the fuzzer; returns its messages."""
    fuzzer = build(tmp_path / "fuzz", require_tool("clang"), optimize, *CLANG.split())
    command = [fuzzer, *LIMITS.split(), f"-runs={runs}", f"-artifact_prefix={tmp_path}/", seeds]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-5000:]
    return done.stderr


def test_no_input_violates_the_invariants(seeds, build, tmp_path, require_tool):
    fuzz(1000, seeds, build, tmp_path, require_tool, "-O0")  # -O2 takes longer to compile


@pytest.mark.parametrize(
    ("scripts", "least"),
    [
        pytest.param(500_000, 90, marks=pytest.mark.slow),
        pytest.param(10_000_000, 90, marks=pytest.mark.nightly),
    ],
)
def test_many_scripts_cover_the_branches(scripts, least, seeds, build, run, tmp_path, require_tool):
    """The choice of scripts depends on their duration, so chance decides which branches they miss.

    If they miss too many, as many others follow, twice at most.
    """
    program = build(tmp_path / "play", require_tool("gcc"), "--coverage")
    for _ in range(_ROUNDS):
        output = fuzz(scripts, seeds, build, tmp_path, require_tool, "-O2")
        print(output.splitlines()[-1])
        for script in seeds.iterdir():
            run(program, input=script.read_bytes())
        files = tmp_path.glob("*.gcda")
        text = run(require_tool("gcov"), "-b", *files, cwd=tmp_path).stdout.decode()
        parts = re.findall(r"File '.*?(\w+\.c)'\n.*\n.*\nTaken at least once:([\d.]+)%", text)
        taken = {name: float(dict(parts)[name]) for name in REACHED}
        print("branches taken [%]:", taken)
        if min(taken.values()) >= least:
            break
    assert min(taken.values()) >= least
