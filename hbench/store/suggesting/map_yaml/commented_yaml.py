"""Lines of YAML with comments."""

import json
import re
import textwrap
from collections.abc import Iterator

from hbench.config.files.yaml_text import parse_yaml
from hbench.untrusted_text import printable

_COMMENT_AT, _WIDTH = 36, 110
_PLAIN = re.compile(r"[A-Za-z_][\w./*(){} -]*(?<! )")


def line(text: str, comment: str = "") -> str:
    """Return a key with its value, and a comment behind it."""
    comment = printable(" ".join(comment.split()))
    return f"{text:<{_COMMENT_AT - 1}} # {comment}" if comment else text


def entry(text: str, comment: str) -> Iterator[str]:
    """Yield a key with its comment beside it, or above it where it would be too long."""
    beside = line(text, comment)
    if len(beside) <= _WIDTH:
        yield beside
        return
    indent = text[: len(text) - len(text.lstrip())]
    yield from comment_lines(comment, f"{indent}# ")
    yield text


def comment_lines(text: str, prefix: str = "# ") -> Iterator[str]:
    """Yield the lines of a comment; ``prefix`` begins each."""
    text = printable(" ".join(text.split()))
    yield from (prefix + part for part in textwrap.wrap(text, _WIDTH - 10 - len(prefix)))


def scalar(text: str, flow: bool = False) -> str:
    """Return text as a scalar of YAML: plain where that is read as the same text."""
    if _PLAIN.fullmatch(text) and not (flow and set(text) & set(" {}")):
        try:
            if parse_yaml(text) == text:
                return text
        except ValueError:
            pass
    return json.dumps(printable(text), ensure_ascii=False)
