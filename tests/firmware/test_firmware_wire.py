"""Frames compared with the standard library and the cobs package; the status line."""

import binascii

import numpy as np
import pytest
from cobs import cobs
from hypothesis import given, settings
from hypothesis import strategies as st

from hbench.protocol.codec import pack
from hbench.protocol.dictionary import (
    CRC_START,
    FAULTS,
    MAX_FRAME,
    MESSAGES,
    PROTOCOL,
    STATES,
    dictionary_hash,
)
from hbench.protocol.frames import Frame, Receiver, encode

# Long runs without zeros reach the block limit of 254.
data = st.one_of(
    st.binary(max_size=300),
    st.lists(st.sampled_from([0, 1, 255]), max_size=600).map(bytes),
    st.integers(250, 260).map(lambda n: b"\x01" * n),
    st.integers(250, 260).map(lambda n: b"\x01" * n + b"\0\0"),
)


def test_crc_has_the_published_check_value_of_ccitt_false(probes):
    assert probes.crc(b"123456789") == 0x29B1


@given(octets=data)
def test_crc_agrees_with_binascii(octets, probes):
    assert probes.crc(octets) == binascii.crc_hqx(octets, CRC_START)


@given(octets=data)
@settings(max_examples=300)
def test_stuffing_agrees_with_the_cobs_package(octets, probes):
    stuffed = probes.cobs_encode(octets)
    assert stuffed == cobs.encode(octets)
    assert probes.cobs_decode(stuffed) == octets


@given(octets=st.binary(min_size=1, max_size=300).map(lambda b: b.replace(b"\0", b"\7")))
def test_unstuffing_refuses_what_the_cobs_package_refuses(octets, probes):
    try:
        expected = cobs.decode(octets)
    except cobs.DecodeError:
        expected = b""
    assert probes.cobs_decode(octets) == expected


STATUS = next(message.code for message in MESSAGES if message.name == "status")


def answers(frames):
    return [(sequence, code) for sequence, code, _ in frames]


@pytest.mark.parametrize(
    "garbage",
    [
        b"\0\0\0",
        b"\xff" * 1000,
        bytes(range(256)) * 3,
        b"\x02\x07",
        b"\x01",
        b"\x05\x01\x01\x01\x01",
    ],
    ids=["zeros", "long", "all", "truncated", "single", "short"],
)
def test_board_decodes_the_next_frame_after_garbage(board, garbage):
    assert board.exchange(garbage + b"\0") == []
    assert answers(board.exchange(board.frame(9, STATUS))) == [(9, STATUS | 0x80)]


def test_random_garbage_is_never_answered(board):
    noise = np.random.default_rng(5).integers(0, 256, (300, 40), dtype=np.uint8)
    for octets in noise:
        assert board.exchange(octets.tobytes() + b"\0") == []


def test_a_frame_with_a_flipped_bit_is_not_answered(board):
    frame = board.frame(9, STATUS)
    for bit in range(8 * (len(frame) - 1)):
        damaged = bytearray(frame)
        damaged[bit // 8] ^= 1 << (bit % 8)
        assert board.exchange(bytes(damaged)) == [], f"bit {bit}"
        board.exchange(b"\0")


def test_octets_may_arrive_individually(board):
    frame = board.frame(1, STATUS)
    for octet in frame[:-1]:
        assert board.exchange(bytes([octet])) == []
    assert answers(board.exchange(frame[-1:])) == [(1, STATUS | 0x80)]


def test_the_longest_frame_is_answered_and_a_longer_frame_is_not(board):
    longest = bytes(MAX_FRAME - 4)
    ((_, code, payload),) = board.exchange(board.frame(1, STATUS, longest))
    assert (code, payload) == (0xFF, bytes([STATUS, 0, 2, 0]))  # bad payload
    assert board.exchange(board.frame(2, STATUS, longest + b"\0")) == []
    full = b"\x55" * (MAX_FRAME - 4)
    assert answers(board.exchange(board.frame(3, STATUS, full))) == [(3, 0xFF)]
    assert board.exchange(board.frame(4, STATUS, full)[:-1] + b"\x01\0") == []


def test_no_reply_is_lost_if_the_queue_to_the_host_is_full(board):
    count = 90  # replies of 52 octets: more than the port's queue of 4096 holds
    board.firmware.receive(b"".join(board.frame(n, 0x01) for n in range(count)))
    octets = b""
    for _ in range(3):
        board.firmware.poll()
        octets += board.firmware.transmit()
    sequences = [cobs.decode(chunk)[0] for chunk in octets.split(b"\0")[:-1]]
    assert sequences == list(range(count))


def line_of(board):
    """Text that a terminal shows after '?' and Enter."""
    version = f"protocol {PROTOCOL}, dictionary {dictionary_hash():08X}"
    status = board.status()
    state, fault = STATES[status["state"]], FAULTS[status["fault"]].replace("_", " ")
    return f"hbench-core 0.1 on host, {version}, state {state}, fault {fault}\r\n\0".encode()


def type_in(board, octets):
    board.firmware.receive(octets)
    board.firmware.poll()
    return board.firmware.transmit()


@pytest.mark.parametrize("enter", [b"\r", b"\n", b"\r\n"])
def test_a_question_mark_and_enter_get_one_line_of_text(new_board, enter):
    """For all end-of-line characters, repeatedly, and with frames in between."""
    board = new_board()
    line = line_of(board)
    for _ in range(2):
        assert type_in(board, b"?" + enter) == line
    assert type_in(board, b"?") == b""
    assert type_in(board, enter) == line
    board.exchange(b"\0")
    assert answers(board.exchange(board.frame(9, STATUS))) == [(9, STATUS | 0x80)]
    assert type_in(board, b"?" + enter) == line


def test_the_status_line_shows_a_fault(board):
    board.write_settings(heartbeat_s=0.1)
    board.start()
    board.rest(0.2, x=0.05)
    assert FAULTS[board.status()["fault"]] == "heartbeat"
    assert type_in(board, b"?\r") == line_of(board)


def test_a_question_from_a_terminal_is_no_heartbeat(board):
    board.write_settings(heartbeat_s=0.1)
    board.start()
    for _ in range(4):
        board.rest(0.05, x=0.05)
        type_in(board, b"?\r")
    assert FAULTS[board.status()["fault"]] == "heartbeat"


def test_a_host_drops_the_status_line_as_a_damaged_frame(new_board):
    board = new_board()
    receiver = Receiver()
    assert receiver.feed(type_in(board, b"?\r\n")) == []
    assert receiver.damaged == 1
    board.firmware.receive(b"\0" + board.frame(9, STATUS))
    board.firmware.poll()
    assert [frame.sequence for frame in receiver.feed(board.firmware.transmit())] == [9]


@pytest.mark.parametrize("typed", [b"\r\n", b"??\r", b"x?\r", b"?x\r", b" ?\r", b"help\r\n"])
def test_other_lines_are_not_answered(new_board, typed):
    board = new_board()
    assert type_in(board, typed) == b""
    assert type_in(board, b"?\r") == line_of(board), "and must be cleared"


def test_no_request_begins_like_a_typed_line():
    """The first octet of a frame is the distance to its first zero: short in all requests."""
    largest = {"u16": 255, "u32": 0xFFFFFFFF, "f32": 1.1}  # an index or count has a high octet 0
    for message in MESSAGES:
        values = {name: largest.get(kind, [1.1]) for name, kind in message.request}
        values |= {name: 0xFFFF for name in values if name.endswith("_crc")}
        frame = encode(Frame(1, message.code, pack(message.request, values)))
        assert frame[0] <= 9 < ord("\n") < ord("\r") < ord("?"), message.name
