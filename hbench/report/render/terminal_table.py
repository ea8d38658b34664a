"""Tables in aligned columns, for a terminal."""

from collections.abc import Iterable

from hbench.records import WordTable
from hbench.report.render.terminal_text import plain


def table_lines(table: WordTable) -> Iterable[str]:
    """Yield the title and the rows of a table in columns.

    Signs that some terminals do not have are replaced before the columns are aligned.
    """
    rows = [[plain(cell) for cell in row] for row in (table.head, *table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    yield table.title
    for row in rows:
        yield "  ".join(map(str.ljust, row, widths)).rstrip()
