"""The host's end of the wire: requests with retransmission, typed by the dictionary."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hbench.errors import DeviceError
from hbench.protocol.codec import BY_NAME, pack, pack_settings, unpack
from hbench.protocol.dictionary import (
    ERROR,
    MAX_FRAME,
    PROTOCOL,
    RECORD,
    REFUSALS,
    REPLY,
    SETTINGS,
    dictionary_hash,
)
from hbench.protocol.frames import Frame, Receiver, crc16, encode
from hbench.rig.ports import Port

REPLY_TIMEOUT_S = 0.25
ATTEMPTS = 8
_SETTINGS_PER_FRAME = 48
RECORDS_PER_FRAME = (MAX_FRAME - 4 - 8) // (2 * len(RECORD))


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

    ``first`` is later than asked where records had been overwritten.
    """

    first: int
    next: int
    words: np.ndarray


class BoardClient:
    """Talks to one board over a port. Every request may be repeated without harm."""

    def __init__(self, port: Port, attempts: int = ATTEMPTS):
        self.port = port
        self._attempts = attempts
        self._receiver = Receiver()
        self._sequence = 0

    def identify(self) -> Identity:
        """Ask who is there; another dictionary is refused by name."""
        reply = self._request("identify")
        if (reply["protocol"], reply["dictionary"]) != (PROTOCOL, dictionary_hash()):
            raise DeviceError(
                f"{self.port.name}: firmware '{reply['firmware']}' on board '{reply['board']}' "
                f"speaks protocol {reply['protocol']}, dictionary {reply['dictionary']:08x}; "
                f"this hbench speaks {PROTOCOL}, {dictionary_hash():08x}",
                "Load the firmware that belongs to this version of hbench.",
            )
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
        return self._request("status")

    def read_log(self, first: int) -> LogPart:
        """Pull the records from number ``first`` on, as many as one frame holds."""
        reply = self._request("read_log", first=first, count=RECORDS_PER_FRAME)
        words = reply["words"]
        if words.size % len(RECORD):
            raise DeviceError(f"{self.port.name}: {words.size} words are not whole records")
        return LogPart(reply["first"], reply["next"], words.reshape(-1, len(RECORD)))

    def wait(self, seconds: float) -> None:
        """Let time pass on the port's clock; what comes in meanwhile is late and dropped."""
        deadline = self.port.now() + seconds
        while (left := deadline - self.port.now()) > 0:
            self._receiver.feed(self.port.read(left))

    def _request(self, name: str, **values: Any) -> dict[str, Any]:
        message = BY_NAME[name]
        self._sequence = (self._sequence + 1) % 256
        frame = encode(Frame(self._sequence, message.code, pack(message.request, values)))
        for _ in range(self._attempts):
            self.port.write(frame)
            reply = self._await(message.code)
            if reply is None:
                continue
            if reply.code == ERROR:
                refusal = int.from_bytes(reply.payload[2:4], "little")
                known = refusal < len(REFUSALS)
                raise Refused(name, REFUSALS[refusal] if known else f"reason {refusal}")
            try:
                return unpack(message.reply, reply.payload)
            except ValueError as error:
                raise DeviceError(f"{self.port.name}: reply to '{name}': {error}") from None
        raise NoAnswer(
            f"{self.port.name}: no answer to '{name}' in {self._attempts} attempts"
            + (f"; {self._receiver.damaged} damaged frames" if self._receiver.damaged else ""),
            "Is it an hbench board, with power, and the right port?",
        )

    def _await(self, code: int) -> Frame | None:
        deadline = self.port.now() + REPLY_TIMEOUT_S
        while (left := deadline - self.port.now()) > 0:
            for frame in self._receiver.feed(self.port.read(left)):
                if frame.sequence == self._sequence and frame.code in (code | REPLY, ERROR):
                    return frame
        return None
