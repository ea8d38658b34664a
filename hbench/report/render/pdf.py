"""A document as an A4 PDF, set by matplotlib: no browser, no other program, the same everywhere.

Each sheet has a header with the document's name and a footer with its number. Figures are embedded
as the PNG files beside the page; one that does not fit goes to the top of the next sheet. For
vector figures, or the page's layout, print the page from a browser.
"""

import io
import re
from collections.abc import Callable, Iterator
from functools import partial
from importlib.metadata import version
from struct import unpack

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.image import imread
from PIL import Image

from hbench.records import WordTable
from hbench.report.render.document import Document, Section, has_unprinted, menu, numbered
from hbench.report.render.figures import Drawing
from hbench.report.render.markdown import words
from hbench.report.render.numbers import unbroken
from hbench.report.render.pdf_pen import (
    INK,
    INNER,
    LEFT,
    LINE,
    SHEET_HEIGHT,
    SHEET_WIDTH,
    Pen,
    is_in_font,
    set_text,
    width_of,
    wrapped,
)
from hbench.report.render.pdf_table import CELLS, QUIET, least_height, set_table
from hbench.report.render.style import NARROW_IN, RC, WIDTH_IN
from hbench.report.render.word_tables import Cell, Table, numeric

_BODY, _SMALL = 8.5, 7.5  # size of letters, points
_TITLE, _SECTION, _PART = 17.0, 13.0, 10.0
_GAP = 14.0  # between figures side by side
_FIGURE = (INNER - _GAP) / 2
_PALETTE = 250  # colours of an image
_BESIDE = 24.0  # of a caption beside its figure, from the top
_FLAG = 16  # letters of a flag that is not broken, such as (not determined)
_LABEL = 0.22  # share of a fact's name
_ALARM, _BANNER = "#9b1111", "#8a3a00"
_INSET = 10.0  # of a text inside a frame
_HEADING, _CAPTION, _FEW_LINES = 34.0, 20.0, 40.0  # heights of a heading, a table's title, a text
_DATE = re.compile(r"\d{4}-\d\d-\d\d")
_NUMBERS = "report.html has more tables; the numbering counts them."
_BOXES = "Boxes stand for letters that the font of this PDF does not have; report.html shows them."
_HEADER = 34.0  # base of the running header and, from below, of the footer


def pdf(document: Document) -> bytes:
    """Return ``document`` as an A4 PDF; the same document gives the same bytes."""
    target = io.BytesIO()
    with rc_context({**RC, "font.family": "DejaVu Sans", "pdf.fonttype": 42}):
        with PdfPages(target, metadata={"CreationDate": None, "Title": document.tab}) as file:
            for sheet in sheets(document):
                file.savefig(sheet)
    return target.getvalue()


def sheets(document: Document) -> list[Figure]:
    """Return the sheets of paper that ``document`` fills."""
    more_on_the_page = has_unprinted(document.sections)
    document = numbered(document, on_paper=True)
    pen = Pen()
    pen.words(document.title, _TITLE, weight="bold")
    pen.space(3)
    pen.words(document.subtitle, _BODY, color=QUIET)
    lead, more = document.headline
    for text, color in ((document.alarm, _ALARM), (document.banner, _BANNER)):
        if text:
            _emphasised(pen, text, "", color, pen.frame)
    if lead:
        _emphasised(pen, lead, more, INK, pen.bar)
    if document.identity:
        pen.space(6)
        pen.rule()
        pen.space(2)
        _facts(pen, document.identity)
        pen.space(3)
        pen.rule()
    listed = menu(document)
    set_contents = _contents(pen, [section.title for section in listed])
    if more_on_the_page:
        pen.words(_NUMBERS, CELLS, color=QUIET)
    pages = {section.title: _set(pen, section, _SECTION) for section in document.sections}
    pen.place_waiting()
    set_contents(pages)
    about = _running(document)
    for number, sheet in enumerate(pen.done, start=1):
        right = SHEET_WIDTH - LEFT
        set_text(sheet, LEFT, _HEADER, _shortened(document.tab, about), _SMALL, color=QUIET)
        set_text(sheet, right, _HEADER, about, _SMALL, color=QUIET, ha="right")
        foot, page = SHEET_HEIGHT - _HEADER + 10, f"Page {number} of {len(pen.done)}"
        written = f"Written by hbench {version('hbench')}"
        if not all(is_in_font(text.get_text()) for text in sheet.texts):
            written = f"{written}. {_BOXES}"
        set_text(sheet, LEFT, foot, written, _SMALL, color=QUIET)
        set_text(sheet, right, foot, page, _SMALL, color=QUIET, ha="right")
    return pen.done


def _emphasised(
    pen: Pen, bold: str, more: str, color: str, mark: Callable[[float, float, str], None]
) -> None:
    """Set a text inside a frame or beside a bar, as on the page; over two sheets without it."""
    pen.space(8)
    top, sheet = pen.y, len(pen.done)
    pen.x, pen.width = LEFT + _INSET, INNER - 2 * _INSET
    pen.space(2)
    pen.words(bold, _BODY + 1, weight="bold", color=color)
    if more:
        pen.space(2)
        pen.words(more, _BODY + 1)
    pen.space(5)
    pen.x, pen.width = LEFT, INNER
    if len(pen.done) == sheet:
        mark(top, pen.y, color)


def _contents(pen: Pen, titles: list[str]) -> Callable[[dict[str, int]], None]:
    """Leave room for the contents here; return what sets them once the pages are known."""

    def lines(pages: dict[str, int]) -> list[str]:
        text = " · ".join(unbroken(f"{title} {pages[title]}") for title in titles)
        return wrapped(f"Contents: {text}", INNER, CELLS) if titles else []

    most = lines(dict.fromkeys(titles, 100))
    pen.space(4)
    sheet, top = pen.done[-1], pen.y
    pen.space(len(most) * CELLS * LINE)

    def set_lines(pages: dict[str, int]) -> None:
        for number, line in enumerate(lines(pages), start=1):
            set_text(sheet, LEFT, top + number * CELLS * LINE, line, CELLS, color=QUIET)

    return set_lines


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
    return wrapped(text, INNER - width_of(beside, "normal") * _SMALL - 20, _SMALL)[0]


def _set(pen: Pen, section: Section, size: float) -> int:
    """Set a section and return the number of the sheet on which it begins."""
    if section.drawings and not _has_text(section):
        pen.place_waiting()  # the heading is above its own figures
    if section.title:
        pen.room(_HEADING + _opening(pen, section))  # no heading alone at the foot of a sheet
        pen.space(12 if size > _PART else 7)
        pen.words(section.title, size, weight="bold")
        pen.space(2)
    begins = len(pen.done)
    _facts(pen, [(f"{tile.value} {tile.unit}".strip(), tile.more) for tile in section.tiles])
    if section.tiles:
        pen.space(3)
    for text in section.paragraphs:
        pen.words(text, _BODY)
        pen.space(3)
    for item in section.items:
        pen.words(f"– {item}", _BODY)
        pen.space(2)
    for line in section.code.splitlines():
        pen.room(_SMALL * LINE)
        pen.write(line, _SMALL, family="DejaVu Sans Mono")
    set_figures(pen, section.drawings)
    for table in section.tables:
        _table(pen, table)
    _facts(pen, section.facts)
    for part in section.parts:
        _set(pen, part, _PART)
    return begins


def _opening(pen: Pen, section: Section) -> float:
    """Return the height of what a heading needs on its sheet: its text, or the first that follows.

    Figures after a text may go to the next sheet.
    """
    height = sum(
        len(wrapped(text, pen.width, _BODY)) * _BODY * LINE + 3 for text in section.paragraphs
    )
    if section.drawings and _has_text(section):
        return height
    for row in list(_side_by_side(section.drawings))[:1]:
        return height + max(_heights(row)) + _below(_captions(row)) + 8
    if section.tables:
        return (
            height + _CAPTION + least_height(pen, section.tables[0].head, _rows(section.tables[0]))
        )
    if section.parts:
        first = section.parts[0]
        return height + _HEADING * bool(first.title) + _opening(pen, first)
    return height + _FEW_LINES * (not section.paragraphs)


def _has_text(section: Section) -> bool:
    return bool(section.paragraphs or section.items or section.tiles)


def _rows(table: WordTable | Table) -> list[list[str]]:
    numbers = numeric(table)
    rows = []
    for row in table.rows:
        cells: tuple[str | Cell, ...] = row
        rows.append([_cell(cell, column in numbers) for column, cell in enumerate(cells)])
    return rows


def _table(pen: Pen, table: WordTable | Table) -> None:
    rows = _rows(table)
    pen.room(
        _CAPTION + least_height(pen, table.head, rows)
    )  # no title alone at the foot of a sheet
    pen.space(6)
    pen.words(table.title, _SMALL, weight="bold")
    pen.space(2)
    set_table(pen, table.head, rows, numeric(table), table.title)
    pen.space(4)


def _cell(cell: Cell | str, number: bool) -> str:
    """Return a cell's text; a number is not broken, its flag may go below it."""
    if not number:
        return words(cell)
    text, flag = (cell, "") if isinstance(cell, str) else (cell.text, cell.flag)
    remark = flag and f"({flag})"
    remark = unbroken(remark) if len(flag) < _FLAG else remark
    return " ".join(filter(None, (unbroken(text), remark)))


def _facts(pen: Pen, facts: tuple[tuple[str, str], ...] | list[tuple[str, str]]) -> None:
    """Set names on the left and their texts beside them."""
    longest = max((width_of(name, "bold") * CELLS for name, _ in facts), default=0.0) + 10
    share = min(_LABEL, longest / pen.width)
    rows = []
    for name, text in facts:
        names = wrapped(name, pen.width * share - 6, CELLS, "bold")
        texts = wrapped(text, pen.width * (1 - share), CELLS)
        rows.append((names, texts, max(len(names), len(texts)) * CELLS * LINE))
    for number, (names, texts, height) in enumerate(rows):
        last = rows[-1][-1] + 1 if number == len(rows) - 2 else 0.0  # no last row alone
        pen.room(height + last)
        top = pen.y
        for line in names:
            pen.write(line, CELLS, weight="bold")
        pen.y = top
        for line in texts:
            pen.write(line, CELLS, x=pen.x + pen.width * share)
        pen.y = top + height + 1


def set_figures(pen: Pen, drawings: tuple[Drawing, ...]) -> None:
    """Set figures, two side by side or one over the whole width, with their captions."""
    for row in _side_by_side(drawings):
        captions = _captions(row)
        below = 0.0 if _is_beside(row) else _below(captions)
        height = max(_heights(row)) + below + 8
        pen.floating(height, partial(_figure_row, pen, row, captions, below))


def _figure_row(pen: Pen, row: list[Drawing], captions: list[list[str]], below: float) -> None:
    """Set figures side by side; their captions have a height ``below`` them, or are beside."""
    images = [_few_colours(drawing.png) for drawing in row]
    wide, heights, beside = _width(row), _heights(row), _is_beside(row)
    pen.space(6)
    top, bottom = pen.y, pen.y + max(heights) + 2
    for column, (image, height) in enumerate(zip(images, heights, strict=True)):
        pen.image(image, LEFT + column * (_FIGURE + _GAP), wide, height, interpolation="none")
    for column, lines in enumerate(captions, start=int(beside)):
        pen.y = top + _BESIDE if beside else bottom
        for line in lines:
            pen.write(line, _SMALL, x=LEFT + column * (_FIGURE + _GAP), color=QUIET)
    pen.y = bottom + below


def _width(row: list[Drawing]) -> float:
    if row[0].narrow:
        return _FIGURE * NARROW_IN / WIDTH_IN
    return INNER if row[0].wide else _FIGURE


def _heights(row: list[Drawing]) -> list[float]:
    """Return the heights of figures that are side by side."""
    sizes = (unpack(">II", drawing.png[16:24]) for drawing in row)  # of a PNG's header
    return [_width(row) * height / width for width, height in sizes]


def _is_beside(row: list[Drawing]) -> bool:
    """Return whether the caption goes beside its figure, where half of the sheet is free."""
    return len(row) == 1 and not row[0].wide


def _captions(row: list[Drawing]) -> list[list[str]]:
    return [wrapped(_caption(drawing), _width(row), _SMALL) for drawing in row]


def _below(captions: list[list[str]]) -> float:
    """Return the height of captions below their figures."""
    return max(map(len, captions)) * _SMALL * LINE


def _few_colours(png: bytes) -> np.ndarray:
    """Return an image (h, w, 3) of so few colours that matplotlib writes it with a palette."""
    pixels = np.round(255 * imread(io.BytesIO(png))).astype(np.uint8)
    image = Image.fromarray(pixels).convert("RGB")
    return np.asarray(image.quantize(_PALETTE, dither=Image.Dither.NONE).convert("RGB"))


def _caption(drawing: Drawing) -> str:
    """Return a figure's number, title and caption."""
    return f"{drawing.title}. {drawing.caption}".strip()


def _side_by_side(drawings: tuple[Drawing, ...]) -> Iterator[list[Drawing]]:
    waiting: list[Drawing] = []
    for drawing in drawings:
        if drawing.wide:
            yield from ([waiting] if waiting else [])
            waiting = []
            yield [drawing]
        else:
            waiting.append(drawing)
            if len(waiting) == 2:
                yield waiting
                waiting = []
    if waiting:
        yield waiting
