"""Raw logs as Code Composer Studio data files: 16-bit words, one hex number a line.

Files written by hbench begin ``1651 1 0 0 <length>`` (magic, format hex, address, page, length;
all in hex) and continue with four lower-case digits a line. ``campaign.yaml`` specifies the
channels of a record. ``ccs_text`` reads files of any other program; both give the same result.
"""

import re
from binascii import hexlify, unhexlify

import numpy as np

from hbench.errors import DataError
from hbench.store.dsp_logs.ccs_text import CcsData, count_warnings, parse_ccs

LARGEST_OTHER = 16_000_000  # bytes; reading line by line takes 25 times the memory

_OWN_FORMAT = re.compile(rb"1651 1 0 0 ([0-9a-f]{1,8})\n")
_NEWLINE = ord("\n")


def format_words(words: np.ndarray) -> bytes:
    """Return ``words`` (any shape, uint16) as a data file, in C order."""
    flat = np.ascontiguousarray(words, ">u2").ravel()
    lines = np.full((len(flat), 5), _NEWLINE, np.uint8)
    lines[:, :4] = np.frombuffer(hexlify(flat.tobytes()), np.uint8).reshape(-1, 4)
    return b"1651 1 0 0 %x\n" % len(flat) + lines.tobytes()


def parse_words(data: bytes, source: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the 16-bit words (n,) of a data file of any known program, and warnings.

    A 32-bit hex number is two words, the low one first, as they lie in the DSP's memory.
    A file without a header is read as hex. Raises ``DataError`` naming ``source`` and the line.
    """
    own = _parse_own_format(data)
    if own is None and len(data) > LARGEST_OTHER:
        raise DataError(
            f"{source}: is not a log written by hbench, and has {len(data) / 1e6:.6g} MB; "
            f"limit for other programs' files {LARGEST_OTHER / 1e6:g} MB"
        )
    parsed = own or parse_ccs(data, source, headerless="hex")
    return _as_words(parsed.values, source), parsed.warnings


def parse_records(data: bytes, channels: int, source: str) -> tuple[np.ndarray, tuple[str, ...]]:
    """Return the whole records (n, channels) of a log, uint16, and warnings.

    A warning "truncated: ..." reports words after the last whole record.
    """
    words, warnings = parse_words(data, source)
    records, excess = divmod(len(words), channels)
    if excess:
        warnings += (f"truncated: the last record has {excess} of {channels} words",)
    return words[: records * channels].reshape(records, channels), warnings


def _parse_own_format(data: bytes) -> CcsData | None:
    """Read a file as ``format_words`` makes it, or with upper-case digits; None for any other."""
    header = _OWN_FORMAT.match(data)
    if header is None or (len(data) - header.end()) % 5:
        return None
    lines = np.frombuffer(data[header.end() :], np.uint8).reshape(-1, 5)
    if (lines[:, 4] != _NEWLINE).any():
        return None
    try:
        octets = unhexlify(lines[:, :4].tobytes())
    except ValueError:  # not a digit
        return None
    values = np.frombuffer(octets, ">u2").astype(np.uint16)
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
        fault = f"sample {outside[0] + 1} is {values[outside[0]]}"
    else:
        fault = "the samples are decimal fractions"
    raise DataError(
        f"{source}: {fault}; expected 16-bit words",
        "A raw log consists of 16-bit words. Save the file again as 'Hex 16 bit'.",
    )
