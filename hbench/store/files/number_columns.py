"""Columns of numbers as text, formatted by whole columns.

Most logs contain decimal numbers with few digits. A column of them is written with as many decimals
as its values need, from digits that numpy computes; other columns have all digits of each float.
"""

from collections.abc import Iterator, Sequence

import numpy as np
from pydantic_core import to_json

_LARGEST = 10**15  # whole numbers up to here, and quotients by powers of ten up to here, are exact
_FEW = 100  # values that are tested before all are
_BLOCK = 50_000  # rows formatted at a time, which bounds the memory
_FOUR_DIGITS = np.frombuffer(b"".join(b"%04d" % n for n in range(10_000)), dtype=np.uint32)
_COMMA, _NEWLINE, _POINT, _MINUS, _ZERO = b",\n.-0"


def formatted_rows(columns: Sequence[np.ndarray]) -> Iterator[bytes]:
    """Yield the rows of ``columns``, each (n,), as CSV, a block of rows at a time.

    Each number is read back as the same float; NaN is "nan".
    """
    decimals = [_exact_decimals(values) for values in columns]
    for start in range(0, len(columns[0]), _BLOCK):
        cells: list[np.ndarray] = []
        for values, places in zip(columns, decimals, strict=True):
            block = values[start : start + _BLOCK]
            cells += [_all_digits(block) if places is None else _fixed_point(block, places)]
            cells += [np.full((len(block), 1), _COMMA, dtype=np.uint8)]
        cells[-1][:] = _NEWLINE
        yield np.hstack(cells).tobytes().translate(None, b"\0")


def rounded_to_decimals(values: np.ndarray) -> np.ndarray:
    """Return ``values`` (n,) without the rounding errors of a conversion between decimal units.

    If all values are within 2 ulp of decimal numbers with equally many decimals, return these;
    otherwise, as for the samples of a converter, return ``values`` itself.
    """
    known = values[~np.isnan(values)]
    for factor in _powers_of_ten(known):
        if all(_is_near_whole(some * factor) for some in (known[:_FEW], known)):
            return np.rint(values * factor) / factor
    return values


def _exact_decimals(values: np.ndarray) -> int | None:
    """Return the least number of decimals that gives each value exactly; None if there is none."""
    known = values[~np.isnan(values)]
    for places, factor in enumerate(_powers_of_ten(known)):
        if all((np.rint(some * factor) / factor == some).all() for some in (known[:_FEW], known)):
            return places
    return None


def _powers_of_ten(values: np.ndarray) -> Iterator[float]:
    """Yield 1, 10, 100, ... up to the largest by which all products are below ``_LARGEST``."""
    factor, most = 1.0, np.abs(values).max(initial=1.0)
    while most * factor < _LARGEST:
        yield factor
        factor *= 10.0


def _is_near_whole(values: np.ndarray) -> bool:
    return bool((np.abs(np.rint(values) - values) <= 2 * np.spacing(np.abs(values))).all())


def _all_digits(values: np.ndarray) -> np.ndarray:
    """Return cells (n, width) of characters, 0 where there is none."""
    numbers = to_json(values.tolist(), inf_nan_mode="constants")  # ten times as fast as repr
    cells = np.array(numbers[1:-1].replace(b"NaN", b"nan").split(b","))
    return cells.view(np.uint8).reshape(len(values), -1)


def _fixed_point(values: np.ndarray, places: int) -> np.ndarray:
    """Return cells (n, width) of characters, 0 where there is none: "-12.50" for two ``places``."""
    unknown = np.isnan(values)
    whole = np.rint(np.where(unknown, 0, np.abs(values)) * 10.0**places).astype(np.uint64)
    digits = _digits(whole)
    before = max(len(str(whole.max())) - places, 1)  # digits before the point
    after = max(places, 1)
    cells = np.zeros((len(values), 1 + before + 1 + after), dtype=np.uint8)
    cells[:, 0] = np.signbit(values) * np.uint8(_MINUS)
    point = digits.shape[1] - places
    cells[:, 1 : 1 + before] = digits[:, point - before : point]
    for leading in range(before - 1):
        cells[:, 1 + leading] *= whole >= 10 ** (places + before - 1 - leading)
    cells[:, 1 + before] = _POINT
    cells[:, 2 + before :] = digits[:, point:] if places else _ZERO
    cells[unknown] = 0
    cells[unknown, :3] = tuple(b"nan")
    return cells


def _digits(whole: np.ndarray) -> np.ndarray:
    """Return the 16 characters (n, 16) of whole numbers below 1e16, with leading zeros."""
    upper = whole // 10**8
    fours = np.empty((len(whole), 4), dtype=np.uint32)
    for at, eight in ((0, upper), (2, whole - upper * 10**8)):
        first, second = np.divmod(eight.astype(np.uint32), np.uint32(10_000))
        fours[:, at], fours[:, at + 1] = _FOUR_DIGITS[first], _FOUR_DIGITS[second]
    return fours.view(np.uint8)
