"""Client of the board: requests with retransmission, typed by the protocol's dictionary."""

import math
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
PULL_WINDOW = 4
"""Pending requests of a pull. Their 48 octets fit into the board's receive buffer of 64."""

_SETTINGS_PER_FRAME = 12  # a short frame is more likely to arrive undamaged
RECORDS_PER_FRAME = (MAX_FRAME - 4 - 8) // (2 * len(RECORD))
_HEAD = BY_NAME["identify"].reply[:4]  # protocol, dictionary, firmware, board: never changes
_HEAD_OCTETS = 2 + 4 + 16 + 16


class Refused(DeviceError):
    """A refusal: the board understood a request and rejected it."""

    def __init__(self, request: str, refusal: str):
        super().__init__(f"the board refused '{request}': {refusal.replace('_', ' ')}")
        self.refusal = refusal


class NoAnswer(DeviceError):
    """A timeout: no hbench board answered."""


@dataclass(frozen=True)
class Identity:
    """Identity of a board: firmware, board, starts, rate and capacities."""

    firmware: str
    board: str
    boots: int
    rate_hz: int
    ring_records: int
    max_steps: int
    max_segments: int


@dataclass(frozen=True)
class LogPart:
    """Records pulled from the ring: number of the first, ``words`` (n, words of a record).

    ``lost`` records before them were overwritten before the pull.
    """

    first: int
    words: np.ndarray
    lost: int


@dataclass
class _Pending:
    """A sent request, and its reply after arrival."""

    message: Message
    octets: bytes
    attempts: int = 0
    reply: Frame | None = None


class BoardClient:
    """Client of one board over a port. Every request may be repeated without harm."""

    def __init__(self, port: Port, attempts: int = ATTEMPTS):
        self.port = port
        self._attempts = attempts
        self._records_per_reply = RECORDS_PER_FRAME
        self._receiver = Receiver()
        self._arrived: deque[Frame] = deque()  # not processed yet
        self._sequence = 0

    def identify(self) -> Identity:
        """Return the board's identity. Raises ``DeviceError`` for another protocol dictionary."""
        reply = self._request("identify")
        fields = Identity.__dataclass_fields__
        return Identity(**{name: value for name, value in reply.items() if name in fields})

    def write_settings(self, settings: Mapping[str, float]) -> int:
        """Send all settings and return their CRC for ``start``."""
        octets = pack_settings(settings)
        values = np.frombuffer(octets, "<f4")
        for first in range(0, len(SETTINGS), _SETTINGS_PER_FRAME):
            chunk = values[first : first + _SETTINGS_PER_FRAME]
            self._request("write_settings", first=first, values=chunk)
        return crc16(octets)

    def write_schedule(
        self, segments: Sequence[Mapping[str, Any]], steps: Sequence[Mapping[str, Any]]
    ) -> int:
        """Replace the board's schedule and return its CRC for ``start``."""
        octets = b""
        for request, items in (("write_segment", segments), ("write_step", steps)):
            for index, item in enumerate(items):
                values = {"index": index, **item}
                self._request(request, **values)
                octets += pack(BY_NAME[request].request, values)[2:]  # without the index
        return crc16(octets)

    def start(self, settings_crc: int, steps_crc: int) -> None:
        """Start the schedule; the board refuses if its settings or steps have another CRC."""
        self._request("start", settings_crc=settings_crc, steps_crc=steps_crc)

    def stop(self) -> None:
        """Set all valves to neutral at once."""
        self._request("stop")

    def clear_fault(self) -> None:
        """Clear a latched fault; its cause should be known."""
        self._request("clear_fault")

    def status(self) -> dict[str, Any]:
        """Return state, progress and live values. The request also serves as heartbeat."""
        status = self._request("status")
        if status["state"] >= len(STATES) or status["fault"] >= len(FAULTS):
            raise DeviceError(
                f"{self.port.name}: the board reports state {status['state']} and fault "
                f"{status['fault']}; limits {len(STATES) - 1} and {len(FAULTS) - 1}",
                "Reset the board; if it happens again, flash its firmware anew.",
            )
        for name, value in status.items():
            if not math.isfinite(value):
                raise DeviceError(
                    f"{self.port.name}: the board reports {name} = {value}",
                    "Reset the board; if it happens again, flash its firmware anew.",
                )
        return status

    def pull(self, first: int, until: int, window: int = PULL_WINDOW) -> Iterator[LogPart]:
        """Pull the records ``first`` to ``until - 1``, which the board has logged, in order.

        ``window`` requests are pending at a time, so that replies use the line without a pause.
        Overwritten records are counted as ``lost``; every requested record is in one part or lost.
        On a line that damages octets, shorter replies are more likely to arrive: once the attempts
        at a reply are used up, each request is for half as many records.
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
        next_request = delivered = first  # numbers of records; delivered counts lost ones too

        def requests() -> Iterator[tuple[str, dict[str, int]]]:
            nonlocal next_request
            while (begin := next_request) < until:
                next_request = min(begin + self._records_per_reply, until)
                yield "read_log", {"first": begin, "count": next_request - begin}

        for request, reply in self._exchange(requests(), window):
            requested, end = request["first"], request["first"] + request["count"]
            begin, words = reply["first"], self._records(reply["words"])
            next_request = max(next_request, begin)  # skips overwritten records
            if not requested <= begin <= begin + len(words) or begin + len(words) < end:
                raise DeviceError(
                    f"{self.port.name}: the board sent {len(words)} records from {begin} on; "
                    f"requested {requested} to {end - 1}",
                    "Check whether the board was reset.",
                )
            begin = min(begin, end)  # later records are in the next replies
            yield LogPart(begin, words[: end - begin], lost=begin - delivered)
            delivered = end
        if delivered < until:
            yield LogPart(until, np.zeros((0, len(RECORD)), "<u2"), lost=until - delivered)

    def wait(self, seconds: float) -> None:
        """Wait on the port's clock; late replies arriving meanwhile are dropped."""
        deadline = self.port.now() + seconds
        while (left := deadline - self.port.now()) > 0:
            self._receiver.feed(self.port.read(left))

    def _request(self, name: str, **values: Any) -> dict[str, Any]:
        ((_, reply),) = self._exchange([(name, values)], window=1)
        return reply

    def _exchange(
        self, requests: Iterable[tuple[str, dict[str, Any]]], window: int
    ) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
        """Keep ``window`` requests pending; yield the values and the reply of each, in order.

        The board answers in the order of reception. The reply to a later request therefore shows
        that an earlier one was lost; the earlier one is then sent again at once. Without a later
        request, the timeout applies.
        """
        requests = iter(requests)
        due: deque[tuple[dict[str, Any], _Pending]] = deque()  # in the order of the requests
        pending: dict[int, _Pending] = {}  # by sequence, in the order of sending
        while True:
            for name, values in islice(requests, window - len(pending)):
                self._sequence = (self._sequence + 1) % 256
                message = BY_NAME[name]
                frame = Frame(self._sequence, message.code, pack(message.request, values))
                due.append((values, _Pending(message, encode(frame))))
                self._send(self._sequence, due[-1][1], pending)
            if not due:
                return
            reply = self._await(pending)
            lost = list(pending)
            if reply is not None:
                lost = lost[: lost.index(reply.sequence)]
                pending.pop(reply.sequence).reply = reply
            for sequence in lost:
                self._send(sequence, pending.pop(sequence), pending)
            while due and (answer := due[0][1].reply):
                values, request = due.popleft()
                yield values, self._unpack(request.message, answer)

    def _send(self, sequence: int, request: _Pending, pending: dict[int, _Pending]) -> None:
        name = request.message.name
        if request.attempts == self._attempts:
            raise NoAnswer(
                f"{self.port.name}: no answer to '{name}' in {self._attempts} attempts"
                + (f"; {self._receiver.damaged} damaged frames" if self._receiver.damaged else ""),
                "Check the port, the board's power, and that it runs hbench firmware.",
            )
        request.attempts += 1
        pending[sequence] = request
        self.port.write(request.octets)

    def _await(self, pending: Mapping[int, _Pending]) -> Frame | None:
        """Return the next reply to a pending request; None after the timeout."""
        deadline = self.port.now() + REPLY_TIMEOUT_S
        while True:
            while self._arrived:
                frame = self._arrived.popleft()
                request = pending.get(frame.sequence)
                if request and frame.code in (request.message.code | REPLY, ERROR):
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
            self._check_dictionary(reply.payload)
        try:
            return unpack(message.reply, reply.payload)
        except ValueError as error:
            raise DeviceError(f"{self.port.name}: reply to '{name}': {error}") from None

    def _check_dictionary(self, identity: bytes) -> None:
        """Raise ``DeviceError`` for another dictionary, with which only the head is readable."""
        if len(identity) < _HEAD_OCTETS:
            return
        head = unpack(_HEAD, identity[:_HEAD_OCTETS])
        if (head["protocol"], head["dictionary"]) != (PROTOCOL, dictionary_hash()):
            raise DeviceError(
                f"{self.port.name}: firmware '{head['firmware']}' on board '{head['board']}' "
                f"uses protocol {head['protocol']}, dictionary {head['dictionary']:08x}; "
                f"this hbench uses {PROTOCOL}, {dictionary_hash():08x}",
                "Load the firmware of this version of hbench.",
            )

    def _records(self, words: np.ndarray) -> np.ndarray:
        if words.size % len(RECORD):
            raise DeviceError(
                f"{self.port.name}: a reply has {words.size} words; expected a multiple of "
                f"{len(RECORD)}"
            )
        return words.reshape(-1, len(RECORD))
