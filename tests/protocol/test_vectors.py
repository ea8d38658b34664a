"""Test vectors for the host's codec.

``wire_vectors.py`` computes them independently of the codec.
``tests/firmware/test_firmware_vectors.py`` applies them to the board.
"""

import pytest
from cobs import cobs

from hbench.protocol.codec import BY_NAME, pack, unpack
from hbench.protocol.dictionary import ERROR, MESSAGES, REPLY
from hbench.protocol.frames import Frame, Receiver, crc16, encode
from tests.support.board import wire_vectors as wire

FRAMES = wire.frames()
REFUSAL = (("request", "u16"), ("refusal", "u16"))
AT_RANDOM = {"write_segment", "write_step"}  # tests/firmware/test_firmware_vectors.py


def name_of(frame):
    return f"{frame.message}-{frame.side}-{frame.sequence:02X}"


def test_the_indented_lines_follow_from_those_above_them():
    assert wire.FILE.read_text() == wire.renewed(), (
        "run: python tests/support/board/wire_vectors.py"
    )


@pytest.mark.parametrize("octets, value", [(wire.octets_of(k), v) for k, v in wire.rows("crc")])
def test_crc(octets, value):
    assert wire.crc(octets) == crc16(octets) == int.from_bytes(value, "big")


@pytest.mark.parametrize("plain, block", [(wire.octets_of(k), v) for k, v in wire.rows("cobs")])
def test_stuffing(plain, block):
    assert wire.stuffed(plain) == cobs.encode(plain) == block
    assert wire.unstuffed(block) == cobs.decode(block) == plain


@pytest.mark.parametrize(
    "kind, text, octets",
    [(kind, *row) for kind in (*wire.NUMBERS, "text16") for row in wire.rows(kind)],
)
def test_fields(kind, text, octets):
    value = wire.value_of(kind, text)
    assert wire.packed(kind, value) == pack([("x", kind)], {"x": value}) == octets
    (back,) = unpack([("x", kind)], octets).values()
    assert wire.packed(kind, back) == octets  # -0.0 == 0.0, so the octets are compared
    assert back == value or kind == "f32"


@pytest.mark.parametrize("frame", FRAMES, ids=name_of)
def test_frame_lines_are_those_of_the_dictionary(frame):
    where = f"{wire.FILE.name}, line {frame.line}: correct it, then run wire_vectors.py"
    if frame.message == "refusal":
        code, fields = ERROR, REFUSAL
    else:
        message = BY_NAME[frame.message]
        code = message.code | (REPLY if frame.side == "reply" else 0)
        fields = getattr(message, frame.side)
    assert frame.code == code, where
    assert tuple((name, kind) for name, kind, _ in frame.fields) == fields, where


def test_every_message_is_there_with_request_and_reply():
    there = {(frame.message, frame.side) for frame in FRAMES}
    names = {message.name for message in MESSAGES} - AT_RANDOM
    assert there == {(n, s) for n in names for s in ("request", "reply")} | {("refusal", "reply")}


@pytest.mark.parametrize("frame", FRAMES, ids=name_of)
def test_frames(frame):
    assert (frame.plain, frame.stuffed) == wire.frame_octets(frame)
    fields = tuple((name, kind) for name, kind, _ in frame.fields)
    whole = Frame(frame.sequence, frame.code, frame.payload)
    assert pack(fields, frame.values) == frame.payload
    assert encode(whole) == frame.stuffed
    assert Receiver().feed(frame.stuffed) == [whole]
    for (name, kind), value in zip(fields, unpack(fields, frame.payload).values(), strict=True):
        assert wire.packed(kind, value) == wire.packed(kind, frame.values[name])
