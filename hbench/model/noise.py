"""A normal random generator for compiled loops: deterministic, seeded, a few ns a number.

Five 12-bit fields of one 64-bit draw pick from 4096 normal quantiles, scaled to variance 1. The
tails end at 3.7 standard deviations, which suits sensor noise and scatter.
"""

import numpy as np
from scipy.special import ndtri

from hbench.model.compiled import compiled

_TABLE_BITS = 12
_MASK = np.uint64((1 << _TABLE_BITS) - 1)
_SHIFT = np.uint64(_TABLE_BITS)
_FIELDS = 64 // _TABLE_BITS

# splitmix64 (Steele, Lea, Flood 2014)
_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_MIX_1, _SHIFT_1 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(30)
_MIX_2, _SHIFT_2 = np.uint64(0x94D049BB133111EB), np.uint64(27)
_SHIFT_3 = np.uint64(31)

# The generator's state: the counter, the bits left of the last draw, and how many fields they hold.
_COUNTER, _BITS, _LEFT = 0, 1, 2


def _quantiles() -> np.ndarray:
    count = 1 << _TABLE_BITS
    table = ndtri((np.arange(count) + 0.5) / count)
    return table / table.std()


_QUANTILES = _quantiles()


def new_noise(seed: int) -> np.ndarray:
    """Return a generator's state for ``seed``; the same seed gives the same numbers."""
    return np.array([seed & 0xFFFF_FFFF_FFFF_FFFF, 0, 0], dtype=np.uint64)


@compiled
def draw_bits(noise: np.ndarray) -> int:
    """Return the next 64 bits of splitmix64."""
    noise[_COUNTER] += _GAMMA
    bits = noise[_COUNTER]
    bits = (bits ^ (bits >> _SHIFT_1)) * _MIX_1
    bits = (bits ^ (bits >> _SHIFT_2)) * _MIX_2
    return bits ^ (bits >> _SHIFT_3)


@compiled
def normal(noise: np.ndarray) -> float:
    """Return the next number of mean 0 and variance 1."""
    if noise[_LEFT] == 0:
        noise[_BITS] = draw_bits(noise)
        noise[_LEFT] = _FIELDS
    index = noise[_BITS] & _MASK
    noise[_BITS] >>= _SHIFT
    noise[_LEFT] -= np.uint64(1)
    return _QUANTILES[index]
