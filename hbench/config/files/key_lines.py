"""Line numbers of the keys in messages."""

import re
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import yaml

from hbench.config.files.regular_file import read_regular_file
from hbench.config.files.yaml_text import compose_yaml

_MAX_BYTES = 1_000_000
_NAMED = re.compile(r"(.+?\.ya?ml): (?:(?:unknown )?key ')?([\w.]+)")


def with_lines(message: str) -> str:
    """Return a message with the line of each key in it: "bench.yaml: line 7: oil.density ...".

    Each file is read again, once; a key that it does not contain gets no line.
    """
    nodes = cache(_nodes)
    return "\n".join(_with_line(line, nodes) for line in message.split("\n"))


def _with_line(message: str, nodes: Callable[[str], yaml.Node | None]) -> str:
    named = _NAMED.match(message)
    if named is None:
        return message
    file, keys = named.groups()
    node = nodes(file)
    line = node and _line_in(node, keys.split("."))
    return f"{file}: line {line}: {message.removeprefix(f'{file}: ')}" if line else message


def _nodes(file: str) -> yaml.Node | None:
    try:
        return compose_yaml(read_regular_file(Path(file), _MAX_BYTES).decode("utf-8"))
    except Exception:  # the file may have changed into anything; a message needs no line
        return None


def _line_in(node: yaml.Node, keys: Sequence[str]) -> int | None:
    """Return the line of a key such as ``experiments``, ``0``, ``loads``; the nearest above it
    where it is missing, None where not even the first is there.
    """
    line = None
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
