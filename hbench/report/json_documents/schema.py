"""JSON Schema of a document, generated from the types and comments of the records.

A field's type gives the schema's type, its comment the description, and the ending of its name the
unit. A field without a comment has the description of ``RunPlan``'s field of the same name.
"""

import re
import types
from collections.abc import Mapping
from dataclasses import dataclass, is_dataclass
from dataclasses import field as dataclass_field
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from hbench.records import RunPlan
from hbench.records.numbers import Minimum, Nonfinite, OneOf
from hbench.report.json_documents.field_comments import field_comments
from hbench.report.json_documents.layout import (
    Constant,
    KeyRow,
    Layouts,
    NullIfEmpty,
    NullIfNot,
    Source,
    all_fields,
)

Schema = dict[str, Any]

_PLAIN = {str: "string", float: "number", int: "integer", bool: "boolean"}
# Endings of names, the longer ones first.
_UNITS = {
    "_n_s_m": "N s/m",
    "_n_pa": "N/Pa",
    "_m3_s": "m^3/s",
    "_m_s2": "m/s^2",
    "_pa_s": "Pa/s",
    "_m_s": "m/s",
    "_n2": "N^2",
    "_m2": "m^2",
    "_pa": "Pa",
    "_n": "N",
    "_m": "m",
    "_s": "s",
    "_j": "J",
}


def schema(name: str, title: str, about: str, record: type, layouts: Layouts) -> Schema:
    """Return the schema of the document of ``record``; ``name`` is such as ``results/1``."""
    writer = _Writer(layouts)
    root = writer.object_of(record)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "$id": f"urn:hbench:{name.replace('/', ':')}",
        "title": title,
        "description": about,
        **{key: value for key, value in root.items() if key != "description"},
        "$defs": dict(sorted(writer.definitions.items())),
    }


@dataclass
class _Writer:
    """Schemas of records, and the definitions they refer to."""

    layouts: Layouts
    definitions: dict[str, Schema] = dataclass_field(default_factory=dict)

    def object_of(self, record: type) -> Schema:
        """Return the schema of a record's object."""
        row = self.layouts.get(record) or all_fields(record)
        return {"description": _sentence(record.__doc__), **self._row(record, row)}

    def _row(self, record: type, row: KeyRow) -> Schema:
        properties = {key: self._key(record, key, source) for key, source in row.items()}
        return {"type": "object", "required": list(row), "properties": properties}

    def _key(self, record: type, key: str, source: Source) -> Schema:
        if isinstance(source, Constant):
            return {"const": source.text}
        if isinstance(source, Mapping):
            return self._row(record, source)
        may_be_null = isinstance(source, NullIfEmpty | NullIfNot)
        path = source if isinstance(source, str) else source.path
        kind, owner, name, optional = _follow(record, path)
        value_schema = self._type(kind)
        if optional or may_be_null:
            value_schema = _or_null(value_schema)
        description = _description(owner, name)
        return {**value_schema, "description": description} if description else value_schema

    def _type(self, kind: Any) -> Schema:
        origin, args = get_origin(kind), get_args(kind)
        if kind is Any:
            return {}
        if kind in _PLAIN:
            return {"type": _PLAIN[kind]}
        if is_dataclass(kind):
            return self._reference(kind)
        if origin is Annotated:
            return _marked(self._type(args[0]), args[1:])
        if origin is Literal:
            return {"enum": list(args)}
        if origin in (Union, types.UnionType):
            (known,) = (arg for arg in args if arg is not types.NoneType)  # X | None alone
            return _or_null(self._type(known))
        if origin is dict:
            inner = self._type(args[1])
            return {"type": "object"} | ({"additionalProperties": inner} if inner else {})
        if origin is tuple and args[-1] is Ellipsis:
            return {"type": "array", "items": self._type(args[0])}
        if origin is tuple and len(set(args)) == 1:
            size = len(args)
            items = self._type(args[0])
            return {"type": "array", "items": items, "minItems": size, "maxItems": size}
        raise TypeError(f"no JSON Schema for {kind}")

    def _reference(self, record: Any) -> Schema:
        name = record.__name__
        if name not in self.definitions:
            self.definitions[name] = {}  # of a record that holds itself
            self.definitions[name] = self.object_of(record)
        return {"$ref": f"#/$defs/{name}"}


def _follow(record: Any, path: str) -> tuple[Any, Any, str, bool]:
    """Return the type at the end of a path, its record, its name, and whether a None may come."""
    optional = False
    *way, last = path.split(".")
    for name in way:
        record = _hint(record, name)
        if get_origin(record) in (Union, types.UnionType):
            (record,) = (arg for arg in get_args(record) if arg is not types.NoneType)
            optional = True
    return _hint(record, last), record, last, optional


def _hint(record: Any, name: str) -> Any:
    attribute = getattr(record, name, None)
    if isinstance(attribute, property):
        return get_type_hints(attribute.fget, include_extras=True)["return"]
    return get_type_hints(record, include_extras=True)[name]


def _marked(value_schema: Schema, marks: tuple[Any, ...]) -> Schema:
    for mark in marks:
        if isinstance(mark, Minimum):
            value_schema = {**value_schema, "minimum": mark.value}
        elif isinstance(mark, OneOf):
            value_schema = {"enum": list(mark.values)}
        elif isinstance(mark, Nonfinite):
            value_schema = _or_null(value_schema)
    return value_schema


def _or_null(value_schema: Schema) -> Schema:
    if "enum" in value_schema:
        return {**value_schema, "enum": list(dict.fromkeys((*value_schema["enum"], None)))}
    if isinstance(value_schema.get("type"), list) or "anyOf" in value_schema:
        return value_schema
    if "$ref" in value_schema or value_schema["type"] in ("object", "array"):
        return {"anyOf": [value_schema, {"type": "null"}]}
    return {**value_schema, "type": [value_schema["type"], "null"]}


def _description(record: Any, name: str) -> str:
    attribute = getattr(record, name, None)
    if isinstance(attribute, property):
        text = _sentence(attribute.__doc__)
    else:
        text = field_comments(record).get(name) or field_comments(RunPlan).get(name, "")
    text = re.sub(r"\bNone\b", "null", text.replace("``", "'")).removesuffix(".")
    unit = next((unit for ending, unit in _UNITS.items() if name.endswith(ending)), "")
    return f"{text} [{unit}]".strip() if unit else text


def _sentence(docstring: str | None) -> str:
    """Return the first line of a docstring."""
    return (docstring or "").strip().partition("\n")[0].replace("``", "'")
