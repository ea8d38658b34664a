"""A stand-in for the STM32's UART boot ROM, written from ST's AN3155.

``Stm32Rom`` is the chip: octets in, octets out. ``RomLine`` is a port to it with faults.
"""

from functools import reduce
from operator import xor

ACK, NACK = b"\x79", b"\x1f"
FLASH, FLASH_END, RAM = 0x08000000, 0x08080000, range(0x20000000, 0x20020000)
SECTORS = [16 << 10] * 4 + [64 << 10] + [128 << 10] * 3
COMMANDS = bytes([0x00, 0x01, 0x02, 0x11, 0x21, 0x31, 0x44, 0x63, 0x73, 0x82, 0x92])


class Stm32Rom:
    """The chip in its boot ROM. ``started`` is the address of a program that was started.

    ``stuck`` maps offsets in the flash to masks of bits that can't be programmed to 0.
    """

    def __init__(self, chip=0x421, protected=False, stuck=None):
        self.chip, self.protected, self.stuck = chip, protected, stuck or {}
        self.flash = bytearray(b"\xa5" * (FLASH_END - FLASH))  # an older program
        self.started = None
        self.erased = []
        self._rom = self._run()
        self._out = b""
        next(self._rom)

    def feed(self, octet: int) -> bytes:
        """Take an octet, return what goes out."""
        if self.started is not None:
            return b""
        self._out = b""
        self._rom.send(octet)
        return self._out

    def _run(self):
        while (yield) != 0x7F:  # measures the baud rate; silent on anything else
            pass
        self._out += ACK
        while True:
            code = yield
            if (yield) != code ^ 0xFF or code not in COMMANDS:
                self._out += NACK
            elif self.protected and code in (0x11, 0x21, 0x31, 0x44):
                self._out += NACK
            else:
                self._out += ACK
                yield from self._execute(code)

    def _execute(self, code):
        if code == 0x00:
            self._out += bytes([len(COMMANDS), 0x31]) + COMMANDS + ACK
        elif code == 0x01:
            self._out += b"\x31\0\0" + ACK
        elif code == 0x02:
            self._out += b"\x01" + self.chip.to_bytes(2, "big") + ACK
        elif code == 0x44:
            yield from self._erase()
        elif (address := (yield from self._address())) is not None:
            yield from {0x11: self._read, 0x21: self._go, 0x31: self._write}[code](address)

    def _address(self):
        octets = yield from _octets(4)
        address = int.from_bytes(octets, "big")
        valid = FLASH <= address < FLASH_END or address in RAM
        if (yield) != reduce(xor, octets) or not valid:
            self._out += NACK
            return None
        self._out += ACK
        return address

    def _read(self, address):
        count = yield
        if (yield) != count ^ 0xFF:
            self._out += NACK
            return
        begin = address - FLASH
        self._out += ACK + bytes(self.flash[begin : begin + count + 1])

    def _write(self, address):
        count = yield
        data = yield from _octets(count + 1)
        if (yield) != reduce(xor, data, count) or (count + 1) % 4 or address % 4:
            self._out += NACK
            return
        for at, octet in enumerate(data, address - FLASH):
            self.flash[at] &= octet | self.stuck.get(at, 0)  # flash only goes from 1 to 0
        self._out += ACK

    def _erase(self):
        head = yield from _octets(2)
        number = int.from_bytes(head, "big")
        special = number >= 0xFFFD
        codes = b"" if special else (yield from _octets(2 * (number + 1)))
        sectors = (
            list(range(len(SECTORS)))
            if special
            else [int.from_bytes(codes[i : i + 2], "big") for i in range(0, len(codes), 2)]
        )
        if (yield) != reduce(xor, head + codes) or max(sectors) >= len(SECTORS):
            self._out += NACK
            return
        for sector in sectors:
            begin = sum(SECTORS[:sector])
            self.flash[begin : begin + SECTORS[sector]] = b"\xff" * SECTORS[sector]
        self.erased += sectors
        self._out += ACK

    def _go(self, address):
        self.started = address
        return
        yield


def _octets(count):
    octets = b""
    while len(octets) < count:
        octets += bytes([(yield)])
    return octets


class RomLine:
    """A port to a ROM. Octets to and from the ROM are counted from 1.

    ``flips_to`` and ``flips_from``: number of an octet to the mask on it. ``silent_from``: the
    ROM takes nothing from this octet on.
    """

    name = "bench"

    def __init__(self, rom, flips_to=None, flips_from=None, silent_from=None):
        self.rom, self.silent_from = rom, silent_from
        self.flips_to, self.flips_from = flips_to or {}, flips_from or {}
        self.sent = self.received = 0
        self.coming = b""
        self.time = 0.0
        self.closed = False

    def write(self, data):
        for octet in data:
            self.sent += 1
            if self.silent_from is not None and self.sent >= self.silent_from:
                continue
            for answer in self.rom.feed(octet ^ self.flips_to.get(self.sent, 0)):
                self.received += 1
                self.coming += bytes([answer ^ self.flips_from.get(self.received, 0)])

    def read(self, timeout_s):
        self.time += 0.0 if self.coming else timeout_s
        data, self.coming = self.coming, b""
        return data

    def now(self):
        return self.time

    def close(self):
        self.closed = True
