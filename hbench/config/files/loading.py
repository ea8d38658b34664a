"""YAML files as validated sections; errors name file, key, value and limit."""

import difflib
import hashlib
from collections.abc import Iterator
from datetime import date
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, get_args

from pydantic import BaseModel, ValidationError

from hbench.config.files.regular_file import FileTooLarge, read_regular_file
from hbench.config.files.yaml_text import parse_yaml
from hbench.errors import ConfigError

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

_Model = TypeVar("_Model", bound=BaseModel)
_MAX_BYTES = 1_000_000
_MOST_FAULTS = 50  # that a message lists
_BRIEF = 100  # characters of a value
_YAML = (
    "The file is not valid YAML there or just above: indent by spaces, the keys of one section "
    "alike; a space after each ':'; put what holds [ ] { } , # or ': ' between quotes."
)
_FILE_TYPES = {  # by a key that only this type has, at the top
    "test_cylinder": "a bench file",
    "experiments": "a schedule",
    "columns": "an import map",
    "laboratory": "a certificate's file",
    "laws": "a file of fits",
    "rule": "a file of limits",
}
_MESSAGES = {  # of pydantic's error types, in the terms of YAML
    "tuple_type": "must be a list, such as [A, B]",
    "dict_type": "must be 'key: value' lines, or {{key: value}}",
    "model_type": "must be 'key: value' lines, or {{key: value}}",
    "model_attributes_type": "must be 'key: value' lines, or {{key: value}}",
    "int_parsing": "must be a whole number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "greater_than": "must be greater than {gt}",
    "greater_than_equal": "must be at least {ge}",
    "less_than": "must be less than {lt}",
    "less_than_equal": "must be at most {le}",
    "float_parsing": "must be a number",
    "float_type": "must be a number",
    "string_type": "must be text",
    "bool_parsing": "must be true or false",
    "bool_type": "must be true or false",
    "date_type": "must be a date, such as 2026-01-31",
    "date_parsing": "must be a date, such as 2026-01-31",
    "date_from_datetime_parsing": "must be a date, such as 2026-01-31",
    "date_from_datetime_inexact": "must be a date without a time, such as 2026-01-31",
    "finite_number": "must be a finite number",
    "literal_error": "must be {expected}",
    "union_tag_invalid": "must be one of {expected_tags}",
    "too_short": "has {actual_length} entries; limit at least {min_length}",
}


def read_text(path: Path) -> str:
    """Return the text of a configuration file. Raises ``ConfigError``."""
    try:
        return read_regular_file(path, _MAX_BYTES).decode("utf-8")
    except FileTooLarge as error:
        raise ConfigError(f"{path}: {error}; not a configuration file") from None
    except IsADirectoryError:
        raise ConfigError(
            f"{path}: is a folder; a YAML file is expected", "Give a file in it, or check the path."
        ) from None
    except OSError as error:
        raise ConfigError(
            f"{path}: {error.strerror or error}",
            "Check the path; `hbench init DIR` writes a bench file and schedules.",
        ) from None
    except UnicodeDecodeError:
        raise ConfigError(
            f"{path}: not a text file in UTF-8",
            "Save it as UTF-8; the > of Windows PowerShell writes UTF-16.",
        ) from None


def read_yaml(path: Path) -> dict[str, Any]:
    """Return the mapping in a YAML file. Raises ``ConfigError``."""
    try:
        data = parse_yaml(read_text(path))
    except ValueError as error:
        raise ConfigError(f"{path}: {error}", _YAML) from None
    if not isinstance(data, dict):
        raise ConfigError(f"{path}: has no keys; expected 'key: value' lines")
    return data


def file_sha256(path: Path) -> str:
    """Return the SHA-256 of a file."""
    return hashlib.sha256(read_regular_file(path, _MAX_BYTES)).hexdigest()


def validate(model: type[_Model], data: dict[str, Any], source: str) -> _Model:
    """Check ``data`` against ``model``. Raises ``ConfigError`` that lists the faults."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        _refuse_other_type(model, data, source)
        faults = error.errors()
        meant = _meant(faults, model)
        own = [fault for fault in _own_faults(faults) if fault["loc"] not in meant.values()]
        messages = [
            f"{source}: {_explain(fault, data, meant, model)}" for fault in own[:_MOST_FAULTS]
        ]
        if len(own) > _MOST_FAULTS:
            messages.append(f"{source}: {len(own) - _MOST_FAULTS} more faults")
        raise ConfigError("\n".join(messages), _hint(faults)) from None


def _refuse_other_type(model: type[BaseModel], data: dict[str, Any], source: str) -> None:
    fields = model.model_fields
    wanted = [name for key, name in _FILE_TYPES.items() if key in fields]
    there = [name for key, name in _FILE_TYPES.items() if key in data]
    if any(key in fields and key in data for key in _FILE_TYPES):
        return
    expected = (*wanted, "the expected file")[0]
    hint = f"Give {expected}, such as one of those that `hbench init DIR` writes."
    if there:
        raise ConfigError(f"{source}: is {there[0]}, not {expected}", hint)
    if wanted and not data.keys() & fields.keys() - {"name"}:
        has = brief(", ".join(map(str, data)))
        raise ConfigError(f"{source}: is not {expected}; it has {has}", hint)


def _meant(faults: list["ErrorDetails"], model: type[BaseModel]) -> dict[tuple, tuple]:
    """Return the likely meant key of each unknown one: a missing key beside it, or any similar."""
    known = _names(model)
    missing = [fault["loc"] for fault in faults if fault["type"] == "missing"]
    meant: dict[tuple, tuple] = {}
    unknown = [fault["loc"] for fault in faults if fault["type"] == "extra_forbidden"]
    for where in unknown[:_MOST_FAULTS]:
        *above, key = where
        beside = {str(loc[-1]): loc for loc in missing if list(loc[:-1]) == above}
        for name in difflib.get_close_matches(str(key), beside, n=1):
            meant[where] = beside[name]
        if where not in meant and key not in known:
            for name in difflib.get_close_matches(str(key), known, n=1, cutoff=0.8):
                meant[where] = (*above, name)
    return meant


@cache
def _names(model: type[BaseModel]) -> set[str]:
    """Return the keys of all sections of a file."""
    schema = model.model_json_schema()
    return {
        name
        for section in (schema, *schema.get("$defs", {}).values())
        for name in section.get("properties", {})
    }


def _own_faults(faults: list["ErrorDetails"]) -> list["ErrorDetails"]:
    """Return the faults without those that follow from others.

    They are lists that are too short only because of faulty items, and numbers that are no text
    either where a number out of its limits was meant.
    """

    def follows(fault: "ErrorDetails") -> bool:
        depth = len(fault["loc"])
        return fault["type"] == "too_short" and any(
            len(other["loc"]) > depth and other["loc"][:depth] == fault["loc"] for other in faults
        )

    def is_of_other_type(fault: "ErrorDetails") -> bool:
        return (
            fault["loc"][-1:] == ("str",)
            and any(  # the member of a union
                other["loc"][:-1] == fault["loc"][:-1] and other["type"] == "greater_than_equal"
                for other in faults
            )
        )

    return [fault for fault in faults if not (follows(fault) or is_of_other_type(fault))]


def _known_keys(model: type[BaseModel], above: tuple) -> list[str]:
    """Return the keys of the section at the location ``above``; empty if it is not known."""
    sections = {model}
    for part in above:
        fields = [s.model_fields[part] for s in sections if part in s.model_fields]
        if fields:  # else the number of an item, a name of a mapping, or the tag of a union
            sections = {s for field in fields for s in _models_in(field.annotation)}
    return sorted({name for section in sections for name in section.model_fields})


def _models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for argument in get_args(annotation):
        yield from _models_in(argument)


def _explain(
    fault: "ErrorDetails", data: Any, meant: dict[tuple, tuple], model: type[BaseModel]
) -> str:
    key = ".".join(_keys(fault, data))
    if fault["type"] == "extra_forbidden":
        last = str(fault["loc"][-1])
        if last[:1].isdigit() and fault["input"] is None:  # {bore: 50,5 mm} has the key '5 mm'
            return f"unknown key '{key}': a comma ends the value before it; write a decimal point"
        right = meant.get(fault["loc"])
        if right:
            return f"unknown key '{key}'; did you mean '{right[-1]}'?"
        known = ", ".join(_known_keys(model, fault["loc"][:-1]))
        return f"unknown key '{key}'" + (f"; known are {known}" if known else "")
    if fault["type"] == "missing":
        return f"key '{key}' is missing"
    message = fault["msg"].removeprefix("Value error, ")
    message = message[0].lower() + message[1:]
    if fault["type"] in _MESSAGES:
        message = _MESSAGES[fault["type"]].format(**fault.get("ctx", {}))
    value = fault["input"]
    if fault["type"] == "string_type" and isinstance(value, (bool, int, float, date)):
        message += "; put it in quotes" + ("" if isinstance(value, bool) else f': "{value}"')
    if fault["type"] == "string_type" and isinstance(value, dict):
        message = f"must be one value; it has the keys {brief(', '.join(map(str, value)))}"
    if fault["type"] == "tuple_type" and isinstance(value, str):
        message = f"must be a list: [{brief(value)[1:-1]}]"
    if fault["type"] == "unknown_kind" and isinstance(value, dict):
        if "kind" not in value:
            return f"key '{key}.kind' is missing"
        key, value = f"{key}.kind", value["kind"]
    if fault["type"] == "union_tag_invalid":
        tag = fault["ctx"]
        key, value = f"{key}.{tag['discriminator'].strip(chr(39))}", tag["tag"]
    if not key:
        return message
    return f"{key}: {message}" if isinstance(value, dict) else f"{key} = {brief(value)}: {message}"


def brief(value: Any) -> str:
    """Return a value for a message: on one line, cut if long."""
    words = repr(value)
    return words if len(words) <= _BRIEF else f"{words[:_BRIEF]}..."


def _keys(fault: "ErrorDetails", data: Any) -> Iterator[str]:
    """Yield the keys of a fault that are in the file, and a missing one.

    Pydantic's locations also contain the tag of a union's member, which is no key.
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


def _hint(faults: list["ErrorDetails"]) -> str:
    if any(fault["type"] == "extra_forbidden" for fault in faults):
        return "Correct or remove the key; see the commented examples."
    of_values = (
        f for f in faults if "has no unit" in f["msg"] and not isinstance(f["input"], dict)
    )
    if any(isinstance(key, int) for fault in of_values for key in fault["loc"][-1:]):
        return "Separate the values of a list by commas, each with its unit: [0.5 kN, 5 kN]."
    return ""
