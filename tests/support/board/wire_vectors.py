"""Test vectors in ``vectors.txt``, and their independent computation.

``python tests/support/board/wire_vectors.py`` recomputes the indented lines from the frame lines.
"""

import re
import shlex
import struct
from dataclasses import dataclass
from pathlib import Path

FILE = Path(__file__).parents[2] / "protocol" / "vectors.txt"
NUMBERS = {"u16": "<H", "u32": "<I", "f32": "<f"}
TAILS = {"words": "u16", "f32s": "f32"}


@dataclass(frozen=True)
class WireFrame:
    """A frame line with the octets below it."""

    line: int
    message: str
    side: str  # request or reply
    sequence: int
    code: int
    fields: tuple[tuple[str, str, str], ...]  # name, kind, value as text
    plain: bytes
    stuffed: bytes

    @property
    def values(self) -> dict:
        """Values of the fields by name."""
        return {name: value_of(kind, text) for name, kind, text in self.fields}

    @property
    def payload(self) -> bytes:
        """Octets of the fields in the file."""
        return self.plain[2:-2]


def octets_of(text: str) -> bytes:
    """Octets written in hex; ``01..FE`` counts up."""
    octets = bytearray()
    for token in text.split():
        first, _, last = token.partition("..")
        octets += bytes(range(int(first, 16), int(last or first, 16) + 1))
    return bytes(octets)


def text_of(octets: bytes) -> str:
    """Octets in hex, in the short form that ``octets_of`` reads."""
    parts, at = [], 0
    while at < len(octets):
        end = at + 1
        while end < len(octets) and octets[end] == octets[end - 1] + 1:
            end += 1
        run = octets[at:end]
        parts += [f"{run[0]:02X}..{run[-1]:02X}"] if len(run) > 4 else [f"{o:02X}" for o in run]
        at = end
    return " ".join(parts)


def value_of(kind: str, text: str):
    """A field's value: a number, a text, or the numbers of a tail (``0..119`` counts up)."""
    if kind == "text16":
        return text
    if kind in TAILS:
        values = []
        for token in filter(None, text.split(",")):
            first, _, last = token.partition("..")
            whole = range(int(first, 0), int(last, 0) + 1) if last else None
            values += whole or [value_of(TAILS[kind], token)]
        return values
    return float(text) if kind == "f32" else int(text, 0)


def packed(kind: str, value) -> bytes:
    """The octets of a field, by ``struct``."""
    if kind == "text16":
        return struct.pack("16s", value.encode("ascii"))
    if kind in TAILS:
        return b"".join(packed(TAILS[kind], item) for item in value)
    return struct.pack(NUMBERS[kind], value)


def crc(octets: bytes) -> int:
    """CRC-16/CCITT-FALSE, bit by bit: polynomial x^16 + x^12 + x^5 + 1, from 0xFFFF."""
    register = 0xFFFF
    for octet in octets:
        for bit in range(7, -1, -1):
            out = register >> 15 ^ octet >> bit & 1
            register = register << 1 & 0xFFFF ^ (0x1021 if out else 0)
    return register


def stuffed(octets: bytes) -> bytes:
    """COBS: each block up to a zero, at most 254 octets, preceded by its length plus one.

    A zero is appended first. No empty block follows a full block at the end.
    """
    out, rest = b"", octets + b"\0"
    while rest:
        piece = rest[:254].partition(b"\0")[0]
        out += bytes([len(piece) + 1]) + piece
        rest = rest[len(piece) :]
        if len(piece) < 254:
            rest = rest[1:]
        elif rest == b"\0":
            break
    return out


def unstuffed(block: bytes) -> bytes:
    """The inverse of ``stuffed``."""
    out, at = b"", 0
    while at < len(block):
        code = block[at]
        out += block[at + 1 : at + code]
        at += code
        if code < 255 and at < len(block):
            out += b"\0"
    return out


def frame_octets(frame: WireFrame) -> tuple[bytes, bytes]:
    """Octets of a frame line: plain, and as they are sent."""
    plain = bytes([frame.sequence, frame.code])
    plain += b"".join(packed(kind, value_of(kind, text)) for _, kind, text in frame.fields)
    plain += struct.pack("<H", crc(plain))
    return plain, stuffed(plain) + b"\0"


def rows(kind: str) -> list[tuple[str, bytes]]:
    """The lines ``kind LEFT = OCTETS`` as (left, octets)."""
    pairs = []
    for line in FILE.read_text().splitlines():
        if line.startswith(kind + " "):
            left, _, right = line.removeprefix(kind).partition("=")
            pairs.append((left.strip(), octets_of(right)))
    return pairs


def frames() -> list[WireFrame]:
    """The frames, in order."""
    lines = FILE.read_text().splitlines()
    return [_frame(lines, at) for at, line in enumerate(lines) if line.startswith("frame ")]


def _frame(lines: list[str], at: int) -> WireFrame:
    _, message, side, sequence, code, *fields = shlex.split(lines[at])
    parts = [re.fullmatch(r"(\w+):(\w+)=(.*)", field).groups() for field in fields]
    below = [line.split(maxsplit=1)[1] for line in lines[at + 1 : at + 3] if line[:2] == "  "]
    plain, on_wire = (octets_of(text) for text in (below or ["", ""]))
    return WireFrame(
        at + 1, message, side, int(sequence, 16), int(code, 16), tuple(parts), plain, on_wire
    )


def renewed() -> str:
    """The file's text with the lines that follow from its frame lines recomputed."""
    kept = [line for line in FILE.read_text().splitlines() if not line.startswith("  ")]
    out = []
    for line in kept:
        out.append(line)
        if line.startswith("frame "):
            plain, on_wire = frame_octets(_frame([line], 0))
            out += [f"  plain    {text_of(plain)}", f"  on-wire  {text_of(on_wire)}"]
    return "\n".join(out) + "\n"


if __name__ == "__main__":
    FILE.write_text(renewed())
