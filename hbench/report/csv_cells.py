"""CSV of cells that are text already (``hbench.config.words.as_cell``)."""

import csv
import io
from collections.abc import Iterable, Sequence


def csv_of(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a head and rows of cells as CSV; the cells are taken as they are."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return text.getvalue()
