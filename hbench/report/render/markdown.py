"""A document as Markdown, with its figures as files beside it."""

import re
from collections.abc import Iterator

from hbench.records import WordTable
from hbench.report.render.document import Document, Section, numbered
from hbench.report.render.word_tables import Cell, Table, numeric

_MARKS = re.compile(r"([\\`*_{}\[\]<>#|~$&!])")


def markdown(document: Document) -> str:
    """Return a document as Markdown (GitHub's dialect); folded sections are unfolded."""
    document = numbered(document)
    head = [f"# {escaped(document.title)}", escaped(document.subtitle)]
    head += [
        f"**{escaped(text)}**"
        for text in (document.alarm, document.banner, document.verdict)
        if text
    ]
    identity = [f"- **{escaped(name)}:** {escaped(text)}" for name, text in document.identity]
    head += ["\n".join(identity)]
    blocks = [block for section in document.sections for block in _blocks(section, 2)]
    return "\n\n".join([*filter(None, head), *blocks]) + "\n"


def escaped(text: str) -> str:
    """Return text on one line, with the characters of Markdown's markup escaped."""
    line = _MARKS.sub(r"\\\1", " ".join(text.split()))
    return re.sub(r"^(\d*)([-+=.)])(?=\s|$)", r"\1\\\2", line)  # no list, no rule


def _blocks(section: Section, level: int) -> Iterator[str]:
    if section.title:
        yield f"{'#' * min(level, 6)} {escaped(section.title)}"
    tiles = [
        f"- **{escaped(t.value)}** {escaped(t.unit)} ({escaped(t.more)})" for t in section.tiles
    ]
    if tiles:
        yield "\n".join(tiles)
    yield from map(escaped, section.paragraphs)
    if section.items:
        yield "\n".join(f"- {escaped(item)}" for item in section.items)
    if section.code:
        yield "\n".join(f"    {line}" for line in section.code.splitlines())
    for drawing in section.drawings:
        yield f"![{escaped(drawing.seen or drawing.caption)}](figures/{drawing.name}.svg)"
        data = f" [Data](figures/{drawing.name}.csv)" if drawing.csv else ""
        yield f"**{escaped(drawing.title)}.** {escaped(drawing.caption)}{data}"
    for table in section.tables:
        if table.title:
            yield f"**{escaped(table.title)}**"
        yield "\n".join(_table(table))
    if section.facts:
        yield "\n".join(f"- **{escaped(name)}:** {escaped(text)}" for name, text in section.facts)
    for part in section.parts:
        yield from _blocks(part, level + 1)


def _table(table: WordTable | Table) -> Iterator[str]:
    yield _row(table.head)
    right = numeric(table)
    rules = ["---:" if column in right else "---" for column in range(len(table.head))]
    yield _row(rules, as_it_is=True)
    yield from (_row([words(cell) for cell in row]) for row in table.rows)


def _row(cells: list[str] | tuple[str, ...], as_it_is: bool = False) -> str:
    return f"| {' | '.join(cells if as_it_is else map(escaped, cells))} |"


def words(cell: Cell | str) -> str:
    """Return a cell with its flag as text."""
    if isinstance(cell, str):
        return cell
    if not cell.text:
        return cell.flag
    return " ".join(filter(None, (cell.text, cell.flag and f"({cell.flag})")))
