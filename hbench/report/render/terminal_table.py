"""Tables in aligned columns, for a terminal."""

from collections.abc import Iterable
from itertools import zip_longest
from textwrap import wrap

from hbench.records import WordTable
from hbench.report.render.terminal_text import plain

_HEAD = 14  # letters of a head that is not broken over lines


def table_lines(table: WordTable) -> Iterable[str]:
    """Yield the title and the rows of a table in columns; a head wider than its cells is broken.

    Signs that some terminals do not have are replaced before the columns are aligned.
    """
    head, *rows = [[plain(cell) for cell in row] for row in (table.head, *table.rows)]
    widest = [max(_HEAD, *map(len, column)) for column in zip(*rows, strict=True)]
    heads = [wrap(name, width) for name, width in zip(head, widest or map(len, head), strict=True)]
    lines = max(map(len, heads))
    heads = [[""] * (lines - len(each)) + each for each in heads]
    rows = [*map(list, zip_longest(*heads, fillvalue="")), *rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    yield table.title
    for row in rows:
        yield "  ".join(map(str.ljust, row, widths)).rstrip()
