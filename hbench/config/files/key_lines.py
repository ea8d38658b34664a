"""Tells in which line of its file a key stands that a message names."""

import re
from collections.abc import Sequence
from pathlib import Path

import yaml

from hbench.config.files.regular_file import NoSuchSize, read_regular
from hbench.config.files.yaml_text import parse_yaml

_MAX_BYTES = 1_000_000
_NAMED = re.compile(r"(.+?\.ya?ml): (?:(?:unknown )?key ')?([\w.]+)")


def with_lines(message: str) -> str:
    """Return a message with the lines of the keys in it: "bench.yaml: line 7: oil.density ...".

    They are looked up in the file as it lies there; what is not in it is told without a line.
    """
    return "\n".join(map(_with_line, message.split("\n")))


def _with_line(told: str) -> str:
    named = _NAMED.match(told)
    if named is None:
        return told
    file, keys = named.groups()
    try:
        line = line_of(read_regular(Path(file), _MAX_BYTES).decode("utf-8"), keys.split("."))
    except (OSError, NoSuchSize, ValueError):
        return told
    return f"{file}: line {line}: {told.removeprefix(f'{file}: ')}" if line else told


def line_of(text: str, keys: Sequence[str]) -> int | None:
    """Return the line of a key such as ``experiments``, ``0``, ``loads``; the nearest above it
    where it is missing, None where not even the first is there.

    Raises ``ValueError`` for text that ``parse_yaml`` refuses.
    """
    parse_yaml(text)
    node, line = yaml.compose(text, Loader=yaml.SafeLoader), None
    for key in keys:
        below: dict[str, tuple[yaml.Node, yaml.Node]] = {}
        if isinstance(node, yaml.MappingNode):
            below = {str(name.value): (name, value) for name, value in node.value}
        elif isinstance(node, yaml.SequenceNode):
            below = {str(number): (item, item) for number, item in enumerate(node.value)}
        if key not in below:
            break
        there, node = below[key]
        line = there.start_mark.line + 1
    return line
