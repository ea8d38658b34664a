"""Copies of a configuration with other values at dotted paths, such as ``valve.gain``."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from operator import mul
from typing import Any, get_args

from hbench.config.quantity import ConfigSection


def scaled(section: ConfigSection, factors: Mapping[str, float]) -> Any:
    """Return a copy of a configuration section with the values at dotted paths multiplied."""
    for path, factor in factors.items():
        section = replaced(section, path.split("."), partial(mul, factor))
    return section


def replaced(section: ConfigSection, path: Sequence[str], change: Callable[[float], float]) -> Any:
    """Return a copy of a section with the value at ``path`` changed."""
    first, *rest = path
    value = getattr(section, first)
    value = replaced(value, rest, change) if rest else change(value)
    return section.model_copy(update={first: value})


@cache
def value_paths(section: type[ConfigSection]) -> frozenset[str]:
    """Return the dotted paths of all values that a section may have, with any of its variants."""
    paths = set()
    for name, field in section.model_fields.items():
        inner = [kind for kind in _kinds(field.annotation) if _is_section(kind)]
        paths |= {f"{name}.{path}" for kind in inner for path in value_paths(kind)} or {name}
    return frozenset(paths)


def _kinds(annotation: Any) -> list[Any]:
    """Return the types that an annotation is composed of, such as those of a union."""
    inner = get_args(annotation)
    return [kind for each in inner for kind in _kinds(each)] if inner else [annotation]


def _is_section(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, ConfigSection)
