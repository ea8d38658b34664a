"""Copies of a configuration with other values at dotted paths, such as ``valve.gain``."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from operator import mul
from typing import Any

from hbench.config.quantity import Section


def scaled(section: Section, factors: Mapping[str, float]) -> Any:
    """Return a copy of a configuration section with the values at dotted paths multiplied."""
    for path, factor in factors.items():
        section = replaced(section, path.split("."), partial(mul, factor))
    return section


def replaced(section: Section, path: Sequence[str], change: Callable[[float], float]) -> Any:
    """Return a copy of a section with the value at ``path`` changed."""
    first, *rest = path
    value = getattr(section, first)
    value = replaced(value, rest, change) if rest else change(value)
    return section.model_copy(update={first: value})
