"""Memory that a MATLAB file (version 5 to 7) would take, checked before it is unpacked.

Elements are compressed, so a small file can unpack to a large one, and each array states its own
dimensions, which can exceed its data. Format: MathWorks, MAT-File Format, level 5.
"""

import struct
import zlib
from collections.abc import Iterator

from hbench.errors import DataError
from hbench.store.files.bounded_read import LARGEST_UNPACKED

DEEPEST = 50  # nested structs and cells
MOST_FIELDS = 10_000  # of a struct; the reader's time grows with their square
_MATRIX, _COMPRESSED = 14, 15  # types of elements
_STRUCT = 2  # class of a struct array
_SPARSE = 5  # class of an array whose dimensions may exceed its data
_HEADER = 128
_CHUNK = 1 << 20


def check_mat_sizes(data: bytes, source: str) -> None:
    """Raise ``DataError`` for a file that unpacks to more than ``LARGEST_UNPACKED``.

    Also for an array with more elements than bytes, for deep nesting and for many fields. A
    truncated or damaged file passes; its reader reports it.
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
                        "Check that it is the right file; save fewer variables, or split it.",
                    )
                ((kind, content), *_) = _elements(content, order)
            if kind == _MATRIX:
                _check(content, order, 1, source)
    except (struct.error, ValueError, zlib.error):
        return


def _inflated(packed: memoryview, most: int) -> bytes:
    """Return the unpacked content, at most its first ``most`` bytes."""
    unpacker, chunks, size = zlib.decompressobj(), [], 0
    remaining = bytes(packed)
    while remaining and size < most:
        chunks.append(unpacker.decompress(remaining, min(_CHUNK, most - size)))
        size += len(chunks[-1])
        remaining = unpacker.unconsumed_tail
    return b"".join(chunks)


def _check(content: memoryview, order: str, depth: int, source: str) -> None:
    """Check an array: its flags, dimensions, name, then its content."""
    if depth > DEEPEST:
        raise DataError(f"{source}: structs are nested too deep; limit {DEEPEST}")
    elements_of_array = _elements(content, order)
    (_, flags), (_, dimensions) = (
        next(elements_of_array, (0, b"")),
        next(elements_of_array, (0, b"")),
    )
    if len(flags) < 4 or len(dimensions) % 4:
        return
    count = 1
    for size in struct.unpack(f"{order}{len(dimensions) // 4}i", dimensions):
        count *= max(size, 0)
    array_class = struct.unpack(f"{order}I", flags[:4])[0] & 0xFF
    if count > len(content) and array_class != _SPARSE:
        raise DataError(
            f"{source}: an array of {count} elements has {len(content)} bytes",
            "Save the file again; it is damaged, or forged to exhaust the memory.",
        )
    inner = [content for kind, content in elements_of_array if kind == _MATRIX]
    if array_class == _STRUCT and len(inner) > MOST_FIELDS * max(count, 1):
        raise DataError(
            f"{source}: a struct has {len(inner) // max(count, 1)} fields; limit {MOST_FIELDS}",
            "Save the channels as columns of a matrix.",
        )
    for content in inner:
        _check(content, order, depth + 1, source)


def _elements(
    data: memoryview, order: str, padded: bool = True
) -> Iterator[tuple[int, memoryview]]:
    """Yield type and content of each element; ``padded`` elements begin at multiples of 8."""
    at = 0
    while at + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, at)
        if kind >> 16:  # small element: size and type share a word, the next is the content
            yield kind & 0xFFFF, data[at + 4 : at + 4 + (kind >> 16)]
            at += 8
            continue
        yield kind, data[at + 8 : at + 8 + size]
        at += 8 + (-(-size // 8) * 8 if padded else size)
