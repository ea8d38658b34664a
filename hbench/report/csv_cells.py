"""CSV that is safe to open in a spreadsheet."""

import csv
import io
from collections.abc import Iterable, Sequence


def text_cell(text: str) -> str:
    """Return ``text`` so that no spreadsheet runs it as a formula: an apostrophe makes it text."""
    return f"'{text}" if text.startswith(("=", "+", "-", "@", "\t", "\r")) else text


def csv_of(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a head and rows of cells as CSV; the cells are taken as they are."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return text.getvalue()
