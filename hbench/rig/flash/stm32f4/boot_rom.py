"""Client of the STM32F4's serial boot ROM: erases, writes, reads back and starts (ST AN3155).

The host sends 0x7F, from which the ROM measures the baud rate; the line has even parity. Each
command is an octet and its complement. The ROM answers each part with ACK or NACK; addresses and
data carry the XOR of their octets.

    GET ID 02            product of the chip: images are refused on another one
    EXTENDED ERASE 44    sectors of the image, one at a time
    WRITE 31, READ 11    up to 256 octets
    GO 21                starts the program whose vector table is at the address

Nothing is erased before chip and image have been checked. Written from AN3155 and AN2606, and
tested with a simulated ROM only, never on hardware.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import reduce
from operator import xor

from hbench.errors import DeviceError
from hbench.rig.flash.boot import BootRom
from hbench.rig.flash.identity import NotInBoot
from hbench.rig.flash.stm32f4.elf_image import FLASH, ElfImage
from hbench.rig.ports import Port

BLOCK = 256  # octets of a write or read
SECTORS_KB = (16, 16, 16, 16, 64, 128, 128, 128)

_SYNCHRONISE, _ACK, _NACK = b"\x7f", 0x79, 0x1F
_GET_ID, _READ, _GO, _WRITE, _EXTENDED_ERASE = 0x02, 0x11, 0x21, 0x31, 0x44
_PRODUCTS = {
    0x413: "STM32F405/407", 0x419: "STM32F42x/43x", 0x421: "STM32F446", 0x423: "STM32F401xB/C",
    0x431: "STM32F411", 0x433: "STM32F401xD/E", 0x434: "STM32F469/479", 0x441: "STM32F412",
    0x458: "STM32F410", 0x463: "STM32F413/423",
}  # fmt: skip
_PORT_IS_FOR = (0x413, 0x421)  # the same registers, and enough memory

_ATTEMPTS = 10  # to synchronise
_ATTEMPT_S = 0.5
_ANSWER_S = 1.0
_ERASE_S = 8.0  # a sector of 128 kB takes 4 s at most, 8 bits at a time
_RESET = "Connect BOOT0 to 3.3 V, reset the board and try again"
_LINE = f"Check the cable for interference, or lower --boot-baud. {_RESET}."
_SILENT_PROGRAM = (
    "The flash memory was read back and is right. Connect BOOT0 to ground and reset the board. "
    "Where the firmware answers on another line, name it with --firmware-port."
)


def send_image(port: Port, image: ElfImage) -> None:
    """Write ``image`` to the flash memory, compare what is read back, and start it.

    Raises ``DeviceError``.
    """
    line = _Line(port)
    line.synchronise()
    product = line.product()
    if product not in _PORT_IS_FOR:
        known = _PRODUCTS.get(product, "unknown")
        right = " or ".join(_PRODUCTS[number] for number in _PORT_IS_FOR)
        raise DeviceError(
            f"{port.name}: the chip is a 0x{product:03X} ({known}); {image.name} is for an {right}",
            "Nothing was erased. Give the image of this board.",
        )
    content = image.content.ljust(-(-len(image.content) // 4) * 4, b"\xff")
    blocks = [(FLASH + at, content[at : at + BLOCK]) for at in range(0, len(content), BLOCK)]
    for sector in _sectors(len(content)):
        line.erase(sector)
    for address, block in blocks:
        line.write(address, block)
    for address, block in blocks:
        _compare(port.name, address, block, line.read(address, len(block)))
    line.go(FLASH)


def _sectors(octets: int) -> Iterator[int]:
    """Return the numbers of the sectors that the first ``octets`` of the flash lie in."""
    begin = 0
    for number, size_kb in enumerate(SECTORS_KB):
        if begin < octets:
            yield number
        begin += 1024 * size_kb


def _compare(name: str, address: int, block: bytes, read: bytes) -> None:
    for at, (wanted, found) in enumerate(zip(block, read, strict=True), address):
        if wanted != found:
            raise DeviceError(
                f"{name}: read back 0x{found:02X} at 0x{at:08X}; written 0x{wanted:02X}",
                f"The program was not started. {_RESET}; if it happens again, the flash memory is "
                "worn or write-protected.",
            )


class _Line:
    """The commands of the ROM."""

    def __init__(self, port: Port):
        self._port = port
        self._received = b""

    def synchronise(self) -> None:
        """Wait for the ROM. A NACK comes from one that has been synchronised before."""
        for _ in range(_ATTEMPTS):
            self._port.write(_SYNCHRONISE)
            answer = self._port.read(_ATTEMPT_S)
            if not answer:
                continue
            if answer[0] in (_ACK, _NACK) and len(answer) == 1:
                return
            raise NotInBoot(
                f"{self._port.name}: answers the boot ROM's first octet 7F with "
                f"{answer[:16].hex(' ').upper()}; expected 79",
                f"{_RESET}, or lower --boot-baud.",
            )
        raise NotInBoot(
            f"{self._port.name}: no board: no answer to the boot ROM's first octet 7F in "
            f"{_ATTEMPTS} attempts, and no answer of a running hbench firmware",
            f"Check power, cable (crossed?) and pins (PC10, PC11 or PA9, PA10). {_RESET}.",
        )

    def product(self) -> int:
        """Return the product's number."""
        with self._named("get ID"):
            self._command(_GET_ID)
            count = self._take(1)[0] + 1
            number = int.from_bytes(self._take(count), "big")
            self._confirmed("end of the answer")
        return number

    def erase(self, sector: int) -> None:
        """Erase a sector by its number."""
        with self._named(f"erase of sector {sector}"):
            self._command(_EXTENDED_ERASE)
            self._send((0).to_bytes(2, "big") + sector.to_bytes(2, "big"))  # the number less one
            self._confirmed("sector", _ERASE_S)

    def write(self, address: int, block: bytes) -> None:
        """Write up to 256 octets, a multiple of four."""
        with self._named(f"write at 0x{address:08X}"):
            self._command(_WRITE)
            self._address(address)
            self._send(bytes([len(block) - 1]) + block)
            self._confirmed("data")

    def read(self, address: int, count: int) -> bytes:
        """Read up to 256 octets."""
        with self._named(f"read at 0x{address:08X}"):
            self._command(_READ)
            self._address(address)
            self._port.write(bytes([count - 1, 0xFF ^ (count - 1)]))
            self._confirmed("number of octets")
            return self._take(count)

    def go(self, address: int) -> None:
        """Start the program whose vector table is at ``address``."""
        with self._named("start"):
            self._command(_GO)
            self._address(address)

    def _command(self, code: int) -> None:
        self._port.write(bytes([code, 0xFF ^ code]))
        if self._answer(_ANSWER_S) == _NACK:
            raise DeviceError(
                "the ROM refuses the command: read-protected flash memory, or a disturbed line",
                f"{_RESET}. If it happens again, remove the protection with ST's programmer, which "
                "erases the chip.",
            )

    def _address(self, address: int) -> None:
        self._send(address.to_bytes(4, "big"))
        self._confirmed("address")

    def _send(self, octets: bytes) -> None:
        self._port.write(octets + bytes([reduce(xor, octets)]))

    def _confirmed(self, what: str, timeout_s: float = _ANSWER_S) -> None:
        if self._answer(timeout_s) == _NACK:
            raise DeviceError(f"the ROM refuses the {what}", _LINE)

    def _answer(self, timeout_s: float) -> int:
        octet = self._take(1, timeout_s)[0]
        if octet not in (_ACK, _NACK):
            raise DeviceError(f"answer 0x{octet:02X} instead of ACK (79) or NACK (1F)", _LINE)
        return octet

    def _take(self, count: int, timeout_s: float = _ANSWER_S) -> bytes:
        deadline = self._port.now() + timeout_s
        while len(self._received) < count:
            more = self._port.read(deadline - self._port.now())
            if not more:
                raise DeviceError(f"no answer in {timeout_s:g} s", _LINE)
            self._received += more
            deadline = self._port.now() + timeout_s
        taken, self._received = self._received[:count], self._received[count:]
        return taken

    @contextmanager
    def _named(self, step: str) -> Iterator[None]:
        """Put port and step before an error's message."""
        try:
            yield
        except DeviceError as error:
            if error.message.startswith(f"{self._port.name}: "):  # of the port itself
                raise
            raise DeviceError(f"{self._port.name}: {step}: {error.message}", error.hint) from None


ROM = BootRom(send_image, f"{_RESET}.", _SILENT_PROGRAM)
