"""Columns of numbers as text, and the decimal numbers that measured values are near."""

from collections.abc import Iterator, Sequence

import numpy as np
from pydantic_core import to_json

_LARGEST = 10**15  # whole numbers up to here, and quotients by powers of ten up to here, are exact
_FEW = 100  # values that are tested before all are
_BLOCK = 2_000  # rows formatted at a time


def formatted_rows(columns: Sequence[np.ndarray]) -> Iterator[bytes]:
    """Yield the rows of ``columns``, each (n,), as CSV, a block of rows at a time.

    Each number has the fewest digits from which the same float is read; NaN is "nan". As JSON, an
    array of rows, numbers are formatted five times as fast as one by one.
    """
    for start in range(0, len(columns[0]), _BLOCK):
        block = np.column_stack([values[start : start + _BLOCK] for values in columns])
        rows = to_json(block.tolist(), inf_nan_mode="constants")
        yield rows[2:-2].replace(b"],[", b"\n").replace(b"NaN", b"nan") + b"\n"


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


def _powers_of_ten(values: np.ndarray) -> Iterator[float]:
    """Yield 1, 10, 100, ... up to the largest by which all products are below ``_LARGEST``."""
    factor, most = 1.0, np.abs(values).max(initial=1.0)
    while most * factor < _LARGEST:
        yield factor
        factor *= 10.0


def _is_near_whole(values: np.ndarray) -> bool:
    return bool((np.abs(np.rint(values) - values) <= 2 * np.spacing(np.abs(values))).all())
