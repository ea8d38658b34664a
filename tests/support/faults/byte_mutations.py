"""Ways in which bytes go bad or are forged, made by a seeded generator.

A mutation is a function (generator, data) that returns spoilt bytes.
"""

import io
import struct
import zipfile
import zlib
from random import Random

_SIZES = (
    0,
    1,
    2,
    7,
    8,
    127,
    128,
    255,
    256,
    32767,
    65535,
    65536,
    2**24,
    2**31 - 1,
    2**31,
    2**32 - 1,
)
_LARGE = (2**40, 2**62, 2**63 - 1, 2**63, 2**64 - 1)


def bits_flipped(rng: Random, data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 4, 20))):
        out[rng.randrange(len(out))] ^= 1 << rng.randrange(8)
    return bytes(out)


def bytes_set(rng: Random, data: bytes) -> bytes:
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8))):
        out[rng.randrange(len(out))] = rng.choice((0, 0xFF, 0x7F, 0x80, rng.randrange(256)))
    return bytes(out)


def cut(rng: Random, data: bytes) -> bytes:
    return data[: rng.randrange(len(data))]


def block_inserted(rng: Random, data: bytes) -> bytes:
    at, size = rng.randrange(len(data)), rng.choice((1, 2, 4, 8, 16, 512))
    block = rng.choice((bytes(size), b"\xff" * size, rng.randbytes(size)))
    return data[:at] + block + data[at + rng.choice((0, size)) :]


def block_removed(rng: Random, data: bytes) -> bytes:
    at = rng.randrange(len(data))
    return data[:at] + data[at + rng.choice((1, 2, 4, 8, 64, 512)) :]


def block_copied(rng: Random, data: bytes) -> bytes:
    size = min(rng.choice((4, 8, 16, 64, 512)), len(data))
    start, at = rng.randrange(len(data)), rng.randrange(len(data))
    block = data[start : start + size]
    return data[:at] + block + data[at + rng.choice((0, len(block))) :]


def blocks_swapped(rng: Random, data: bytes) -> bytes:
    size = min(rng.choice((1, 4, 8, 64)), max(1, len(data) // 2))
    a, b = sorted((rng.randrange(len(data)), rng.randrange(len(data))))
    if b - a < size:
        return bits_flipped(rng, data)
    return (
        data[:a] + data[b : b + size] + data[a + size : b] + data[a : a + size] + data[b + size :]
    )


def size_forged(rng: Random, data: bytes) -> bytes:
    """Replace an aligned number by a limit of its type, or by a number near it."""
    width = rng.choice((1, 2, 4, 4, 4, 8, 8))
    order = rng.choice(("little", "little", "little", "big"))
    at = rng.randrange(max(1, len(data) // width)) * width
    old = int.from_bytes(data[at : at + width], order)
    near = (old + 1, old - 1, 2 * old, old * 1000, old // 2, len(data), len(data) - at)
    new = rng.choice((*near, *_SIZES, *(_LARGE if width == 8 else ())))
    return data[:at] + (new % 256**width).to_bytes(width, order) + data[at + width :]


ANY = (bits_flipped, bytes_set, cut, block_inserted, block_removed, block_copied, blocks_swapped)
BINARY = (*ANY, *(size_forged,) * 4)


def several(rng: Random, data: bytes) -> bytes:
    """Spoil once, or a few times."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        if data:
            data = rng.choice(BINARY)(rng, data)
    return data


def in_archive(rng: Random, data: bytes) -> bytes:
    """Spoil a file in a zip archive, whose checksums stay right; or the archive itself."""
    if rng.random() < 0.3:
        return several(rng, data)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    name = rng.choice(sorted(parts))
    parts[name] = several(rng, parts[name])
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, content in parts.items():
            archive.writestr(name, content)
    return file.getvalue()


def in_packed_mat(rng: Random, data: bytes) -> bytes:
    """Spoil a variable of a MATLAB file (version 5 to 7) before it is packed, or the file."""
    if rng.random() < 0.2:
        return several(rng, data)
    head, at, variables = data[:128], 128, []
    while at < len(data):
        size = struct.unpack_from("<I", data, at + 4)[0]
        variables.append(zlib.decompress(data[at + 8 : at + 8 + size]))
        at += 8 + size
    chosen = rng.randrange(len(variables))
    variables[chosen] = several(rng, variables[chosen])
    packed = [zlib.compress(variable, 1) for variable in variables]
    return head + b"".join(struct.pack("<II", 15, len(part)) + part for part in packed)
