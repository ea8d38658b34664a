"""Boot images of the F28335: reader and checks of the text that ``hex2000 -boot -sci8 -a`` writes.

The text consists of hex octets separated by whitespace, optionally between 0x02 and 0x03. The
octets are the stream for the serial boot ROM: 16-bit words with the low octet first, 32-bit values
with the high word first (TI SPRUI07 and SPRU513):

    AA 08               key 0x08AA
    8 words             reserved
    2 words             entry point
    blocks              {number of words, address (2 words), the words}
    00 00               end: a block of no words

Written from those documents; not yet tried with a board.
"""

import re
from dataclasses import dataclass

from hbench.errors import DataError

KEY = b"\xaa\x08"
_RESERVED_OCTETS = 16
LOADABLE = ((0x000000, 0x000001), (0x000050, 0x0007FF), (0x008000, 0x00FFFF))
"""First and last address of M0 and M1, less the ROM's own stack, and of L0 to L7."""

_OCTET = re.compile(r"[0-9A-Fa-f]{2}")
_MAKE = "Build it with `hex2000 -boot -sci8 -a -o image.txt program.out`."


@dataclass(frozen=True)
class MemoryBlock:
    """Words for consecutive addresses."""

    address: int
    words: tuple[int, ...]


@dataclass(frozen=True)
class BootImage:
    """A checked image; ``stream`` are the octets for the line, including the end mark."""

    name: str
    entry: int
    blocks: tuple[MemoryBlock, ...]
    stream: bytes

    @property
    def size(self) -> str:
        """What is loaded, for the user."""
        words = sum(len(block.words) for block in self.blocks)
        return f"{words} words in {len(self.blocks)} blocks"

    def seconds(self, baud: int) -> float:
        """Return the time on the line, s: 10 bits an octet."""
        return 10 * len(self.stream) / baud

    def contains_text(self, text: str) -> bool:
        """Return whether the loaded memory contains a string, one character per word (C28x)."""
        memory: dict[int, int] = {}
        for block in self.blocks:
            memory.update(enumerate(block.words, block.address))
        wanted = [ord(character) for character in text]
        return any(
            all(memory.get(address + i) == word for i, word in enumerate(wanted))
            for address in memory
        )


def parse_boot_image(text: str, source: str) -> BootImage:
    """Return the checked image in hex2000's text; ``source`` names it in errors.

    Raises ``DataError``: not hex text, wrong key or header, truncated, or a block or the entry
    point where the boot ROM can't load.
    """
    cursor = _Cursor(_octets(text, source), source)
    _check_key(cursor.take(2, "the key"), source)
    cursor.take(_RESERVED_OCTETS, "the reserved words")
    entry = cursor.long("the entry point")
    blocks: list[MemoryBlock] = []
    while count := cursor.word(f"the size of block {len(blocks) + 1}"):
        number = len(blocks) + 1
        address = cursor.long(f"the address of block {number}")
        _check_place(number, address, count, source)
        octets = cursor.take(2 * count, f"block {number} ({count} words at 0x{address:06X})")
        blocks.append(MemoryBlock(address, _words(octets)))
    stream, rest = cursor.split()
    if any(rest):
        raise DataError(f"{source}: {len(rest)} octets follow the end mark", _MAKE)
    if not any(b.address <= entry < b.address + len(b.words) for b in blocks):
        raise DataError(
            f"{source}: entry point 0x{entry:06X} is in none of the {len(blocks)} blocks",
            "Link the program for RAM, with its entry point (-e) in a loaded section.",
        )
    return BootImage(source, entry, tuple(blocks), stream)


class _Cursor:
    """Reader of the octets, which names the truncated section in errors."""

    def __init__(self, octets: bytes, source: str):
        self._octets = octets
        self._source = source
        self._at = 0

    def take(self, count: int, what: str) -> bytes:
        part = self._octets[self._at : self._at + count]
        if len(part) < count:
            raise DataError(
                f"{self._source}: truncated in {what}: {len(part)} of {count} octets, "
                f"{len(self._octets)} in all",
                "Copy or build the image again; a complete one ends with a block of size 0.",
            )
        self._at += count
        return part

    def word(self, what: str) -> int:
        return _words(self.take(2, what))[0]

    def long(self, what: str) -> int:
        high, low = _words(self.take(4, what))
        return high << 16 | low

    def split(self) -> tuple[bytes, bytes]:
        return self._octets[: self._at], self._octets[self._at :]


def _words(octets: bytes) -> tuple[int, ...]:
    return tuple(low | high << 8 for low, high in zip(octets[::2], octets[1::2], strict=True))


def _octets(text: str, source: str) -> bytes:
    octets = bytearray()
    for number, line in enumerate(text.translate({2: " ", 3: " "}).split("\n"), 1):
        for token in line.split():
            if token.startswith("$A"):
                raise DataError(
                    f"{source}: line {number}: address record {token!r}: built without -boot", _MAKE
                )
            if not _OCTET.fullmatch(token):
                raise DataError(
                    f"{source}: line {number}: {token[:24]!r} is not a hex octet", _MAKE
                )
            octets.append(int(token, 16))
    return bytes(octets)


def _check_key(key: bytes, source: str) -> None:
    if key == KEY:
        return
    fault = f"begins with {key.hex(' ').upper()}; expected AA 08"
    if KEY[0] in key:
        raise DataError(
            f"{source}: {fault}: header of another boot mode, built without -sci8", _MAKE
        )
    raise DataError(
        f"{source}: {fault}: with a wrong key, the boot ROM runs the program in flash", _MAKE
    )


def _check_place(number: int, address: int, count: int, source: str) -> None:
    outside = _first_outside(address, count)
    if outside is None:
        return
    regions = ", ".join(f"0x{first:06X}-0x{last:06X}" for first, last in LOADABLE)
    raise DataError(
        f"{source}: block {number} ({count} words at 0x{address:06X}): 0x{outside:06X} is outside "
        f"loadable RAM, {regions}",
        "Link the program for RAM: the serial boot ROM loads no other memory, and "
        "0x000002-0x00004F is its own stack.",
    )


def _first_outside(address: int, count: int) -> int | None:
    end = address + count
    while address < end:
        last = next((last for first, last in LOADABLE if first <= address <= last), None)
        if last is None:
            return address
        address = last + 1
    return None
