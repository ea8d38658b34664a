"""The host's end of the wire: requests with retransmission, typed by the dictionary."""

from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from hbench.errors import DeviceError
from hbench.protocol.codec import BY_NAME, pack, pack_settings, unpack
from hbench.protocol.dictionary import (
    ERROR,
    FAULTS,
    MAX_FRAME,
    PROTOCOL,
    RECORD,
    REFUSALS,
    REPLY,
    SETTINGS,
    STATES,
    Message,
    dictionary_hash,
)
from hbench.protocol.frames import Frame, Receiver, crc16, encode
from hbench.rig.ports import Port

REPLY_TIMEOUT_S = 0.25
ATTEMPTS = 8
WINDOW = 4
"""Requests of a pull on the way. Their 48 octets fit the 64 that a board buffers while it sends."""

_SETTINGS_PER_FRAME = 12  # a short frame is the likelier to come through
RECORDS_PER_FRAME = (MAX_FRAME - 4 - 8) // (2 * len(RECORD))
_HEAD = BY_NAME["identify"].reply[:4]  # protocol, dictionary, firmware, board: the same for ever
_HEAD_OCTETS = 2 + 4 + 16 + 16


class Refused(DeviceError):
    """The board understood a request and said no."""

    def __init__(self, request: str, refusal: str):
        super().__init__(f"the board refused '{request}': {refusal.replace('_', ' ')}")
        self.refusal = refusal


class NoAnswer(DeviceError):
    """Nothing that could be an hbench board answered."""


@dataclass(frozen=True)
class Identity:
    """Who answered."""

    firmware: str
    board: str
    boots: int
    rate_hz: int
    ring_records: int
    max_steps: int
    max_segments: int


@dataclass(frozen=True)
class LogPart:
    """Records pulled from the ring: ``words`` (n, words of a record), the first's number.

    ``lost`` records right before them are gone: the log ran over before they were pulled.
    """

    first: int
    words: np.ndarray
    lost: int


@dataclass
class _Asked:
    """A request that has been sent, and its reply once it has come."""

    message: Message
    octets: bytes
    sent: int = 0  # times
    reply: Frame | None = None


class BoardClient:
    """Talks to one board over a port. Every request may be repeated without harm."""

    def __init__(self, port: Port, attempts: int = ATTEMPTS):
        self.port = port
        self._attempts = attempts
        self._records_per_reply = RECORDS_PER_FRAME
        self._receiver = Receiver()
        self._arrived: deque[Frame] = deque()  # and not looked at
        self._sequence = 0

    def identify(self) -> Identity:
        """Ask who is there; another dictionary is refused by name."""
        reply = self._request("identify")
        fields = Identity.__dataclass_fields__
        return Identity(**{name: value for name, value in reply.items() if name in fields})

    def write_settings(self, settings: Mapping[str, float]) -> int:
        """Send all settings; returns their CRC for ``start``."""
        octets = pack_settings(settings)
        values = np.frombuffer(octets, "<f4")
        for first in range(0, len(SETTINGS), _SETTINGS_PER_FRAME):
            part = values[first : first + _SETTINGS_PER_FRAME]
            self._request("write_settings", first=first, values=part)
        return crc16(octets)

    def write_schedule(
        self, segments: Sequence[Mapping[str, Any]], steps: Sequence[Mapping[str, Any]]
    ) -> int:
        """Replace the board's schedule; returns its CRC for ``start``."""
        octets = b""
        for request, items in (("write_segment", segments), ("write_step", steps)):
            for index, item in enumerate(items):
                values = {"index": index, **item}
                self._request(request, **values)
                octets += pack(BY_NAME[request].request, values)[2:]  # without the index
        return crc16(octets)

    def start(self, settings_crc: int, steps_crc: int) -> None:
        """Start the schedule, if the board holds what was sent."""
        self._request("start", settings_crc=settings_crc, steps_crc=steps_crc)

    def stop(self) -> None:
        """Valves to neutral, now."""
        self._request("stop")

    def clear_fault(self) -> None:
        """Unlatch a fault whose cause has been looked at."""
        self._request("clear_fault")

    def status(self) -> dict[str, Any]:
        """State, progress and live values; also the host's sign of life."""
        status = self._request("status")
        if status["state"] >= len(STATES) or status["fault"] >= len(FAULTS):
            raise DeviceError(
                f"{self.port.name}: the board reports state {status['state']} and fault "
                f"{status['fault']}, which no board has"
            )
        return status

    def pull(self, first: int, until: int, window: int = WINDOW) -> Iterator[LogPart]:
        """Pull the records ``first`` to ``until - 1``, which the board has logged, in order.

        ``window`` requests are on the way at a time, so that the line carries replies without a
        pause. Records that were overwritten are told as ``lost``; every record asked for is in
        one part or lost. On a line that damages octets, a reply is the likelier to come through
        the shorter it is: where the attempts at one are used up, half as many records are asked
        for at a time from then on.
        """
        while first < until:
            damaged = self._receiver.damaged
            try:
                for part in self._pull(first, until, window):
                    yield part
                    first = part.first + len(part.words)
            except NoAnswer:
                if self._records_per_reply == 1 or self._receiver.damaged == damaged:
                    raise
                self._records_per_reply //= 2

    def _pull(self, first: int, until: int, window: int) -> Iterator[LogPart]:
        ahead = number = first  # what to ask for next; what is handed out or lost until here

        def requests() -> Iterator[tuple[str, dict[str, int]]]:
            nonlocal ahead
            while (asked := ahead) < until:
                ahead = min(asked + self._records_per_reply, until)
                yield "read_log", {"first": asked, "count": ahead - asked}

        for request, reply in self._ask(requests(), window):
            asked, end = request["first"], request["first"] + request["count"]
            begin, words = reply["first"], self._records(reply["words"])
            ahead = max(ahead, begin)  # what is overwritten needn't be asked for
            if not asked <= begin <= begin + len(words) or begin + len(words) < end:
                raise DeviceError(
                    f"{self.port.name}: asked for the records {asked} to {end - 1}, the board "
                    f"sent {len(words)} from {begin} on",
                    "Was it reset?",
                )
            begin = min(begin, end)  # what follows is in the next replies
            yield LogPart(begin, words[: end - begin], lost=begin - number)
            number = end
        if number < until:
            yield LogPart(until, np.zeros((0, len(RECORD)), "<u2"), lost=until - number)

    def wait(self, seconds: float) -> None:
        """Let time pass on the port's clock; what comes in meanwhile is late and dropped."""
        deadline = self.port.now() + seconds
        while (left := deadline - self.port.now()) > 0:
            self._receiver.feed(self.port.read(left))

    def _request(self, name: str, **values: Any) -> dict[str, Any]:
        ((_, reply),) = self._ask([(name, values)], window=1)
        return reply

    def _ask(
        self, requests: Iterable[tuple[str, dict[str, Any]]], window: int
    ) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
        """Keep ``window`` requests on the way; yield each one's values and reply, in order.

        The board answers in the order in which it hears. So the reply to a later request tells
        that an earlier one was lost, which is then sent again alone and at once. Where there is no
        later one, the deadline tells.
        """
        requests = iter(requests)
        due: deque[tuple[dict[str, Any], _Asked]] = deque()  # in the order of the requests
        on_the_way: dict[int, _Asked] = {}  # by sequence, in the order of sending
        while True:
            for name, values in islice(requests, window - len(on_the_way)):
                self._sequence = (self._sequence + 1) % 256
                message = BY_NAME[name]
                frame = Frame(self._sequence, message.code, pack(message.request, values))
                due.append((values, _Asked(message, encode(frame))))
                self._send(self._sequence, due[-1][1], on_the_way)
            if not due:
                return
            reply = self._await(on_the_way)
            lost = list(on_the_way)
            if reply is not None:
                lost = lost[: lost.index(reply.sequence)]
                on_the_way.pop(reply.sequence).reply = reply
            for sequence in lost:
                self._send(sequence, on_the_way.pop(sequence), on_the_way)
            while due and (answer := due[0][1].reply):
                values, asked = due.popleft()
                yield values, self._unpack(asked.message, answer)

    def _send(self, sequence: int, asked: _Asked, on_the_way: dict[int, _Asked]) -> None:
        name = asked.message.name
        if asked.sent == self._attempts:
            raise NoAnswer(
                f"{self.port.name}: no answer to '{name}' in {self._attempts} attempts"
                + (f"; {self._receiver.damaged} damaged frames" if self._receiver.damaged else ""),
                "Is it an hbench board, with power, and the right port?",
            )
        asked.sent += 1
        on_the_way[sequence] = asked
        self.port.write(asked.octets)

    def _await(self, on_the_way: Mapping[int, _Asked]) -> Frame | None:
        """Return the next reply to one of the requests; None where none comes in time."""
        deadline = self.port.now() + REPLY_TIMEOUT_S
        while True:
            while self._arrived:
                frame = self._arrived.popleft()
                asked = on_the_way.get(frame.sequence)
                if asked and frame.code in (asked.message.code | REPLY, ERROR):
                    return frame
            if (left := deadline - self.port.now()) <= 0:
                return None
            self._arrived += self._receiver.feed(self.port.read(left))

    def _unpack(self, message: Message, reply: Frame) -> dict[str, Any]:
        name = message.name
        if reply.code == ERROR:
            refusal = int.from_bytes(reply.payload[2:4], "little")
            known = refusal < len(REFUSALS)
            raise Refused(name, REFUSALS[refusal] if known else f"reason {refusal}")
        if name == "identify":
            self._refuse_stranger(reply.payload)
        try:
            return unpack(message.reply, reply.payload)
        except ValueError as error:
            raise DeviceError(f"{self.port.name}: reply to '{name}': {error}") from None

    def _refuse_stranger(self, identity: bytes) -> None:
        """Raise ``DeviceError`` for another dictionary, by which all but the head may differ."""
        if len(identity) < _HEAD_OCTETS:
            return
        head = unpack(_HEAD, identity[:_HEAD_OCTETS])
        if (head["protocol"], head["dictionary"]) != (PROTOCOL, dictionary_hash()):
            raise DeviceError(
                f"{self.port.name}: firmware '{head['firmware']}' on board '{head['board']}' "
                f"speaks protocol {head['protocol']}, dictionary {head['dictionary']:08x}; "
                f"this hbench speaks {PROTOCOL}, {dictionary_hash():08x}",
                "Load the firmware that belongs to this version of hbench.",
            )

    def _records(self, words: np.ndarray) -> np.ndarray:
        if words.size % len(RECORD):
            raise DeviceError(f"{self.port.name}: {words.size} words are not whole records")
        return words.reshape(-1, len(RECORD))
