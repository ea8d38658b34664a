"""Comments of a dataclass's fields, read from its source."""

import ast
import io
import textwrap
import tokenize
from functools import cache
from inspect import getsource


@cache
def field_comments(record: type) -> dict[str, str]:
    """Return the comment of each field that has one: behind it, or in the lines above it."""
    source = textwrap.dedent(getsource(record))
    comments, alone = {}, set()
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            comments[token.start[0]] = token.string.lstrip("# ")
            if not token.line[: token.start[1]].strip():
                alone.add(token.start[0])
    (definition,) = ast.parse(source).body
    assert isinstance(definition, ast.ClassDef)
    by_field = {}
    for node in definition.body:
        if not isinstance(node, ast.AnnAssign) or not isinstance(node.target, ast.Name):
            continue
        lines = range(node.lineno, (node.end_lineno or node.lineno) + 1)
        texts = [comments[line] for line in lines if line in comments]
        above = node.lineno - 1
        while above in alone:
            texts.insert(0, comments[above])
            above -= 1
        if texts:
            by_field[node.target.id] = " ".join(texts)
    return by_field
