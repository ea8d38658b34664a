"""A line to an honest board that lies from some reply on: the forms of the protocol hold, or not.

``LIES`` are the lies by name; a ``Lie`` says which one, at which reply to which request, and
whether the board then goes on lying.
"""

import struct
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from hbench.protocol.codec import BY_NAME, pack, unpack
from hbench.protocol.dictionary import ERROR, MESSAGES, RECORD, RECORD_FLAGS, REPLY
from hbench.protocol.frames import Frame, Receiver, encode
from tests.support.faults.faulty_line import FLAGS, RUN, World

OCTETS_S = 11_520.0  # of a stream without end
NAMES = {message.code: message.name for message in MESSAGES}
LAST = 1 << RECORD_FLAGS.index("last")
ESCAPE = "\x1b]0;title\x07\x1b[2J"


@dataclass(frozen=True)
class Lie:
    """Which lie, from which reply on; its ``repr`` is enough to repeat it."""

    kind: str
    message: str  # the request whose reply is a lie
    number: int = 1  # the first such reply
    once: bool = False


def _fields(change: Callable[[str, str, object], object]) -> Callable[[Frame], bytes]:
    """Return the lie that changes fields: ``change(name, type, value)``."""

    def lie(frame: Frame) -> bytes:
        fields = BY_NAME[NAMES[frame.code & ~REPLY]].reply
        values = unpack(fields, frame.payload)
        changed = {name: change(name, kind, values[name]) for name, kind in fields}
        return encode(Frame(frame.sequence, frame.code, pack(fields, changed)))

    return lie


def _every(kind: str, value) -> Callable[[Frame], bytes]:
    return _fields(lambda name, its, before: value if its == kind else before)


def _named(**values) -> Callable[[Frame], bytes]:
    return _fields(lambda name, its, before: values.get(name, before))


def _words(change: Callable[[np.ndarray], None]) -> Callable[[Frame], bytes]:
    def changed(name, kind, value):
        if kind != "words":
            return value
        words = np.array(value).reshape(-1, len(RECORD))
        change(words)
        return words.ravel()

    return _fields(changed)


def _set(column: int, value: int) -> Callable[[np.ndarray], None]:
    def change(words):
        words[:1, column] = value

    return change


def _mark(words: np.ndarray) -> None:
    words[:1, FLAGS] |= LAST


def _add(name: str, step: int) -> Callable[[Frame], bytes]:
    return _fields(lambda n, kind, value: (value + step) % 2**32 if n == name else value)


def _refusal(number: int) -> Callable[[Frame], bytes]:
    return lambda f: encode(Frame(f.sequence, ERROR, struct.pack("<HH", f.code & ~REPLY, number)))


def _escape(name: str, kind: str, value: object) -> object:
    return ESCAPE[:16] if kind == "text16" else value


def _payload(change: Callable[[bytes], bytes]) -> Callable[[Frame], bytes]:
    return lambda f: encode(Frame(f.sequence, f.code, change(f.payload)))


LIES: dict[str, Callable[[Frame], bytes]] = {
    "NaN": _every("f32", float("nan")),
    "infinity": _every("f32", float("-inf")),
    "huge": _every("f32", 3e38),
    "ones": _every("u16", 0xFFFF),
    "zeros": _every("u16", 0),
    "ones of 32 bits": _every("u32", 0xFFFFFFFF),
    "zeros of 32 bits": _every("u32", 0),
    "escape codes": _fields(_escape),
    "nothing": _payload(lambda payload: b""),
    "one octet more": _payload(lambda payload: payload[:200] + b"\x1b"),
    "one octet less": _payload(lambda payload: payload[:-1]),
    "refusal": _refusal(3),
    "unknown refusal": _refusal(0xFFFF),
    "other reply": lambda f: encode(Frame(f.sequence, (f.code + 1) % 256, f.payload)),
    "other sequence": lambda f: encode(Frame((f.sequence + 1) % 256, f.code, f.payload)),
    "silence": lambda f: b"",
    "no frame": lambda f: b"\x1b[31mboot>\r\n",
    "idle": _named(state=0),
    "running": _named(state=1),
    "done": _named(state=2),
    "fault": _named(state=3, fault=1),
    "another run": _named(run=3),
    "a run of another plan": _named(run=77),
    "another phase": _named(phase=6),
    "more records": _add("log_next", 50),
    "fewer records": _add("log_next", -50),
    "no records": _fields(lambda name, kind, value: [] if kind == "words" else value),
    "later records": _add("first", 3),
    "earlier records": _add("first", -3),
    "marked records": _words(_mark),
    "records of another run": _words(_set(RUN, 3)),
    "records of no run": _words(_set(RUN, 77)),
}
# Streams that never end, whatever is asked; number n is the n-th part.
STREAMS: dict[str, Callable[[int, bytes], bytes]] = {
    "octets without end": lambda n, reply: np.random.default_rng(n).bytes(512),
    "one frame without end": lambda n, reply: b"\x05hbench" * 100,
    "one reply without end": lambda n, reply: reply * 10,
    "a terminal's text without end": lambda n, reply: b"\x1b[2Jhello\r\n" * 50,
}
KINDS = (*LIES, *STREAMS)
_SAMPLE = {"u16": 5, "u32": 500, "f32": 1.5, "text16": "text", "words": np.ones(len(RECORD))}


def applies(kind: str, message: str) -> bool:
    """Return whether a lie changes the reply to a request."""
    fields = BY_NAME[message].reply
    payload = pack(fields, {name: _SAMPLE[its] for name, its in fields})
    frame = Frame(1, BY_NAME[message].code | REPLY, payload)
    return kind in STREAMS or LIES[kind](frame) != encode(frame)


class LyingLine:
    """A session's port to an honest board, whose replies turn into lies."""

    name = "sim"

    def __init__(self, world: World, lie: Lie):
        self._world = world
        self._lie = lie
        self._receiver = Receiver()
        self._replies = Counter()
        self._stream = None
        self._sent = 0
        self._end_s = 0.0  # of the octets of a stream that were sent so far
        self.lies = 0

    def write(self, data: bytes) -> None:
        self._world.rig.write(data)

    def read(self, timeout_s: float) -> bytes:
        if self._stream is not None:
            return self._flow(timeout_s)
        said = b"".join(map(self._told, self._receiver.feed(self._world.step(timeout_s))))
        return said

    def now(self) -> float:
        return self._world.rig.now()

    def close(self) -> None:
        """Leave; the bench goes on."""

    def _told(self, frame: Frame) -> bytes:
        truth = encode(frame)
        name, lie = NAMES.get(frame.code & ~REPLY, ""), self._lie
        self._replies[name] += 1
        if frame.code == ERROR or name != lie.message or self._stream is not None:
            return truth
        if self._replies[name] < lie.number or lie.once and self._replies[name] > lie.number:
            return truth
        if lie.kind in STREAMS:
            self.lies += 1
            self._stream = lambda n: STREAMS[lie.kind](n, truth)
            return b""
        told = LIES[lie.kind](frame)
        self.lies += told != truth
        return told

    def _flow(self, timeout_s: float) -> bytes:
        self._sent += 1
        part = self._stream(self._sent)
        self._world.step(max(min(len(part) / OCTETS_S, timeout_s), 1e-4))
        return part
