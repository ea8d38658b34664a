"""What a MATLAB file (version 5 to 7) would take in memory, before anything is made of it.

Its elements are compressed, so a small file can stand for a large one, and each array says its own
dimensions, which may be more than there are numbers. Format: MathWorks, MAT-File Format, level 5.
"""

import struct
import zlib
from collections.abc import Iterator

from hbench.errors import DataError

LARGEST_UNPACKED = 200_000_000  # bytes
DEEPEST = 50  # structs and cells in each other
_MATRIX, _COMPRESSED = 14, 15  # types of elements
_SPARSE = 5  # class of an array that may be larger than what it holds
_HEADER = 128
_CHUNK = 1 << 20


def check_mat_sizes(data: bytes, source: str) -> None:
    """Raise ``DataError`` for a file that unpacks to more than ``LARGEST_UNPACKED``.

    Also for an array with more elements than it has bytes, and for deep nesting. A file that is
    cut or garbled is left to its reader.
    """
    if len(data) < _HEADER or 0 in data[:4]:  # version 4 begins with a number and packs nothing
        return
    order = "<" if data[126:128] == b"IM" else ">"
    left = LARGEST_UNPACKED
    try:
        for kind, content in _elements(memoryview(data)[_HEADER:], order, padded=False):
            if kind == _COMPRESSED:
                content = memoryview(_inflated(content, left))
                left -= len(content)
                if not left:
                    raise DataError(
                        f"{source}: unpacks to more than {LARGEST_UNPACKED / 1e6:g} MB",
                        "Is it the right file? Save fewer variables, or split it.",
                    )
                ((kind, content), *_) = _elements(content, order)
            if kind == _MATRIX:
                _check(content, order, 1, source)
    except (struct.error, ValueError, zlib.error):
        return


def _inflated(packed: memoryview, most: int) -> bytes:
    """Return what is packed, or its first ``most`` bytes."""
    unpacker, parts, size = zlib.decompressobj(), [], 0
    todo = bytes(packed)
    while todo and size < most:
        parts.append(unpacker.decompress(todo, min(_CHUNK, most - size)))
        size += len(parts[-1])
        todo = unpacker.unconsumed_tail
    return b"".join(parts)


def _check(content: memoryview, order: str, depth: int, source: str) -> None:
    """Check an array: its flags, dimensions, name, then what it holds."""
    if depth > DEEPEST:
        raise DataError(f"{source}: holds structs more than {DEEPEST} deep")
    parts = _elements(content, order)
    (_, flags), (_, dimensions) = next(parts, (0, b"")), next(parts, (0, b""))
    if len(flags) < 4 or len(dimensions) % 4:
        return
    elements = 1
    for size in struct.unpack(f"{order}{len(dimensions) // 4}i", dimensions):
        elements *= max(size, 0)
    array_class = struct.unpack(f"{order}I", flags[:4])[0] & 0xFF
    if elements > len(content) and array_class != _SPARSE:
        raise DataError(
            f"{source}: an array of {elements} elements has {len(content)} bytes",
            "The file is damaged, or was made to take all memory.",
        )
    for kind, inner in parts:
        if kind == _MATRIX:
            _check(inner, order, depth + 1, source)


def _elements(
    data: memoryview, order: str, padded: bool = True
) -> Iterator[tuple[int, memoryview]]:
    """Yield type and content of each element; ``padded``: they begin at multiples of 8 bytes."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if kind >> 16:  # a small one: size and type share a word, the content stands in the next
            yield kind & 0xFFFF, data[at + 4 : at + 4 + (kind >> 16)]
            at += 8
            continue
        yield kind, data[at + 8 : at + 8 + size]
        at += 8 + (-(-size // 8) * 8 if padded else size)
