"""Strict YAML parser for untrusted text, with line numbers in errors."""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import yaml

from hbench.untrusted_text import CONTROL

DEEPEST = 50  # levels of nesting; the parser is recursive
_TOO_DEEP = f"nested more than {DEEPEST} deep"
MOST_REPEATED = 100_000  # values that aliases may add
LONGEST_NUMBER = 400  # characters; conversion takes quadratic time and fails beyond 4300

_Base: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
# Numbers of YAML 1.1 that are others than they show: 010 is 8, 1:30 is 90. Here they are text, so
# that 010 is read as 10 where a number is expected, 007 stays 007, and 1:30 is refused.
_OTHER_THAN_SHOWN = r"(?![-+]?0[0-7_]+$)(?![-+]?[0-9][0-9_]*:)"
_SCALARS = ("int", "float", "bool", "timestamp")


class _Loader(_Base):
    """Safe loader that reports the line of an invalid value, such as the date 2026-99-99.

    Numbers in octal notation and in base 60 are text.
    """

    yaml_implicit_resolvers: ClassVar = {
        first: [
            (tag, re.compile(_OTHER_THAN_SHOWN + expression.pattern, expression.flags))
            if tag.endswith((":int", ":float"))
            else (tag, expression)
            for tag, expression in resolvers
        ]
        for first, resolvers in _Base.yaml_implicit_resolvers.items()
    }


def _with_line(construct: Callable) -> Callable:
    def read(loader: _Loader, node: yaml.Node) -> Any:
        try:
            if len(node.value) > LONGEST_NUMBER:
                raise ValueError
            return construct(loader, node)
        except (ValueError, KeyError, OverflowError, AttributeError):
            problem = f"{str(node.value)[:40]!r} can't be read as {node.tag.rsplit(':', 1)[-1]}"
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark) from None

    return read


for _name in _SCALARS:
    _tag = f"tag:yaml.org,2002:{_name}"
    _Loader.add_constructor(_tag, _with_line(_Base.yaml_constructors[_tag]))


def parse_yaml(text: str) -> Any:
    """Return the content of YAML text. Raises ``ValueError``, such as "line 3: key 'a' ...".

    Besides invalid YAML it refuses duplicate keys, nesting deeper than ``DEEPEST``, aliases that
    repeat more than ``MOST_REPEATED`` values or contain themselves, numbers longer than
    ``LONGEST_NUMBER`` and control characters.
    """
    try:
        _check(text)
        return yaml.load(text, Loader=_Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f"line {mark.line + 1}: " if mark else ""
        problem = getattr(error, "problem", None) or getattr(error, "reason", None) or str(error)
        if "nesting depth" in problem:  # of the library, which reads ahead of what is checked here
            problem = _TOO_DEEP
        raise ValueError(f"{where}{problem}") from None


def compose_yaml(text: str) -> yaml.Node:
    """Return the nodes of YAML text, with their lines. Raises ``ValueError`` as ``parse_yaml``."""
    parse_yaml(text)
    return yaml.compose(text, Loader=_Loader)


@dataclass
class _Open:
    """Mapping or sequence whose end is not parsed yet."""

    anchor: str | None
    mapping: bool
    values: int = 1  # so far: itself and its content, aliases expanded
    items: int = 0  # keys and values
    keys: dict[str, int] = field(default_factory=dict)  # with their lines


def _check(text: str) -> None:
    """Raise ``MarkedYAMLError`` for valid YAML that this parser refuses."""
    stack: list[_Open] = []
    anchors: dict[str | None, int] = {}  # with the number of values
    repeated = 0
    for event in yaml.parse(text, Loader=_Base):
        if isinstance(event, yaml.CollectionEndEvent):
            done = stack.pop()
            anchors[done.anchor] = done.values
            if stack:
                stack[-1].values += done.values
        elif isinstance(event, yaml.NodeEvent):
            if stack:
                _check_key(stack[-1], event)
            if isinstance(event, yaml.CollectionStartEvent):
                if len(stack) == DEEPEST:
                    _refuse(_TOO_DEEP, event)
                stack.append(_Open(event.anchor, isinstance(event, yaml.MappingStartEvent)))
                continue
            values = 1
            if isinstance(event, yaml.AliasEvent):
                if event.anchor not in anchors:
                    _refuse(f"alias *{event.anchor} has no anchor, or contains itself", event)
                values = anchors[event.anchor]
                repeated += values
                if repeated > MOST_REPEATED:
                    _refuse(f"aliases repeat more than {MOST_REPEATED} values", event)
            else:
                anchors[event.anchor] = 1
                if CONTROL.search(event.value):
                    _refuse("contains a control character", event)
            if stack:
                stack[-1].values += values


def _check_key(into: _Open, event: yaml.NodeEvent) -> None:
    is_key = into.mapping and into.items % 2 == 0
    into.items += 1
    if is_key and isinstance(event, yaml.ScalarEvent):
        key = event.value
        if key in into.keys:
            _refuse(f"key {key[:40]!r} is duplicate (first in line {into.keys[key]})", event)
        into.keys[key] = event.start_mark.line + 1


def _refuse(problem: str, event: yaml.Event) -> None:
    raise yaml.MarkedYAMLError(problem=problem, problem_mark=event.start_mark)
