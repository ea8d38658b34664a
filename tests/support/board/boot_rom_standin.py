"""A stand-in for the F28335's serial boot ROM, written from TI's documents (SPRUI07).

``BootRom`` is the chip: octets in, octets out. ``BootLine`` is a port to it with a baud rate, a
latency (as of a USB adapter) and faults, on simulated time.
"""

from collections import deque
from contextlib import suppress

from hbench.protocol.codec import BY_NAME, pack
from hbench.protocol.dictionary import PROTOCOL, REPLY, dictionary_hash
from hbench.protocol.frames import Frame, Receiver, encode

PROGRAM_BAUD = 115_200
FIRMWARE = "hbench-core 9.9"


def octets_of(words) -> bytes:
    return b"".join(bytes([word & 0xFF, word >> 8]) for word in words)


def stream_of(entry, blocks, key=0x08AA) -> bytes:
    """Octets of an image; ``blocks`` are (address, words)."""
    words = [key, *[0] * 8, entry >> 16, entry & 0xFFFF]
    for address, data in blocks:
        words += [len(data), address >> 16, address & 0xFFFF, *data]
    return octets_of([*words, 0])


def text_of(stream: bytes, marks=True, columns=24) -> str:
    """Octets as hex2000 -sci8 -a writes them."""
    lines = [stream[i : i + columns].hex(" ").upper() for i in range(0, len(stream), columns)]
    body = " \n".join(lines)
    return f"\x02\n{body} \n\x03" if marks else body + "\n"


class Program:
    """A loaded program: answers 'identify', and nothing else, at its own rate."""

    def __init__(self, firmware=FIRMWARE, protocol=PROTOCOL):
        self.receiver = Receiver()
        self.identity = {
            "protocol": protocol,
            "dictionary": dictionary_hash(),
            "firmware": firmware,
            "board": "f28335",
            "boots": 1,
            "rate_hz": 10_000,
            "ring_records": 512,
            "max_steps": 64,
            "max_segments": 64,
        }

    def feed(self, octet: int, baud: int) -> bytes:
        answer = b""
        if baud == PROGRAM_BAUD:
            for frame in self.receiver.feed(bytes([octet])):
                payload = pack(BY_NAME["identify"].reply, self.identity)
                answer += encode(Frame(frame.sequence, frame.code | REPLY, payload))
        return answer


class Babble:
    """A program that answers every octet with nonsense."""

    def feed(self, octet: int, baud: int) -> bytes:
        return b"?!"


class BootRom:
    """The chip after reset. ``state``: autobaud, loading, ram, flash."""

    def __init__(self, ram_program=None, flash_program=None, boots_from_flash=False):
        self.programs = {"ram": ram_program, "flash": flash_program}
        self.state = "flash" if boots_from_flash else "autobaud"
        self.memory: dict[int, int] = {}
        self.entry = None
        self._rom = self._load()
        next(self._rom)

    def feed(self, octet: int, baud: int) -> bytes:
        """Take an octet, return what goes out."""
        if self.state in self.programs:
            program = self.programs[self.state]
            return program.feed(octet, baud) if program else b""
        if self.state == "autobaud":  # waits for ever, silent
            self.state = "loading" if octet in b"Aa" else "autobaud"
            return bytes([octet]) if self.state == "loading" else b""
        with suppress(StopIteration):
            self._rom.send(octet)
        return bytes([octet])

    def _load(self):
        if (yield from _word()) != 0x08AA:
            self.state = "flash"
            return
        for _ in range(8):
            yield from _word()
        entry = yield from _long()
        while count := (yield from _word()):
            address = yield from _long()
            for i in range(count):  # without a look at the address, as the ROM
                self.memory[address + i] = yield from _word()
        self.entry = entry
        self.state = "ram"


def _word():
    low = yield
    return low | (yield) << 8


def _long():
    high = yield from _word()
    return high << 16 | (yield from _word())


class BootLine:
    """A port to a ``BootRom``.

    Bytes are counted from 1 after the 'A', as in hbench's messages. ``flips``: byte number to
    the mask on its echo. ``silent_from``: the chip takes nothing from this byte on.
    """

    name = "bench"

    def __init__(self, rom, baud, latency_s=0.0, flips=None, silent_from=None):
        self.rom, self.baud, self.latency_s = rom, baud, latency_s
        self.flips, self.silent_from = flips or {}, silent_from
        self.time = self.line_free = 0.0
        self.coming: deque[tuple[float, int]] = deque()
        self.written = b""
        self.number = 0  # of the byte since the 'A'
        self.received = 0
        self.most_on_the_way = 0
        self.closed = False

    def write(self, data):
        assert not self.closed
        for octet in data:
            self.written += bytes([octet])
            self.line_free = max(self.line_free, self.time) + 10 / self.baud
            due = self.line_free + 10 / self.baud + self.latency_s
            self.coming += [(due, answer) for answer in self._answer(octet)]
        self.most_on_the_way = max(self.most_on_the_way, len(self.written) - self.received)

    def _answer(self, octet):
        self.number += self.rom.state == "loading"
        if self.silent_from is not None and self.number >= self.silent_from:
            return b""
        answer = self.rom.feed(octet, self.baud)
        if self.number in self.flips:
            answer = bytes([answer[0] ^ self.flips[self.number]])
        return answer

    def read(self, timeout_s):
        assert not self.closed
        deadline = self.time + timeout_s
        self.time = min(deadline, max(self.time, self.coming[0][0])) if self.coming else deadline
        data = b""
        while self.coming and self.coming[0][0] <= self.time:
            data += bytes([self.coming.popleft()[1]])
        self.received += len(data)
        return data

    def now(self):
        return self.time

    def close(self):
        self.closed = True
