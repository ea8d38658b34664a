"""The client survives a bad line, refuses strangers and never mistakes one answer for another."""

from collections.abc import Callable

import numpy as np
import pytest

from hbench.errors import DeviceError
from hbench.protocol.codec import BY_NAME, pack, unpack
from hbench.protocol.dictionary import ERROR, RECORD, REFUSALS, REPLY
from hbench.protocol.frames import Frame, Receiver, encode
from hbench.rig.client import (
    ATTEMPTS,
    PULL_WINDOW,
    REPLY_TIMEOUT_S,
    BoardClient,
    NoAnswer,
    Refused,
)
from tests.support.board.paper import IDENTITY


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


@pytest.mark.parametrize("fields", [-1, 4, None], ids=["one less", "head alone", "more"])
def test_another_dictionary_is_refused_by_name_however_long_its_answer(fields):
    kept = BY_NAME["identify"].reply[:fields]
    other = IDENTITY | {"dictionary": 0xABCD}
    payload = pack(kept, {name: other[name] for name, _ in kept}) + b"\x09\0" * (fields is None)
    line = Line(lambda frame: encode(Frame(frame.sequence, frame.code | REPLY, payload)))
    with pytest.raises(DeviceError, match="'test 1' on board 'paper' .*dictionary 0000abcd"):
        BoardClient(line).identify()


def test_a_lost_answer_is_asked_for_again_with_the_same_sequence():
    losses = [b"", b"\x00garbage\x00"]
    line = Line(lambda frame: losses.pop() if losses else reply(frame, "identify", IDENTITY))
    BoardClient(line).identify()
    assert len(line.requests) == 3
    assert len({frame.sequence for frame in line.requests}) == 1


def test_silence_ends_in_a_device_error_after_all_attempts():
    line = Line(lambda frame: b"")
    with pytest.raises(NoAnswer, match="'status'") as error:
        BoardClient(line).status()
    assert len(line.requests) == ATTEMPTS
    assert error.value.exit_code == 3


def test_a_late_answer_to_an_earlier_request_is_not_taken():
    def answer(frame):
        late = Frame((frame.sequence - 1) % 256, frame.code | REPLY, b"")
        return encode(late) + reply(frame, "identify", IDENTITY)

    assert BoardClient(Line(answer)).identify().firmware == "test 1"


def test_a_refusal_is_told_in_words():
    code = "settings_differ"
    number = REFUSALS.index(code).to_bytes(2, "little")
    line = Line(lambda f: encode(Frame(f.sequence, ERROR, bytes([f.code, 0]) + number)))
    with pytest.raises(Refused, match=f"'start': {code.replace('_', ' ')}"):
        BoardClient(line).start(1, 2)


def test_a_reply_of_the_wrong_length_is_a_device_error():
    line = Line(lambda f: encode(Frame(f.sequence, f.code | REPLY, b"\1\2\3")))
    with pytest.raises(DeviceError, match="reply to 'status'"):
        BoardClient(line).status()


class Ring:
    """A board's log: record n has n in all its words; those before ``oldest`` are gone."""

    def __init__(self, oldest=0, following=10_000):
        self.oldest, self.following = oldest, following

    def __call__(self, frame):
        request = unpack(BY_NAME["read_log"].request, frame.payload)
        first = max(request["first"], self.oldest)
        numbers = np.arange(first, min(first + request["count"], self.following))
        values = {
            "first": first,
            "next": self.following,
            "words": np.repeat(numbers % 65536, len(RECORD)),
        }
        return reply(frame, "read_log", values)


def numbers(part):
    """The numbers of a part's records, as they stand in their words."""
    assert (part.words == part.words[:, :1]).all()
    assert len(part.words) == 0 or part.words[0, 0] == part.first
    return part.words[:, 0].tolist()


@pytest.mark.parametrize("window", [1, PULL_WINDOW])
def test_a_pull_brings_each_record_once_and_in_order(window):
    line = Line(Ring())
    parts = list(BoardClient(line).pull(7, 110, window))
    assert [n for part in parts for n in numbers(part)] == list(range(7, 110))
    assert {part.lost for part in parts} == {0}
    assert len(line.requests) == 15  # 7 records each, 5 in the last
    assert len({frame.sequence for frame in line.requests}) == 15


def test_a_pull_of_nothing_asks_for_nothing():
    line = Line(Ring())
    assert list(BoardClient(line).pull(7, 7)) == []
    assert line.requests == []


class SlowLine(Line):
    """Answers one request a look at it, and counts the octets that wait for the board."""

    most_waiting = 0

    def write(self, data):
        self.inbox = getattr(self, "inbox", [])
        self.inbox.append(data)
        self.most_waiting = max(self.most_waiting, len(b"".join(self.inbox)))

    def read(self, timeout_s):
        while self.inbox and not self.waiting:
            super().write(self.inbox.pop(0))
            self.time += 0.001
        return super().read(timeout_s)


def test_a_pull_keeps_its_window_full_and_what_waits_for_the_board_fits_its_buffer():
    line = SlowLine(Ring())
    pull = BoardClient(line).pull(0, 800)
    for _ in range(50):
        next(pull)
        assert len(line.inbox) == PULL_WINDOW - 1
    assert line.most_waiting == 48 <= 64


@pytest.mark.parametrize("seed", range(5))
def test_what_a_bad_line_lost_is_asked_again_alone(seed):
    """One frame in five is lost or damaged, half of them requests, half replies."""
    random = np.random.default_rng(seed)
    spoiled = 0

    class BadLine(SlowLine):
        def spoil(self, data):
            nonlocal spoiled
            fate = random.random()
            if not data or fate > 0.1:
                return data
            spoiled += 1
            return b"" if fate < 0.05 else bytes([data[0] ^ 1]) + data[1:]

        def write(self, data):
            super().write(self.spoil(data))

        def read(self, timeout_s):
            return self.spoil(super().read(timeout_s))

    line = BadLine(Ring())
    parts = list(BoardClient(line).pull(0, 1400))
    assert [n for part in parts for n in numbers(part)] == list(range(1400))
    heard = len(line.requests)
    assert spoiled > 20
    assert heard <= 200 + spoiled, "the board hears each once, and again for each reply lost"


def test_a_lost_reply_costs_no_wait_while_others_follow():
    lost = {3, 4, 11}

    def answer(frame):
        octets = Ring()(frame)
        return b"" if len(line.requests) in lost else octets

    line = SlowLine(answer)
    parts = list(BoardClient(line).pull(0, 160))
    assert [n for part in parts for n in numbers(part)] == list(range(160))
    assert line.time < REPLY_TIMEOUT_S


def test_the_last_reply_lost_is_asked_for_after_the_deadline():
    line = Line(lambda frame: Ring()(frame) if len(line.requests) > 1 else b"")
    (part,) = BoardClient(line).pull(0, 7)
    assert numbers(part) == list(range(7))
    assert REPLY_TIMEOUT_S < line.time < 2 * REPLY_TIMEOUT_S


@pytest.mark.parametrize("oldest", [1, 8, 13, 64, 159])
def test_overwritten_records_are_told_with_their_count(oldest):
    parts = list(BoardClient(Line(Ring(oldest))).pull(0, 160))
    assert sum(part.lost for part in parts) == oldest
    assert [n for part in parts for n in numbers(part)] == list(range(oldest, 160))


def test_a_ring_that_overtakes_the_pull_leaves_no_record_unaccounted():
    """Records are overwritten half as fast again as they come."""
    ring = Ring(0, 0)

    def answer(frame):
        ring.oldest += 12
        ring.following = ring.oldest + 1024
        return ring(frame)

    at = 0
    for part in BoardClient(Line(answer)).pull(0, 2000):
        assert part.first == at + part.lost
        assert len(numbers(part)) == len(part.words)
        at = part.first + len(part.words)
    assert at == 2000


def test_records_that_are_all_gone_are_not_asked_for_one_by_one():
    line = Line(Ring(oldest=5000))
    parts = list(BoardClient(line).pull(0, 4000))
    assert sum(part.lost for part in parts) == 4000
    assert sum(len(part.words) for part in parts) == 0
    assert len(line.requests) == PULL_WINDOW


@pytest.mark.parametrize(
    ("first", "count"), [(6, 7), (7, 6), (7, 0)], ids=["too early", "too few", "none"]
)
def test_records_other_than_asked_for_are_a_device_error(first, count):
    values = {"first": first, "next": 99, "words": np.zeros(count * len(RECORD))}
    with pytest.raises(DeviceError, match=r"\b7 to 13\b"):
        list(BoardClient(Line(lambda f: reply(f, "read_log", values))).pull(7, 14))


def test_words_that_are_no_whole_records_are_a_device_error():
    values = {"first": 0, "next": 1, "words": np.zeros(len(RECORD) + 1)}
    with pytest.raises(DeviceError, match=r"line: .*\bwords\b"):
        list(BoardClient(Line(lambda f: reply(f, "read_log", values))).pull(0, 1))


def test_a_pull_that_is_left_leaves_no_answer_for_the_next_request():
    def answer(frame):
        is_log = frame.code == BY_NAME["read_log"].code
        return Ring()(frame) if is_log else reply(frame, "identify", IDENTITY)

    client = BoardClient(SlowLine(answer))
    next(client.pull(0, 800))
    assert client.identify().firmware == "test 1"


@pytest.mark.parametrize(
    "chatter",
    [
        b"$GPGGA,123519,4807.038,N*47\r\n",
        b"\0" * 40,
        b"\x05\x01\x81\x00\x00\0",
        bytes(range(256)),
    ],
    ids=["text", "zeros", "damaged frame", "every octet"],
)
def test_a_device_that_is_no_board_is_told_so(chatter):
    with pytest.raises(NoAnswer, match="line: .*'identify'") as error:
        BoardClient(Line(lambda frame: chatter)).identify()
    assert "port" in error.value.hint


def test_a_device_that_echoes_is_no_board():
    with pytest.raises(NoAnswer):
        BoardClient(Line(encode)).identify()
