"""Images for the STM32F4: the linker's ELF file, reduced to the octets of the flash memory.

Checked before anything is erased: 32-bit little-endian ARM, all octets within the flash, a vector
table at its begin, and the name of the board that the image was built for.
"""

import struct
from dataclasses import dataclass
from itertools import pairwise

from hbench.errors import DataError

MAGIC = b"\x7fELF"
FLASH = 0x0800_0000
FLASH_OCTETS = 512 * 1024  # of an STM32F446RE
BOARD = "stm32f4"

_RAM, _RAM_OCTETS = 0x2000_0000, 128 * 1024
_ARM, _LOADED = 40, 1  # e_machine, p_type
_HEADER = struct.Struct("<4s5B7xHHIIIIIHHH")
_SEGMENT = struct.Struct("<8I")
_BUILD = "Build it with `cmake --preset stm32f4`; the image is hbench-stm32f4.elf."


@dataclass(frozen=True)
class ElfImage:
    """A checked image: ``content`` is for the flash memory from its begin on."""

    name: str
    content: bytes

    @property
    def size(self) -> str:
        """What is loaded, for the user."""
        return f"{len(self.content) / 1024:.1f} kB"

    def seconds(self, baud: int) -> float:
        """Return the time on the line, s: 11 bits an octet, which is written and read back."""
        return 2 * 11 * len(self.content) / baud

    def contains_text(self, text: str) -> bool:
        """Return whether the image contains a string that ends with a zero octet."""
        return text.encode() + b"\0" in self.content


def parse_elf_image(file: bytes, source: str) -> ElfImage:
    """Return the checked image of an ELF file; ``source`` names it in errors.

    Raises ``DataError``: truncated, for another processor or board, or octets outside the flash.
    """
    content = _flash_content(file, source)
    stack, reset = struct.unpack_from("<II", content.ljust(8, b"\0"))
    if not _RAM < stack <= _RAM + _RAM_OCTETS or not FLASH < reset < FLASH + len(content):
        raise DataError(
            f"{source}: no vector table at 0x{FLASH:08X}: stack 0x{stack:08X}, reset 0x{reset:08X}",
            "Link the vector table to the begin of the flash memory, and the stack to the RAM.",
        )
    image = ElfImage(source, content)
    if not image.contains_text(BOARD):
        raise DataError(f"{source}: is not built for the board '{BOARD}'", _BUILD)
    return image


def _flash_content(file: bytes, source: str) -> bytes:
    """Return the loaded segments, with 0xFF between them."""
    try:
        header = _HEADER.unpack_from(file)
        bits, order, machine = header[1], header[2], header[7]
        first, size, count = header[10], header[14], header[15]
        if (bits, order, machine) != (1, 1, _ARM):
            raise DataError(f"{source}: ELF file of another processor than ARM's 32 bits", _BUILD)
        segments = [_SEGMENT.unpack_from(file, first + number * size) for number in range(count)]
    except struct.error:
        raise DataError(f"{source}: truncated ELF file of {len(file)} octets", _BUILD) from None
    parts = []
    for kind, offset, _, address, octets, *_ in segments:
        if kind != _LOADED or not octets:
            continue
        if not FLASH <= address <= FLASH + FLASH_OCTETS - octets:
            raise DataError(
                f"{source}: {octets} octets at 0x{address:08X} are outside the flash memory, "
                f"0x{FLASH:08X}-0x{FLASH + FLASH_OCTETS - 1:08X}",
                _BUILD,
            )
        part = file[offset : offset + octets]
        if len(part) < octets:
            raise DataError(f"{source}: truncated ELF file of {len(file)} octets", _BUILD)
        parts.append((address - FLASH, part))
    parts.sort()
    for (at, part), (following, _) in pairwise(parts):
        if at + len(part) > following:
            raise DataError(f"{source}: segments overlap at 0x{FLASH + following:08X}", _BUILD)
    content = b""
    for at, part in parts:
        content = content.ljust(at, b"\xff") + part
    return content
