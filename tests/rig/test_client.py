"""The client survives a bad line, refuses strangers and never mistakes one answer for another."""

from collections.abc import Callable

import numpy as np
import pytest

from hbench.errors import DeviceError
from hbench.protocol.codec import BY_NAME, pack
from hbench.protocol.dictionary import ERROR, RECORD, REFUSALS, REPLY, dictionary_hash
from hbench.protocol.frames import Frame, Receiver, encode
from hbench.rig.client import ATTEMPTS, BoardClient, Refused

IDENTITY = {
    "protocol": 1,
    "dictionary": dictionary_hash(),
    "firmware": "test 1",
    "board": "paper",
    "boots": 3,
    "rate_hz": 10000,
    "ring_records": 1024,
    "max_steps": 128,
    "max_segments": 128,
}


class Line:
    """A port whose far end is a function from a request's frame to answering octets."""

    name = "line"

    def __init__(self, answer: Callable[[Frame], bytes]):
        self.answer = answer
        self.receiver = Receiver()
        self.waiting = b""
        self.time = 0.0
        self.requests: list[Frame] = []

    def write(self, data):
        for frame in self.receiver.feed(data):
            self.requests.append(frame)
            self.waiting += self.answer(frame)

    def read(self, timeout_s):
        data, self.waiting = self.waiting, b""
        self.time += 0.001 if data else timeout_s
        return data

    def now(self):
        return self.time

    def close(self):
        pass


def reply(frame: Frame, name: str, values: dict) -> bytes:
    payload = pack(BY_NAME[name].reply, values)
    return encode(Frame(frame.sequence, frame.code | REPLY, payload))


def test_identify_reads_who_is_there():
    client = BoardClient(Line(lambda frame: reply(frame, "identify", IDENTITY)))
    identity = client.identify()
    assert (identity.firmware, identity.board, identity.max_steps) == ("test 1", "paper", 128)


@pytest.mark.parametrize("change", [{"protocol": 2}, {"dictionary": 1}])
def test_another_dictionary_is_refused_by_name(change):
    client = BoardClient(Line(lambda frame: reply(frame, "identify", IDENTITY | change)))
    with pytest.raises(DeviceError, match="'test 1' on board 'paper'"):
        client.identify()


def test_a_lost_answer_is_asked_for_again_with_the_same_sequence():
    losses = [b"", b"\x00garbage\x00"]
    line = Line(lambda frame: losses.pop() if losses else reply(frame, "identify", IDENTITY))
    BoardClient(line).identify()
    assert len(line.requests) == 3
    assert len({frame.sequence for frame in line.requests}) == 1


def test_silence_ends_in_a_device_error_after_all_attempts():
    line = Line(lambda frame: b"")
    with pytest.raises(DeviceError, match="no answer to 'status'") as error:
        BoardClient(line).status()
    assert len(line.requests) == ATTEMPTS
    assert error.value.exit_code == 3


def test_a_late_answer_to_an_earlier_request_is_not_taken():
    def answer(frame):
        late = Frame((frame.sequence - 1) % 256, frame.code | REPLY, b"")
        return encode(late) + reply(frame, "identify", IDENTITY)

    assert BoardClient(Line(answer)).identify().firmware == "test 1"


def test_a_refusal_is_told_in_words():
    number = REFUSALS.index("settings_differ").to_bytes(2, "little")
    line = Line(lambda f: encode(Frame(f.sequence, ERROR, bytes([f.code, 0]) + number)))
    with pytest.raises(Refused, match="refused 'start': settings differ"):
        BoardClient(line).start(1, 2)


def test_a_reply_of_the_wrong_length_is_a_device_error():
    line = Line(lambda f: encode(Frame(f.sequence, f.code | REPLY, b"\1\2\3")))
    with pytest.raises(DeviceError, match="reply to 'status'"):
        BoardClient(line).status()


def test_log_records_come_as_rows():
    words = np.arange(2 * len(RECORD), dtype="<u2")
    values = {"first": 7, "next": 9, "words": words}
    part = BoardClient(Line(lambda f: reply(f, "read_log", values))).read_log(7)
    assert (part.first, part.next, part.words.shape) == (7, 9, (2, len(RECORD)))
    np.testing.assert_array_equal(part.words.ravel(), words)


def test_words_that_are_no_whole_records_are_a_device_error():
    values = {"first": 0, "next": 1, "words": np.zeros(len(RECORD) + 1)}
    with pytest.raises(DeviceError, match="not whole records"):
        BoardClient(Line(lambda f: reply(f, "read_log", values))).read_log(0)
