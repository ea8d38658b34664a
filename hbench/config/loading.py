"""Reads a YAML file into a validated section, with errors that name file, key, value and limit."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from pydantic import BaseModel, ValidationError

from hbench.config.regular import NoSuchSize, read_regular
from hbench.config.yaml_text import parse_yaml
from hbench.errors import ConfigError

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

_Model = TypeVar("_Model", bound=BaseModel)
_MAX_BYTES = 1_000_000
_BRIEF = 100  # characters of a value


def read_yaml(path: Path) -> dict[str, Any]:
    """Return the mapping in a YAML file. Raises ``ConfigError``."""
    try:
        data = parse_yaml(read_regular(path, _MAX_BYTES).decode("utf-8"))
    except NoSuchSize as error:
        raise ConfigError(f"{path}: {error}; not a configuration file") from None
    except OSError as error:
        raise ConfigError(
            f"{path}: {error.strerror or error}", "Check the path; `hbench init DIR` writes one."
        ) from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not a text file in UTF-8") from None
    except ValueError as error:
        raise ConfigError(f"{path}: {error}", "The file is not valid YAML.") from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path}: holds no keys; expected 'key: value' lines")
    return data


def file_sha256(path: Path) -> str:
    """Return the hash of a file that was read before."""
    return hashlib.sha256(read_regular(path, _MAX_BYTES)).hexdigest()


def validate(model: type[_Model], data: dict[str, Any], source: str) -> _Model:
    """Check ``data`` against ``model``. Raises ``ConfigError`` with every fault in it."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        faults = [f"{source}: {_explain(fault, data)}" for fault in _own_faults(error)]
        raise ConfigError("\n".join(faults), _hint(error)) from None


def _own_faults(error: ValidationError) -> list["ErrorDetails"]:
    """Return the faults, but no list that is too short only because its items have faults."""
    faults = error.errors()

    def follows(fault: "ErrorDetails") -> bool:
        depth = len(fault["loc"])
        return fault["type"] == "too_short" and any(
            len(other["loc"]) > depth and other["loc"][:depth] == fault["loc"] for other in faults
        )

    return [fault for fault in faults if not follows(fault)]


def _explain(fault: "ErrorDetails", data: Any) -> str:
    key = ".".join(_keys(fault, data)) or "(whole file)"
    if fault["type"] == "extra_forbidden":
        return f"unknown key '{key}'"
    if fault["type"] == "missing":
        return f"key '{key}' is missing"
    message = fault["msg"].removeprefix("Value error, ")
    message = message[0].lower() + message[1:]
    value = fault["input"]
    return f"{key}: {message}" if isinstance(value, dict) else f"{key} = {brief(value)}: {message}"


def brief(value: Any) -> str:
    """Return a value as a message shows it: on one line, and not all of a long one."""
    words = repr(value)
    return words if len(words) <= _BRIEF else f"{words[:_BRIEF]}..."


def _keys(fault: "ErrorDetails", data: Any) -> Iterator[str]:
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
