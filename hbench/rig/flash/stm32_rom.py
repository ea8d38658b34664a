"""Client of the STM32's UART boot ROM: erases, writes and reads back the flash, starts the program.

The host sends 0x7F, from which the ROM measures the baud rate (8 bits, even parity). A command is
an octet and its complement; an address, and a block of at most 256 octets with its length, end with
the exclusive or of their octets. The ROM acknowledges each part with 0x79 or refuses it with 0x1F
(ST AN3155). The program is complete if all octets read back equal the image's.

Written from that document and tested with a simulated ROM only, never on hardware.
"""

from functools import reduce
from itertools import accumulate
from operator import xor

from hbench.errors import DeviceError
from hbench.rig.flash.stm32_image import FLASH, Stm32Image
from hbench.rig.ports import Port

CHIPS = {0x413: "STM32F405/F407", 0x421: "STM32F446"}
BLOCK = 256
_SECTORS = (4 * [16 << 10]) + [64 << 10] + (3 * [128 << 10])
_SECTOR_ENDS = tuple(accumulate(_SECTORS))

_ACK, _NACK = b"\x79", b"\x1f"
_AUTOBAUD = b"\x7f"
_AUTOBAUD_ATTEMPTS = 5
_GET_ID, _READ, _GO, _WRITE, _ERASE = 0x02, 0x11, 0x21, 0x31, 0x44
_TIMEOUT_S = 1.0
_ERASE_TIMEOUT_S = 30.0  # a sector of 128 kB takes up to 4 s

_RESET = "Set BOOT0 high, reset the board and try again"
_REPEAT = f"The flash is incomplete. {_RESET}, at a lower --boot-baud if it happens again."


def flash(image: Stm32Image, port: Port) -> str:
    """Write ``image``, read it back, start it; return the chip's name. Raises ``DeviceError``."""
    rom = _Rom(port)
    rom.synchronise()
    chip = rom.chip()
    blocks = [
        (FLASH.start + at, image.octets[at : at + BLOCK])
        for at in range(0, len(image.octets), BLOCK)
    ]
    rom.erase(len(image.octets))
    for address, octets in blocks:
        rom.write(address, octets)
    for address, octets in blocks:
        rom.verify(address, octets)
    rom.go(FLASH.start)
    return chip


class _Rom:
    """The boot ROM's commands."""

    def __init__(self, port: Port):
        self._port = port
        self._octets = b""

    def synchronise(self) -> None:
        for _ in range(_AUTOBAUD_ATTEMPTS):
            self._port.write(_AUTOBAUD)
            answer = self._port.read(_TIMEOUT_S)
            if answer in (_ACK, _NACK):  # refused: measured already, and taken for a command
                return
            if answer:
                raise self._error(
                    f"answers the boot ROM's 0x7F with {answer[:16].hex(' ').upper()}; expected 79",
                    f"A program may be running: {_RESET.lower()}, or lower --boot-baud.",
                )
        raise self._error(
            f"no answer of the boot ROM in {_AUTOBAUD_ATTEMPTS} attempts",
            "Check power, cable (crossed?) and port: the boot ROM of an F446 uses PA9 and PA10, "
            f"not the Nucleo's USB port. {_RESET}.",
        )

    def chip(self) -> str:
        self._command(_GET_ID, "the request for the chip's id")
        count = self._take(1, "the chip's id")[0] + 1
        number = int.from_bytes(self._take(count, "the chip's id"), "big")
        self._acknowledge("the request for the chip's id")
        if number not in CHIPS:
            raise self._error(
                f"chip 0x{number:03X} is not one of {', '.join(CHIPS.values())}",
                "Connect a board that the image is for; nothing was written.",
            )
        return CHIPS[number]

    def erase(self, octets: int) -> None:
        sectors = 1 + next(i for i, end in enumerate(_SECTOR_ENDS) if octets <= end)
        self._command(_ERASE, "the erasure")
        codes = b"".join(number.to_bytes(2, "big") for number in (sectors - 1, *range(sectors)))
        self._send(codes, f"the erasure of {sectors} sectors", _ERASE_TIMEOUT_S)

    def write(self, address: int, octets: bytes) -> None:
        what = f"the block at 0x{address:08X}"
        self._command(_WRITE, what)
        self._send(address.to_bytes(4, "big"), what)
        self._send(bytes([len(octets) - 1]) + octets, what)

    def verify(self, address: int, octets: bytes) -> None:
        what = f"the reading of 0x{address:08X}"
        self._command(_READ, what)
        self._send(address.to_bytes(4, "big"), what)
        count = len(octets) - 1
        self._port.write(bytes([count, count ^ 0xFF]))
        self._acknowledge(what)
        for at, (read, written) in enumerate(
            zip(self._take(len(octets), what), octets, strict=True)
        ):
            if read != written:
                raise self._error(
                    f"0x{address + at:08X} reads back 0x{read:02X}; written was 0x{written:02X}",
                    _REPEAT,
                )

    def go(self, address: int) -> None:
        self._command(_GO, "the start of the program")
        self._send(address.to_bytes(4, "big"), "the start of the program")

    def _command(self, code: int, what: str) -> None:
        self._port.write(bytes([code, code ^ 0xFF]))
        self._acknowledge(what, refused="the chip may be protected against reading or writing")

    def _send(self, octets: bytes, what: str, timeout_s: float = _TIMEOUT_S) -> None:
        self._port.write(octets + bytes([reduce(xor, octets)]))
        self._acknowledge(what, timeout_s, refused="wrong checksum, or an invalid address")

    def _acknowledge(
        self, what: str, timeout_s: float = _TIMEOUT_S, refused: str = "damaged on the line"
    ) -> None:
        answer = self._take(1, what, timeout_s)
        if answer == _NACK:
            raise self._error(f"the boot ROM refused {what}: {refused}", _REPEAT)
        if answer != _ACK:
            raise self._error(
                f"answers {what} with 0x{answer.hex().upper()}; expected 0x79", _REPEAT
            )

    def _take(self, count: int, what: str, timeout_s: float = _TIMEOUT_S) -> bytes:
        while len(self._octets) < count:
            octets = self._port.read(timeout_s)
            if not octets:
                raise self._error(f"no answer to {what} in {timeout_s:g} s", _REPEAT)
            self._octets += octets
        taken, self._octets = self._octets[:count], self._octets[count:]
        return taken

    def _error(self, what: str, hint: str) -> DeviceError:
        return DeviceError(f"{self._port.name}: {what}", hint)
