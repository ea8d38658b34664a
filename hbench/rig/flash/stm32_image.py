"""Images for an STM32F4: reader and checks of the linker's output (ELF, 32 bits, little-endian).

The octets of the loadable segments go to their physical addresses, all of them in the chip's flash.
The first word of the vector table at the flash's start is the stack pointer, the second the entry.
"""

import struct
from dataclasses import dataclass
from pathlib import Path

from hbench.config.files.regular_file import FileTooLarge, read_regular_file
from hbench.errors import ConfigError, DataError

FLASH = range(0x08000000, 0x08080000)
RAM = range(0x20000000, 0x20020001)  # of the stack pointer, which may begin at the end
BOARD = "stm32f4"
MAGIC = b"\x7fELF"

_LARGEST = 16_000_000
_HEADER = struct.Struct("<16x2H5I6H")
_SEGMENT = struct.Struct("<8I")
_ARM = 40
_LOAD = 1
_MAKE = "Build it as described in firmware/ports/stm32f4/README.md, and give the .elf file."


@dataclass(frozen=True)
class Stm32Image:
    """A checked image: octets for the flash from its first address on; gaps are 0xFF."""

    name: str
    octets: bytes

    def contains_text(self, text: str) -> bool:
        """Return whether the octets contain a string."""
        return text.encode() in self.octets


def is_stm32_image(path: Path) -> bool:
    """Return whether a file begins as an ELF file does; False if it can't be read."""
    try:
        with path.open("rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def read_stm32_image(path: Path) -> Stm32Image:
    """Read and check an image file. Raises ``ConfigError`` (no file), ``DataError``."""
    try:
        content = read_regular_file(path, _LARGEST)
    except FileTooLarge as error:
        raise DataError(f"{path}: {error}", _MAKE) from None
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror or error}", "Check the path.") from None
    try:
        octets = _flash_of(content, str(path))
    except struct.error:
        raise DataError(f"{path}: truncated ELF file", _MAKE) from None
    image = Stm32Image(str(path), octets)
    if not image.contains_text(BOARD + "\0"):
        raise DataError(
            f"{path}: does not contain the board's name '{BOARD}': firmware of another board",
            _MAKE,
        )
    return image


def _flash_of(content: bytes, source: str) -> bytes:
    """The flash's contents, with complete words at the end."""
    _, machine, _, _, table, _, _, _, entry_size, entries, *_ = _HEADER.unpack_from(content)
    if content[4:6] != b"\x01\x01" or machine != _ARM:
        raise DataError(f"{source}: not for a processor of the Arm architecture (32 bits)", _MAKE)
    flash = bytearray()
    for number in range(entries):
        kind, offset, _, address, size, *_ = _SEGMENT.unpack_from(
            content, table + number * entry_size
        )
        if kind != _LOAD or size == 0:
            continue
        if address not in FLASH or address + size > FLASH.stop:
            raise DataError(
                f"{source}: {size} octets at 0x{address:08X} are outside of the flash, "
                f"0x{FLASH.start:08X}-0x{FLASH.stop - 1:08X}",
                "Link the program for the flash.",
            )
        octets = content[offset : offset + size]
        if len(octets) < size:
            raise struct.error
        begin = address - FLASH.start
        flash += b"\xff" * (begin + size - len(flash))
        flash[begin : begin + size] = octets
    flash += b"\xff" * (-len(flash) % 4)
    stack, entry = struct.unpack_from("<2I", flash)
    if stack not in RAM or entry not in FLASH:
        raise DataError(
            f"{source}: stack pointer 0x{stack:08X} or entry 0x{entry:08X} at the flash's start is "
            "invalid",
            "Link the program with its vector table at the start of the flash.",
        )
    return bytes(flash)
