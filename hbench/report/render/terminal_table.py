"""Tables in aligned columns, for a terminal."""

from collections.abc import Iterable
from textwrap import wrap

from hbench.records import WordTable

_LEAST = 24  # letters of a column that is wrapped


def table_lines(table: WordTable, width: int | None = None) -> Iterable[str]:
    """Yield the title and the rows of a table in columns; the last is wrapped within ``width``.

    ``±`` becomes ``+-`` before the columns are aligned, since terminals may lack it.
    """
    rows = [[cell.replace("±", "+-") for cell in row] for row in (table.head, *table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    if width is not None:
        widths[-1] = max(_LEAST, width - sum(widths[:-1]) - 2 * (len(widths) - 1))
    yield table.title
    for row in rows:
        first, *more = wrap(row[-1], widths[-1], subsequent_indent="  ") or [""]
        yield "  ".join(map(str.ljust, (*row[:-1], first), widths)).rstrip()
        before = " " * (sum(widths[:-1]) + 2 * (len(widths) - 1))
        yield from (f"{before}{line}" for line in more)
