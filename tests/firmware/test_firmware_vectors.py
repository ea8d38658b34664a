"""Test vectors of ``tests/protocol/vectors.txt`` for the core."""

import ctypes

import numpy as np
import pytest

from hbench.protocol.codec import BY_NAME, pack
from hbench.rig import firmware
from tests.support.board import wire_vectors as wire

FRAMES = {(frame.message, frame.side, frame.sequence): frame for frame in wire.frames()}
KINDS = {"u16": b"u", "u32": b"l", "f32": b"f"}


class Core:
    """Readers, writers and frames of the core."""

    def __init__(self):
        library = firmware.load_library()
        octets, count, octet = ctypes.c_char_p, ctypes.c_uint16, ctypes.c_ubyte
        for name, result, arguments in (
            ("frame", count, (octet, octet, octets, count, octets)),
            ("receive", count, (octets, count, octets)),
            ("get", ctypes.c_double, (ctypes.c_char, octets, count)),
            ("put", count, (ctypes.c_char, ctypes.c_double, octets)),
            ("put_text16", count, (octets, octets)),
        ):
            function = getattr(library, f"hb_probe_{name}")
            function.restype, function.argtypes = result, arguments
        self._library = library
        self._out = ctypes.create_string_buffer(1024)

    def frame(self, sequence, code, payload):
        count = self._library.hb_probe_frame(sequence, code, payload, len(payload), self._out)
        return self._out.raw[:count]

    def receive(self, octets):
        count = self._library.hb_probe_receive(octets, len(octets), self._out)
        return self._out.raw[:count]

    def get(self, kind, octets):
        return self._library.hb_probe_get(KINDS[kind], octets, len(octets))

    def put(self, kind, value):
        if kind == "text16":
            count = self._library.hb_probe_put_text16(value.encode("ascii"), self._out)
        elif kind in wire.TAILS:
            return b"".join(self.put(wire.TAILS[kind], item) for item in value)
        else:
            count = self._library.hb_probe_put(KINDS[kind], value, self._out)
        return self._out.raw[:count]


@pytest.fixture(scope="module")
def core():
    return Core()


@pytest.mark.parametrize("octets, value", [(wire.octets_of(k), v) for k, v in wire.rows("crc")])
def test_crc(probes, octets, value):
    assert probes.crc(octets) == int.from_bytes(value, "big")


@pytest.mark.parametrize("plain, block", [(wire.octets_of(k), v) for k, v in wire.rows("cobs")])
def test_stuffing(probes, plain, block):
    assert probes.cobs_encode(plain) == block
    assert probes.cobs_decode(block) == plain


@pytest.mark.parametrize("kind, text, octets", [(k, *row) for k in KINDS for row in wire.rows(k)])
def test_numbers(core, kind, text, octets):
    value = wire.value_of(kind, text)
    assert core.put(kind, value) == octets
    assert wire.packed(kind, type(value)(core.get(kind, octets))) == octets


@pytest.mark.parametrize("text, octets", wire.rows("text16"))
def test_text(core, text, octets):
    assert core.put("text16", text) == octets


@pytest.mark.parametrize("key", FRAMES, ids=str)
def test_frames(core, key):
    frame = FRAMES[key]
    payload = b"".join(core.put(kind, frame.values[name]) for name, kind, _ in frame.fields)
    assert payload == frame.payload
    assert core.frame(frame.sequence, frame.code, payload) == frame.stuffed
    assert core.receive(frame.stuffed) == bytes([frame.sequence, frame.code]) + payload


@pytest.mark.parametrize(
    "request_key, reply_key",
    [
        (("write_settings", "request", 0x00), ("write_settings", "reply", 0x00)),
        (("start", "request", 0x10), ("refusal", "reply", 0x10)),
        (("stop", "request", 0x0A), ("stop", "reply", 0x0A)),
        (("clear_fault", "request", 0x0D), ("clear_fault", "reply", 0x0D)),
        (("read_log", "request", 0x81), ("read_log", "reply", 0x81)),
    ],
    ids=lambda key: key[0],
)
def test_a_board_from_reset_answers_octet_by_octet(new_board, request_key, reply_key):
    board = new_board().firmware
    board.receive(FRAMES[request_key].stuffed)
    board.poll()
    assert board.transmit() == FRAMES[reply_key].stuffed


@pytest.mark.parametrize("name", ["write_segment", "write_step"])
def test_random_steps_have_the_same_octets_on_both_sides(core, name):
    random = np.random.default_rng(1)
    draws = {
        "u16": lambda: int(random.integers(0, 65536)),
        "f32": lambda: float(np.float32(random.normal() * 10.0 ** random.integers(-30, 30))),
    }
    fields = BY_NAME[name].request
    for _ in range(100):
        values = {field: draws[kind]() for field, kind in fields}
        payload = pack(fields, values)
        assert payload == b"".join(core.put(kind, values[field]) for field, kind in fields)
        at = 0
        for field, kind in fields:
            size = len(core.put(kind, 0))
            assert core.get(kind, payload[at : at + size]) == values[field], field
            at += size
