"""The core with a 16-bit int and under sanitizers.

The output must equal that of a recorded session with the host library, bit for bit.
"""

import os
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from hbench.protocol.dictionary import CONDITIONS, RECORD, RECORD_FLAGS

SANITIZERS = "-O0 -g -fsanitize=address,undefined,float-cast-overflow -fno-sanitize-recover=all"
# 64 KB of RAM, which only the emulated chip has (avr.c).
AVR = "-mmcu=atmega1284p -Os -Wl,--defsym=__DATA_REGION_LENGTH__=0xFE00,--defsym=__stack=0xFFFF"
# The ring has one octet more than avr-gcc's ptrdiff_t can count; no pointers are so far apart.
AVR += " -Wno-alloc-size-larger-than"
# Like the C28x: octets as wide as int, with undefined upper bits.
C28X_LIKE = ["-DHB_OCTET=unsigned short", "-Wall", "-Wextra", "-Wconversion", "-Werror"]


def pull_log(board) -> np.ndarray:
    """All records in the ring."""
    first, end, records = board.read_log(0)
    while first + len(records) < end:
        records = np.vstack((records, board.read_log(first + len(records))[2]))
    return records


@pytest.fixture(scope="module")
def session(recorded_board):
    """A session with every request, most refusals, three complete runs, a stop and a fault."""
    board = recorded_board
    rng = np.random.default_rng(1)

    def ticks(count, speed=0.0):
        for _ in range(count):
            board.si["x"] += speed * 1e-4
            board.si["p_lr"] = 1.5e6 + rng.normal(scale=1e5)
            board.si["p_lp"] = 4.0e6 + rng.normal(scale=1e5)
            board.tick()

    board.settings_crc, board.segments_octets, board.steps_octets = 0, b"", b""
    board.request("identify")
    assert board.start() == "not_ready"
    assert board.request("identify", b"?") == "bad_payload"
    changes = {"heartbeat_s": 0.2, "acceleration_m_s2": 1.0, "feedforward_on": 1.0}
    board.write_settings(log_divider=3.0, **changes)
    for write, most in ((board.write_segment, 104), (board.write_step, 128)):
        assert [write(n) for n in range(most + 1)] == most * [b""] + ["out_of_range"]
    assert board.write_motion(trials=2, a_m_s2=2.0, duration_s=0.16) == b""
    ticks(3)
    board.settings_crc ^= 1
    assert board.start() == "settings_differ"
    board.settings_crc ^= 1
    board.exchange(b"\x05line noise\x00")
    board.firmware.receive(b"?\n")
    board.firmware.poll()
    assert b"state idle" in board.firmware.transmit()
    assert board.start() == board.start(again=True) == b""
    assert board.start() == "busy"
    for _ in range(2):
        ticks(1600)  # return and hold
        board.request("status")
        for _ in range(4):
            ticks(400, speed=0.1)
            board.request("status")
        ticks(1200)  # to brake
        board.request("status")
        ticks(800, speed=-0.2)
        board.request("status")
    assert board.start() == b""
    ticks(100)
    board.request("stop")
    records = pull_log(board)
    board.firmware.skip_ticks(65000)
    board.rest(0.1, x=0.05)  # past 65536 ticks
    row = ({}, {"valves": 1}, {"v_m_s": -0.1})
    row = [{"duration_s": 0.02, **segment} for segment in row]
    until = CONDITIONS.index("friction")
    assert board.write_row(*row, run=3, cycles=9, until=until, within=0.5) == b""
    assert board.start() == b""
    for _ in range(5):
        ticks(1000)
        board.request("status")
    records = np.vstack((records, pull_log(board)))
    assert board.start() == b""
    ticks(2200)  # without a request
    assert board.start() == "fault_latched"
    board.request("status")
    assert board.request("clear_fault") == b""
    board.request("status")
    script, output = board.firmware.script, bytes(board.firmware.output)
    return SimpleNamespace(script=script, output=output, records=records)


def test_the_session_covers_runs_flags_and_ring(session):
    words = dict(zip((word.name for word in RECORD), session.records.T, strict=True))
    assert set(words["run"]) == {1, 2, 3}
    assert words["flags"][-1] == 1 << RECORD_FLAGS.index("last") | 1 << RECORD_FLAGS.index(
        "settled"
    )
    assert len(session.records) == 2 * 1024, "the ring must have wrapped"
    assert len(set(words["u_l1"])) > 300, "the valves must have moved"


def test_sanitizers_stay_silent(session, build, run, tmp_path, require_tool):
    program = build(tmp_path / "play", require_tool("gcc"), *SANITIZERS.split())
    quiet = os.environ | {"ASAN_OPTIONS": "detect_leaks=0"}  # needs permission to trace
    done = run(program, input=session.script, env=quiet)
    assert done.stderr == b""
    assert done.stdout == session.output


def test_sixteen_bit_integers_make_no_difference(session, build, run, tmp_path, require_tool):
    image = build(tmp_path / "play.elf", require_tool("avr-gcc"), *C28X_LIKE, *AVR.split())
    require_tool("simavr")
    source, emulator = Path(__file__).with_name("avr.c"), tmp_path / "avr"
    run(require_tool("gcc"), "-O2", "-Wall", "-Werror", source, "-lsimavr", "-o", emulator)
    assert run(emulator, image, input=session.script).stdout == session.output
