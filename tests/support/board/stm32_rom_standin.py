"""A stand-in for the STM32F446's serial boot ROM, written from ST's AN3155 and AN2606.

``Stm32Rom`` is the chip: octets in, octets out. Its flash memory can only be cleared bit by bit, as
a real one, so a sector that was not erased shows. ``RomLine`` is a port to it on simulated time.
"""

import struct
from functools import reduce
from operator import xor

from tests.support.board.boot_rom_standin import FIRMWARE, Program

FLASH, RAM = 0x0800_0000, 0x2000_0000
SECTORS = (*[16 * 1024] * 4, 64 * 1024, *[128 * 1024] * 3)
ACK, NACK = b"\x79", b"\x1f"
COMMANDS = (0x00, 0x01, 0x02, 0x11, 0x21, 0x31, 0x44, 0x63, 0x73, 0x82, 0x92)
VERSION = 0x31


def elf(parts, machine=40, bits=1) -> bytes:
    """An ELF file of ``parts`` (address, octets), as a linker for ARM writes it."""
    at = 52 + 32 * len(parts)
    ident = b"\x7fELF" + bytes([bits, 1, 1, 0]) + bytes(8)
    header = struct.pack(
        "<HHIIIIIHHHHHH", 2, machine, 1, FLASH + 9, 52, 0, 0, 52, 32, len(parts), 0, 0, 0
    )
    segments, content = b"", b""
    for address, octets in parts:
        size = len(octets)
        segments += struct.pack("<8I", 1, at + len(content), address, address, size, size, 5, 65536)
        content += octets
    return ident + header + segments + content


def program(size=40_001, board="stm32f4", firmware=FIRMWARE) -> bytes:
    """Octets of a program: vector table, names, code."""
    vectors = struct.pack("<II", RAM + 2048, FLASH + 9)
    names = f"{firmware}\0{board}\0".encode()
    code = bytes((7 * i + i // 251) % 256 for i in range(size - len(vectors) - len(names)))
    return vectors + names + code


class Stm32Rom:
    """The chip after reset with BOOT0 high.

    ``nack_at`` and ``silent_at`` are numbers of octets from the host from which on the ROM refuses
    what it would confirm, or is silent. ``stuck`` are flash octets that stay 0.
    """

    def __init__(self, product=0x421, protected=False, program=None, boots_from_flash=False):
        self.flash = bytearray(b"\x5a" * sum(SECTORS))  # an older program
        self.product, self.protected, self.program = product, protected, program
        self.nack_at = self.silent_at = float("inf")
        self.stuck: set[int] = set()
        self.octets = 0
        self.started = FLASH if boots_from_flash else None
        self.erased: list[int] = []
        self._answer = b""
        self._rom = self._run()
        next(self._rom)

    def feed(self, octet: int, baud: int) -> bytes:
        """Take an octet, return what goes out."""
        if self.started is not None:
            return self.program.feed(octet, baud) if self.program else b""
        self.octets += 1
        self._answer = b""
        if self.octets < self.silent_at:
            self._rom.send(octet)
        return self._answer

    def _confirm(self, good=True) -> bool:
        good = good and self.octets < self.nack_at
        self._answer += ACK if good else NACK
        return good

    def _run(self):
        while (yield) != 0x7F:
            pass
        self._confirm()
        while True:
            command = yield
            if command == 0x7F:  # once more: no complement follows within the time allowed
                self._confirm(False)
                continue
            good = (yield) == command ^ 0xFF and command in COMMANDS
            if self.protected and command in (0x11, 0x21, 0x31, 0x44):
                good = False
            if self._confirm(good):
                yield from {
                    0x00: self._get, 0x01: self._version, 0x02: self._identify,
                    0x11: self._read, 0x21: self._go, 0x31: self._write, 0x44: self._erase,
                }[command]()  # fmt: skip

    def _get(self):
        self._answer += bytes([len(COMMANDS), VERSION, *COMMANDS]) + ACK
        yield from ()

    def _version(self):
        self._answer += bytes([VERSION, 0, 0]) + ACK
        yield from ()

    def _identify(self):
        self._answer += bytes([1]) + self.product.to_bytes(2, "big") + ACK
        yield from ()

    def _address(self):
        octets = []
        for _ in range(5):
            octets.append((yield))
        address = int.from_bytes(octets[:4], "big")
        inside = FLASH <= address < FLASH + len(self.flash)
        return address - FLASH if self._confirm(inside and not reduce(xor, octets)) else None

    def _read(self):
        at = yield from self._address()
        if at is None:
            return
        count = yield
        if self._confirm((yield) == count ^ 0xFF):
            self._answer += self.flash[at : at + count + 1]

    def _write(self):
        at = yield from self._address()
        if at is None:
            return
        octets = [(yield)]
        for _ in range(octets[0] + 2):
            octets.append((yield))
        if not reduce(xor, octets) and self.octets < self.nack_at:
            assert len(octets[1:-1]) % 4 == 0 and at % 4 == 0
            for i, octet in enumerate(octets[1:-1], at):
                self.flash[i] &= 0 if i in self.stuck else octet
        self._confirm(not reduce(xor, octets))

    def _erase(self):
        octets = [(yield), (yield)]
        count = octets[0] << 8 | octets[1]
        numbers = list(range(len(SECTORS)))
        if count < 0xFFF0:
            numbers = []
            for _ in range(count + 1):
                octets += [(yield), (yield)]
                numbers.append(octets[-2] << 8 | octets[-1])
        octets.append((yield))
        if self._confirm(not reduce(xor, octets) and max(numbers) < len(SECTORS)):
            for number in numbers:
                begin = sum(SECTORS[:number])
                self.flash[begin : begin + SECTORS[number]] = b"\xff" * SECTORS[number]
                self.erased.append(number)

    def _go(self):
        at = yield from self._address()
        if at is not None:
            stack, reset = struct.unpack_from("<II", self.flash, at)
            assert RAM < stack <= RAM + 128 * 1024 and reset % 2 and FLASH < reset
            self.started = FLASH + at


class RomLine:
    """A port to the chip; ``flips``: number of the octet that is received to the mask on it."""

    name = "bench"

    def __init__(self, rom, baud, flips=None):
        self.rom, self.baud, self.flips = rom, baud, flips or {}
        self.time, self.coming, self.closed = 0.0, b"", False
        self.sent = self.received = 0

    def write(self, data):
        assert not self.closed
        self.sent += len(data)
        for octet in data:
            self.coming += self.rom.feed(octet, self.baud)

    def read(self, timeout_s):
        assert not self.closed
        data, self.coming = self.coming, b""
        if not data:
            self.time += max(timeout_s, 0.0)
        numbers = range(self.received + 1, self.received + len(data) + 1)
        self.received += len(data)
        return bytes(
            octet ^ self.flips.get(number, 0) for number, octet in zip(numbers, data, strict=True)
        )

    def now(self):
        return self.time

    def close(self):
        self.closed = True


def running(firmware=FIRMWARE, board="stm32f4") -> Program:
    """The program that a started chip runs."""
    made = Program(firmware)
    made.identity["board"] = board
    return made
