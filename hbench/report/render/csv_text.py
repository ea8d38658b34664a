"""CSV text, with cells that no spreadsheet takes for a formula."""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from hbench.report.json_documents.values import json_value
from hbench.untrusted_text import as_cell


def csv_of(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a head and rows of cells as CSV; the cells are taken as they are."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows(rows)
    return text.getvalue()


def csv_text(columns: tuple[str, ...], rows: Iterable[Mapping[str, Any]]) -> str:
    """Return rows as CSV, with these of their columns."""
    return csv_of(columns, ([_cell(row[name]) for name in columns] for row in rows))


def _cell(value: Any) -> str:
    value = json_value(value)
    if isinstance(value, str):
        return as_cell(value)
    if isinstance(value, bool):
        return "true" if value else "false"
    return "" if value is None else repr(value)
