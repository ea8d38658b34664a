"""Frames: [sequence][type][payload][CRC-16], COBS-stuffed, terminated by a zero octet.

The CRC is CRC-16/CCITT-FALSE over all octets before it, little-endian. It starts from 0xFFFF: with
XMODEM's start from 0 an additional or missing leading zero, and so a flipped bit, could remain
undetected. A damaged frame is dropped without a reply, and the host repeats its request.
"""

import binascii
from dataclasses import dataclass

from cobs import cobs

from hbench.protocol.dictionary import CRC_START, MAX_FRAME


@dataclass(frozen=True)
class Frame:
    """A message with its sequence number."""

    sequence: int  # 0..255; a reply has that of its request
    code: int  # type of the message
    payload: bytes


def crc16(data: bytes) -> int:
    """Return the CRC-16/CCITT-FALSE of ``data``."""
    return binascii.crc_hqx(data, CRC_START)


def encode(frame: Frame) -> bytes:
    """Return the octets of a frame with its terminator. Raises ``ValueError`` if it is too long."""
    body = bytes((frame.sequence, frame.code)) + frame.payload
    body += crc16(body).to_bytes(2, "little")
    if len(body) > MAX_FRAME:
        raise ValueError(f"frame of {len(body)} octets, limit {MAX_FRAME}")
    return cobs.encode(body) + b"\0"


class Receiver:
    """Decoder of a stream of octets, which counts and drops damaged frames."""

    def __init__(self) -> None:
        self._pending = bytearray()
        self.damaged = 0

    def feed(self, data: bytes) -> list[Frame]:
        """Add received octets; return the frames that they complete."""
        self._pending += data
        *chunks, rest = self._pending.split(b"\0")
        self._pending = rest[-2 * MAX_FRAME :]  # limits the memory for a stream without zeros
        frames = []
        for chunk in filter(None, chunks):
            frame = _decode(bytes(chunk))
            if frame is None:
                self.damaged += 1
            else:
                frames.append(frame)
        return frames


def _decode(chunk: bytes) -> Frame | None:
    try:
        body = cobs.decode(chunk)
    except cobs.DecodeError:
        return None
    if not 4 <= len(body) <= MAX_FRAME or crc16(body[:-2]) != int.from_bytes(body[-2:], "little"):
        return None
    return Frame(body[0], body[1], body[2:-2])
