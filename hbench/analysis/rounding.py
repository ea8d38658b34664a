"""Comparisons that rounding cannot change.

The last digits of a sum or a matrix product depend on the processor: its kernels add in another
order. A computed number is therefore compared with zero, with a limit or with another number only
beside a size of its own kind, of which 1e-9 counts as nothing. That is a thousand times what
rounding accumulates to in the longest sums here, and far below what any sensor resolves.
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np

ROUNDING = 1e-9  # of the size of what is compared
_DIGITS = range(2, 7)  # decimals of a text

Item = TypeVar("Item")


def exceeds(value: float, limit: float) -> bool:
    """Return whether ``value`` is greater than a positive ``limit`` by more than rounding."""
    return value > limit * (1 + ROUNDING)


def is_constant(values: np.ndarray) -> bool:
    """Return whether values (n,), n > 0, differ by rounding at most."""
    return bool(np.ptp(values) <= ROUNDING * np.abs(values).max())


def merged(values: np.ndarray) -> np.ndarray:
    """Return values (n,), with those that differ by rounding replaced by the least of them."""
    values = np.asarray(values, dtype=float)
    if not len(values):
        return values
    order = np.argsort(values, kind="stable")
    rising = values[order]
    first = np.diff(rising, prepend=-np.inf) > ROUNDING * np.abs(values).max()
    equal = np.empty_like(values)
    equal[order] = rising[np.maximum.accumulate(np.where(first, np.arange(len(rising)), 0))]
    return equal


def distinct(values: np.ndarray) -> np.ndarray:
    """Return the different values, rising; those that differ by rounding are one."""
    return np.unique(merged(values))


def ranked(items: Sequence[Item], size: Callable[[Item], float], tie: float) -> list[Item]:
    """Return ``items`` by falling ``size``; sizes that differ by ``tie`` at most keep their order.

    A tie is measured from the greatest of those that share it.
    """
    sizes = [size(item) for item in items]
    rest = sorted(range(len(sizes)), key=lambda i: -sizes[i])
    order: list[int] = []
    while rest:
        tied = [i for i in rest if sizes[i] >= sizes[rest[0]] - tie] or rest[:1]
        order += sorted(tied)
        rest = [i for i in rest if i not in tied]
    return [items[i] for i in order]


def distinct_texts(first: float, second: float) -> tuple[str, str]:
    """Write two numbers with two decimals, or as many as distinguish them."""
    pairs = [(f"{first:.{digits}f}", f"{second:.{digits}f}") for digits in _DIGITS]
    return next((pair for pair in pairs if pair[0] != pair[1]), pairs[-1])
