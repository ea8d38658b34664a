"""Margins of a PDF's sheets: the running header and the footer."""

import re
from collections.abc import Sequence
from importlib.metadata import version

from matplotlib.figure import Figure

from hbench.report.render.document import Document
from hbench.report.render.pdf_pen import (
    INNER,
    LEFT,
    SHEET_HEIGHT,
    SHEET_WIDTH,
    is_in_font,
    set_text,
    width_of,
    wrapped,
)
from hbench.report.render.pdf_table import QUIET

_SIZE = 7.5  # of letters, points
_HEADER = 34.0  # base of the running header and, from below, of the footer
_DATE = re.compile(r"\d{4}-\d\d-\d\d")
_BOXES = "Boxes stand for letters that the font of this PDF does not have; report.html shows them."


def set_margins(sheets: Sequence[Figure], document: Document) -> None:
    """Set the header with the document's name and the footer with the number of each sheet."""
    about, right, foot = _running(document), SHEET_WIDTH - LEFT, SHEET_HEIGHT - _HEADER + 10
    for number, sheet in enumerate(sheets, start=1):
        set_text(sheet, LEFT, _HEADER, _shortened(document.tab, about), _SIZE, color=QUIET)
        set_text(sheet, right, _HEADER, about, _SIZE, color=QUIET, ha="right")
        written, page = f"Written by hbench {version('hbench')}", f"Page {number} of {len(sheets)}"
        if not all(is_in_font(text.get_text()) for text in sheet.texts):
            written = f"{written}. {_BOXES}"
        set_text(sheet, LEFT, foot, written, _SIZE, color=QUIET)
        set_text(sheet, right, foot, page, _SIZE, color=QUIET, ha="right")


def _running(document: Document) -> str:
    """Return cylinder, number and date of the test for the header of each sheet."""
    facts = dict(document.identity)
    cylinder = facts.get("Cylinder", "")
    known = (facts.get(name, "") for name in ("Test date", "Measured", "Simulated time"))
    dates = [found[0] for text in known if (found := _DATE.match(text))]
    number = facts.get("Test number", "")
    parts = (
        "" if cylinder.startswith("no serial") else cylinder,
        f"test {number}" if number else "",
        dates[0] if dates else "",
        "hbench",
    )
    return " · ".join(filter(None, parts))


def _shortened(text: str, beside: str) -> str:
    """Return as much of a title as fits into the header ``beside`` another text."""
    return wrapped(text, INNER - width_of(beside, "normal") * _SIZE - 20, _SIZE)[0]
