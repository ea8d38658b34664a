"""Raw logs as Code Composer Studio data files: 16-bit words, one hex number a line.

Ours begin ``1651 1 0 0 <length>`` (magic, format hex, address, page, length; all in hex) and go
on with four lower-case digits a line. What a record is made of stands in ``campaign.yaml``.
Files of any other make are read by ``ccs_text``; both ways give the same result.
"""

import re

import numpy as np

from hbench.errors import DataError
from hbench.store.campaign.ccs_text import CcsData, count_warnings, parse_ccs

LARGEST_OTHER = 16_000_000  # bytes; line by line takes 25 times the memory

_OURS = re.compile(rb"1651 1 0 0 ([0-9a-f]{1,8})\n")
_NEWLINE = ord("\n")
_DIGITS = np.frombuffer(b"0123456789abcdef", np.uint8)
_NOT_A_DIGIT = 0xFF
_NIBBLES = np.full(256, _NOT_A_DIGIT, np.uint8)
_NIBBLES[_DIGITS] = np.arange(16)


def format_words(words: np.ndarray) -> bytes:
    """Return the data file that holds ``words`` (any shape, uint16), in C order."""
    flat = np.ascontiguousarray(words, np.uint16).ravel()
    lines = np.full((len(flat), 5), _NEWLINE, np.uint8)
    for position, shift in enumerate((12, 8, 4, 0)):
        lines[:, position] = _DIGITS[(flat >> shift) & 0xF]
    return b"1651 1 0 0 %x\n" % len(flat) + lines.tobytes()


def parse_words(data: bytes, source: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the 16-bit words (n,) in a data file of any known make, and warnings.

    A 32-bit hex number is two words, the low one first, as they lie in the DSP's memory.
    A file without a header is read as hex. Raises ``DataError`` naming ``source`` and the line.
    """
    ours = _parse_ours(data)
    if ours is None and len(data) > LARGEST_OTHER:
        raise DataError(
            f"{source}: is no log as this program writes it, and {len(data) / 1e6:.6g} MB large; "
            f"limit of any other {LARGEST_OTHER / 1e6:g} MB"
        )
    parsed = ours or parse_ccs(data, source, headerless="hex")
    return _as_words(parsed.values, source), parsed.warnings


def parse_records(data: bytes, channels: int, source: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the whole records (n, channels) of a log, uint16, and warnings.

    Words after the last whole record are told in a warning "truncated: ...".
    """
    words, warnings = parse_words(data, source)
    records, rest = divmod(len(words), channels)
    if rest:
        warnings += (f"truncated: the last record has {rest} of {channels} words",)
    return words[: records * channels].reshape(records, channels), warnings


def _parse_ours(data: bytes) -> CcsData | None:
    """Read a file exactly as ``format_words`` makes it; None for any other."""
    header = _OURS.match(data)
    if header is None or (len(data) - header.end()) % 5:
        return None
    lines = np.frombuffer(data[header.end() :], np.uint8).reshape(-1, 5)
    nibbles = _NIBBLES[lines[:, :4]]
    if (lines[:, 4] != _NEWLINE).any() or (nibbles == _NOT_A_DIGIT).any():
        return None
    high, low = (nibbles[:, 0] << 4) | nibbles[:, 1], (nibbles[:, 2] << 4) | nibbles[:, 3]
    values = (high.astype(np.uint16) << 8) | low
    return CcsData(values, count_warnings(int(header[1], 16), len(values), 1))


def _as_words(values: np.ndarray, source: str) -> np.ndarray:
    if values.dtype == np.uint16:
        return values
    if values.dtype == np.uint32:
        return values.astype("<u4").view("<u2").astype(np.uint16)
    if values.dtype == np.int64:
        outside = np.flatnonzero((values < -0x8000) | (values > 0xFFFF))
        if len(outside) == 0:
            return (values & 0xFFFF).astype(np.uint16)
        found = f"sample {outside[0] + 1} is {values[outside[0]]}"
    else:
        found = "the samples are decimal fractions"
    raise DataError(
        f"{source}: {found}; expected 16-bit words",
        "A raw log holds words. Save it again as 'Hex 16 bit'.",
    )
