"""Values of YAML text replaced in place, so that comments and order stay."""

import re
from collections.abc import Callable, Iterator

import yaml

from hbench.config.files.yaml_text import compose_yaml

Path = tuple[str, ...]  # keys, and the numbers of list items
_ANCHOR = re.compile(r"&\S+\s+")


def with_values(text: str, change: Callable[[Path, str], str | None], comment: str = "") -> str:
    """Return YAML text with the scalars for which ``change`` returns a text.

    A ``comment`` replaces that of their lines, in the same column. Raises ``ValueError`` as
    ``compose_yaml``.
    """
    changes: dict[int, tuple[int, str]] = {}  # by start: end, new
    for path, scalar in scalars(compose_yaml(text)):
        new = change(path, scalar.value)
        if new is not None and new != scalar.value:
            start, end = scalar.start_mark.index, scalar.end_mark.index
            anchor = _ANCHOR.match(text, start, end)
            changes[anchor.end() if anchor else start] = end, new
    for start in sorted(changes, reverse=True):
        end, new = changes[start]
        text = text[:start] + new + _rest(text[end:], end - start - len(new), comment)
    return text


def _rest(rest: str, shorter: int, comment: str) -> str:
    """Return what follows a value that is ``shorter`` than before, its comment in its column."""
    line, newline, below = rest.partition("\n")
    before, mark, old = line.partition("#")
    if not mark or before.strip():
        return rest
    gap = " " * max(len(before) + shorter, 2)
    return f"{gap}#{f' {comment}' if comment else old}{newline}{below}"


def scalars(node: yaml.Node, path: Path = ()) -> Iterator[tuple[Path, yaml.ScalarNode]]:
    """Yield each scalar value with its path."""
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            yield from scalars(value, (*path, str(key.value)))
    elif isinstance(node, yaml.SequenceNode):
        for number, item in enumerate(node.value):
            yield from scalars(item, (*path, str(number)))
    elif isinstance(node, yaml.ScalarNode):
        yield path, node
