"""Reads a YAML file into a validated section, with errors that name file, key, value and limit."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from hbench.errors import ConfigError

_Model = TypeVar("_Model", bound=BaseModel)
_MAX_BYTES = 1_000_000


class _Loader(yaml.SafeLoader):
    """A safe loader that refuses a key given twice (PyYAML keeps the last one silently)."""


def _mapping(loader: _Loader, node: yaml.MappingNode) -> dict:
    loader.flatten_mapping(node)
    seen: dict[Any, int] = {}
    for key_node, _ in node.value:
        key = loader.construct_object(key_node, deep=True)
        line = key_node.start_mark.line + 1
        if key in seen:
            raise yaml.MarkedYAMLError(
                problem=f"key {key!r} stands twice (first in line {seen[key]})",
                problem_mark=key_node.start_mark,
            )
        seen[key] = line
    return loader.construct_mapping(node, deep=True)


_Loader.add_constructor(yaml.resolver.BaseResolver.DEFAULT_MAPPING_TAG, _mapping)


def read_yaml(path: Path) -> dict[str, Any]:
    """Return the mapping in a YAML file. Raises ``ConfigError``."""
    try:
        if path.stat().st_size > _MAX_BYTES:
            raise ConfigError(f"{path}: larger than {_MAX_BYTES} bytes; not a configuration file")
        data = yaml.load(path.read_text(encoding="utf-8"), Loader=_Loader)
    except OSError as error:
        raise ConfigError(
            f"{path}: {error.strerror or error}", "Check the path; `hbench init DIR` writes one."
        ) from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not a text file in UTF-8") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f"line {mark.line + 1}" if mark else "somewhere"
        problem = getattr(error, "problem", None) or str(error)
        raise ConfigError(f"{path}: {where}: {problem}", "The file is not valid YAML.") from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path}: holds no keys; expected 'key: value' lines")
    return data


def file_sha256(path: Path) -> str:
    """Return the hash of a file that was read before."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def validate(model: type[_Model], data: dict[str, Any], source: str) -> _Model:
    """Check ``data`` against ``model``. Raises ``ConfigError`` with every fault in it."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        faults = [f"{source}: {_explain(fault, data)}" for fault in _own_faults(error)]
        raise ConfigError("\n".join(faults), _hint(error)) from None


def _own_faults(error: ValidationError) -> list[dict[str, Any]]:
    """Return the faults, but no list that is too short only because its items have faults."""
    faults = error.errors()

    def follows(fault: dict[str, Any]) -> bool:
        depth = len(fault["loc"])
        return fault["type"] == "too_short" and any(
            len(other["loc"]) > depth and other["loc"][:depth] == fault["loc"] for other in faults
        )

    return [fault for fault in faults if not follows(fault)]


def _explain(fault: dict[str, Any], data: Any) -> str:
    key = ".".join(_keys(fault, data)) or "(whole file)"
    if fault["type"] == "extra_forbidden":
        return f"unknown key '{key}'"
    if fault["type"] == "missing":
        return f"key '{key}' is missing"
    message = fault["msg"].removeprefix("Value error, ")
    message = message[0].lower() + message[1:]
    value = fault["input"]
    return f"{key}: {message}" if isinstance(value, dict) else f"{key} = {value!r}: {message}"


def _keys(fault: dict[str, Any], data: Any) -> Iterator[str]:
    """Yield the keys that stand in the file, and one that is missing there.

    Pydantic adds the kind or strategy that it chose by one.
    """
    loc = fault["loc"]
    for number, part in enumerate(loc):
        if isinstance(data, list):
            there = isinstance(part, int) and part < len(data)
        else:
            there = isinstance(data, dict) and part in data
        if there:
            data = data[part]
        if there or (fault["type"] == "missing" and number == len(loc) - 1):
            yield str(part)


def _hint(error: ValidationError) -> str:
    if any(fault["type"] == "extra_forbidden" for fault in error.errors()):
        return "Keys are checked so that a misspelt one is not ignored; see the commented examples."
    return ""
