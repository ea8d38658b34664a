"""Layout of records as JSON objects, from which both documents and schemas are made.

A record becomes an object of all its fields, unless ``Layouts`` has a row for its class. A row maps
each JSON key to its source: the path of an attribute of the record, such as ``run.plan.kind``
(null where an attribute on the way is None), a ``Constant``, a ``NullIf...``, or another row,
which becomes an object of its own.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from typing import Any, TypeAlias

from hbench.report.json_documents.values import SCALARS, json_value


@dataclass(frozen=True)
class Constant:
    """Text that is the same in every document, such as the name of its schema."""

    text: str


@dataclass(frozen=True)
class NullIfEmpty:
    """Path of a text that is null in the document where it is empty in the record."""

    path: str


@dataclass(frozen=True)
class NullIfNot:
    """Path of a value that is null in the document where another attribute is False."""

    path: str
    condition: str


Source: TypeAlias = "str | Constant | NullIfEmpty | NullIfNot | KeyRow"
KeyRow: TypeAlias = Mapping[str, Source]
Layouts: TypeAlias = Mapping[type, KeyRow]


def keys(*names: str) -> dict[str, Source]:
    """Return a row of attributes under their own names."""
    return {name: name for name in names}


def all_fields(record: type, without: tuple[str, ...] = (), **changed: Source) -> dict[str, Source]:
    """Return a row of a record's fields, without some and with some from another source."""
    row = keys(*(field.name for field in fields(record) if field.name not in without))
    return row | changed


_row_of = cache(all_fields)


def json_document(value: Any, layouts: Layouts) -> Any:
    """Return a record, or a container of records, as JSON values."""
    if type(value) in SCALARS:
        return json_value(value)
    if is_dataclass(value) and not isinstance(value, type):
        return _object(value, layouts.get(type(value)) or _row_of(type(value)), layouts)
    if isinstance(value, Mapping):
        return {str(key): json_document(item, layouts) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [json_document(item, layouts) for item in value]
    return json_value(value)


def _object(record: Any, row: KeyRow, layouts: Layouts) -> dict[str, Any]:
    written: dict[str, Any] = {}
    for key, source in row.items():
        if isinstance(source, Constant):
            written[key] = source.text
        elif isinstance(source, NullIfEmpty):
            written[key] = _attribute(record, source.path) or None
        elif isinstance(source, NullIfNot):
            known = _attribute(record, source.condition)
            written[key] = (
                json_document(_attribute(record, source.path), layouts) if known else None
            )
        elif isinstance(source, str):
            written[key] = json_document(_attribute(record, source), layouts)
        else:
            written[key] = _object(record, source, layouts)
    return written


def _attribute(record: Any, path: str) -> Any:
    for name in path.split("."):
        if record is None:
            return None
        record = getattr(record, name)
    return record
