"""Frames: round trip, detection of damage, resynchronisation of the receiver."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hbench.protocol.dictionary import MAX_FRAME
from hbench.protocol.frames import Frame, Receiver, crc16, encode

frames = st.builds(
    Frame, st.integers(0, 255), st.integers(0, 255), st.binary(max_size=MAX_FRAME - 4)
)


def test_crc_is_ccitt_false_by_its_published_check_value():
    assert crc16(b"123456789") == 0x29B1


@given(frames, st.lists(st.integers(1, 40)))
def test_a_frame_is_received_whatever_pieces_it_arrives_in(frame, cuts):
    octets = encode(frame)
    assert octets.index(0) == len(octets) - 1
    receiver, received = Receiver(), []
    for cut in [*cuts, len(octets)]:
        piece, octets = octets[:cut], octets[cut:]
        received += receiver.feed(piece)
    assert received == [frame]
    assert receiver.damaged == 0


@given(frames, st.data())
def test_a_flipped_bit_never_yields_another_frame(frame, data):
    octets = bytearray(encode(frame))
    position = data.draw(st.integers(0, len(octets) - 1))
    octets[position] ^= 1 << data.draw(st.integers(0, 7))
    received = Receiver().feed(bytes(octets) + b"\0")
    assert received in ([], [frame])


@given(st.binary(max_size=300), frames)
def test_the_receiver_decodes_the_next_frame_after_garbage(garbage, frame):
    assert Receiver().feed(garbage + b"\0" + encode(frame))[-1] == frame


def test_a_stream_without_a_terminator_does_not_grow_the_buffer():
    receiver = Receiver()
    for _ in range(100):
        receiver.feed(b"\x01" * 1000)
    assert len(receiver._pending) <= 2 * MAX_FRAME


def test_a_frame_longer_than_the_limit_is_refused():
    with pytest.raises(ValueError, match=str(MAX_FRAME)):
        encode(Frame(0, 1, bytes(MAX_FRAME - 3)))
