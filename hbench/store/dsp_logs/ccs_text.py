"""Reader of Code Composer Studio data files, tolerant of the variations that occur in practice.

    1651 <format> <address> <page> <length> [<new format>]      all in hex, without 0x
    one sample a line

Formats: 1 hex, 2 integer, 3 long, 4 float, 9 (see ``new format``, whose codes depend on the target
and are not documented). Known variations: length 0 for "to the end of the file", CRLF, ``0x``
prefixes, 32-bit hex numbers, decimal numbers under format 1, a wrong length, no header at all.
"""

import re
from dataclasses import dataclass
from typing import Literal

import numpy as np

from hbench.errors import DataError

Notation = Literal["hex", "integer", "float"]

_NOTATIONS: dict[int, Notation] = {2: "integer", 3: "integer", 4: "float"}
_SAMPLE: dict[Notation, re.Pattern[str]] = {
    "hex": re.compile(r"(?:0[xX])?([0-9a-fA-F]{1,8})"),
    "integer": re.compile(r"[-+]?\d{1,18}"),
    "float": re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?(?:nan|inf)"),
}
_EXPECTED: dict[Notation, str] = {
    "hex": "a hex number of up to 8 digits",
    "integer": "a whole decimal number",
    "float": "a decimal number",
}
_SAVE_AGAIN = "Save the file again as 'Hex 16 bit' (format 1)."


@dataclass(frozen=True)
class CcsData:
    """Samples of a data file, and warnings about the file ("code: text")."""

    values: np.ndarray  # (n,) uint16 or uint32 from hex, int64 or float64 from decimal
    warnings: tuple[str, ...]


def parse_ccs(data: bytes, source: str, headerless: Notation | None = None) -> CcsData:
    """Read a data file.

    ``headerless`` is the notation of a file without header; None infers it. Raises ``DataError``
    naming ``source``, the line, its text and the expected form.
    """
    lines, ended = _lines(data, source)
    first_line = lines[0].split() if lines else []
    announced, code = 0, 0
    warnings: list[str] = []
    if len(first_line) > 1:
        code, announced = _header(first_line, source)
        samples, offset = [line.strip() for line in lines[1:]], 2
        notation = _notation(code, samples, source, warnings)
    else:
        samples, offset = [line.strip() for line in lines], 1
        notation = headerless or _infer(samples, source)
        warnings.append(f"header: no '1651' line; read as {notation} samples")
    if notation == "hex" and not ended and _is_cut(samples):
        warnings.append(f"truncated: the last line ({samples.pop()!r}) is cut off")
    values = _values(samples, notation, offset, source)
    words_a_sample = 2 if code in (3, 4) or values.dtype == np.uint32 else 1
    return CcsData(values, (*warnings, *count_warnings(announced, len(values), words_a_sample)))


def count_warnings(announced: int, samples: int, words_a_sample: int) -> tuple[str, ...]:
    """Compare the header's length, in samples or words, with the samples read. 0 is any length."""
    if announced in (0, samples, samples * words_a_sample):
        return ()
    code = "truncated" if samples < announced else "length"
    return (f"{code}: the header announces {announced} samples, the file contains {samples}",)


def _lines(data: bytes, source: str) -> tuple[list[str], bool]:
    try:
        text = data.removeprefix(b"\xef\xbb\xbf").decode("ascii")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise DataError(
            f"{source}: line {line}: found byte 0x{data[error.start]:02x}; expected text in ASCII"
        ) from None
    lines = text.split("\n")  # not splitlines, which also splits at form feeds and the like
    while lines and not lines[-1].strip():
        lines.pop()
    return lines, text.endswith(("\n", "\r", " ", "\t"))


def _header(fields: list[str], source: str) -> tuple[int, int]:
    """Return the header's format and length."""
    expected = "expected '1651 format address page length [new format]' in hex"
    try:
        magic, *numbers = (int(field[:17], 16) for field in fields)  # no number is as long
    except ValueError:
        magic, numbers = 0, []
    if magic != 0x1651 or len(numbers) not in (4, 5) or min(numbers) < 0:
        raise DataError(f"{source}: line 1: found {' '.join(fields)[:60]!r}; {expected}")
    code, length = numbers[0], numbers[3]
    if code not in (1, 2, 3, 4, 9):
        raise DataError(
            f"{source}: line 1: found format {code:x}; expected 1, 2, 3, 4 or 9", _SAVE_AGAIN
        )
    return code, length


def _notation(code: int, samples: list[str], source: str, warnings: list[str]) -> Notation:
    if code in _NOTATIONS:
        return _NOTATIONS[code]
    if code == 9:
        notation = _infer(samples, source)
        warnings.append(f"format: 9 does not specify the notation; read as {notation} samples")
        return notation
    decimal = [s for s in samples if s[:2].lower() != "0x" and re.search(r"[-+.]", s)]
    if not decimal:
        return "hex"
    warnings.append(
        f"format: 1 means hex, but {decimal[0]!r} is decimal; all samples read as decimal"
    )
    return "float" if any("." in s for s in samples) else "integer"


def _infer(samples: list[str], source: str) -> Notation:
    """Infer the notation from the samples; refuse bare digits, which could be hex or decimal."""
    if any("." in s for s in samples):
        return "float"
    if any(s[:2].lower() == "0x" for s in samples):
        return "hex"
    if any(s[:1] in "+-" for s in samples if s):
        return "integer"
    if any(re.search("[a-fA-F]", s) for s in samples) or not samples:
        return "hex"
    if len({len(s) for s in samples}) == 1 and any(s[0] == "0" and len(s) > 1 for s in samples):
        return "hex"  # padded with zeros to one width
    raise DataError(
        f"{source}: samples such as {samples[0]!r} can be hex or decimal",
        _SAVE_AGAIN,
    )


def _is_cut(samples: list[str]) -> bool:
    """Return whether the last of samples padded to four or eight digits is shorter than others."""
    widths = {len(s.lower().removeprefix("0x")) for s in samples[:-1]}
    padded = widths == {4} or widths == {8}
    return padded and len(samples[-1]) < len(samples[0])


def _values(samples: list[str], notation: Notation, offset: int, source: str) -> np.ndarray:
    match = _SAMPLE[notation].fullmatch
    for number, sample in enumerate(samples):
        if not match(sample):
            raise DataError(
                f"{source}: line {number + offset}: found {sample[:40]!r}; "
                f"expected {_EXPECTED[notation]}"
            )
    if notation == "float":
        return np.array([float(s) for s in samples], np.float64)
    if notation == "integer":
        return np.array([int(s) for s in samples], np.int64)
    wide = any(len(s.lower().removeprefix("0x")) > 4 for s in samples)
    return np.array([int(s, 16) for s in samples], np.uint32 if wide else np.uint16)
