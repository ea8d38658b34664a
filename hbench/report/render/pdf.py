"""A document as PDF, set by matplotlib: no browser, no other program, the same everywhere.

Figures are embedded as the PNG files beside the page. For vector figures, or the page's layout,
print the page from a browser.
"""

import io
import textwrap
from collections.abc import Iterator

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.image import imread

from hbench.records import WordTable
from hbench.report.render.document import Document, Section, numeric
from hbench.report.render.figures import PNG_DPI, Drawing
from hbench.report.render.markdown import words
from hbench.report.render.style import RC
from hbench.report.render.word_tables import Table

_A4_IN = (8.27, 11.69)
_MARGIN_IN = 0.7
_WIDE_IN = _A4_IN[0] - 2 * _MARGIN_IN
_LINE = 1.35  # times the size of the letters
_LETTER = 0.6  # width of a monospaced letter, of its size
_BODY, _CELLS = 9.0, 7.0  # size of letters, points
_LETTERS = 100  # of a line of words
_LEAST_CELL = 10  # letters that a narrowed column keeps
_FIGURE_IN = 3.3  # width of a figure, two side by side


def pdf(document: Document) -> bytes:
    """Return ``document`` as an A4 PDF; the same document gives the same bytes."""
    target = io.BytesIO()
    with rc_context({**RC, "pdf.fonttype": 42}):
        with PdfPages(target, metadata={"CreationDate": None, "Title": document.tab}) as file:
            for sheet in sheets(document):
                file.savefig(sheet)
    return target.getvalue()


def sheets(document: Document) -> list[Figure]:
    """Return the sheets of paper that ``document`` fills."""
    filled = _Sheets()
    filled.words(document.title, 17, bold=True)
    filled.words(document.subtitle, _BODY)
    for text in filter(None, (document.banner, document.verdict)):
        filled.words(text, _BODY + 1, bold=True, above=0.08)
    for section in document.sections:
        _set(filled, section, 14.0)
    for number, sheet in enumerate(filled.done, start=1):
        sheet.text(0.5, 0.035, f"{number}/{len(filled.done)}", ha="center", fontsize=8)
    return filled.done


class _Sheets:
    """Sheets that are filled from the top."""

    def __init__(self) -> None:
        self.done: list[Figure] = []
        self._turn()

    def _turn(self) -> None:
        figure = Figure(figsize=_A4_IN)
        FigureCanvasAgg(figure)
        self.done.append(figure)
        self._top_in = _A4_IN[1] - _MARGIN_IN

    def room(self, height_in: float) -> None:
        """Begin another sheet where this one has less than ``height_in`` left."""
        whole = _A4_IN[1] - 2 * _MARGIN_IN
        if self._top_in - min(height_in, whole) < _MARGIN_IN:
            self._turn()

    def words(
        self, text: str, size: float, bold: bool = False, above: float = 0.0, indent: int = 0
    ) -> None:
        """Set a paragraph."""
        self._top_in -= above
        wide = int(_LETTERS * _BODY / size) - indent
        weight = "bold" if bold else "normal"
        for line in textwrap.wrap(text, max(wide, 20)) or [""]:
            self._line(" " * indent + line, size, weight=weight)
        self._top_in -= 0.05

    def rows(self, lines: list[str], size: float) -> None:
        """Set lines of a table or of code in letters of one width."""
        for line in lines:
            self._line(line, size, family="DejaVu Sans Mono")
        self._top_in -= 0.12

    def _line(self, text: str, size: float, **look: str) -> None:
        height = size * _LINE / 72
        self.room(height)
        self._top_in -= height
        x, y = _MARGIN_IN / _A4_IN[0], self._top_in / _A4_IN[1]
        self.done[-1].text(x, y, text, size=size, va="bottom", parse_math=False, **look)

    def figures(self, drawings: tuple[Drawing, ...]) -> None:
        """Set figures, two side by side or one over the whole width, each over its title."""
        for row in _side_by_side(drawings):
            images = [imread(io.BytesIO(drawing.png)) for drawing in row]
            sizes = [(image.shape[1] / PNG_DPI, image.shape[0] / PNG_DPI) for image in images]
            wide = _WIDE_IN if row[0].wide else _FIGURE_IN
            heights = [wide * height / width for width, height in sizes]
            self.room(max(heights) + 0.4)
            self._top_in -= 0.1
            for column, (image, height) in enumerate(zip(images, heights, strict=True)):
                left = _MARGIN_IN + column * (_WIDE_IN - _FIGURE_IN)
                box = (left, self._top_in - height, wide, height)
                axes = self.done[-1].add_axes([v / _A4_IN[i % 2] for i, v in enumerate(box)])
                axes.imshow(image, aspect="auto", interpolation="none")
                axes.set_axis_off()
            self._top_in -= max(heights)
        for caption in dict.fromkeys(drawing.caption for drawing in drawings if drawing.caption):
            titles = ", ".join(drawing.title for drawing in drawings if drawing.caption == caption)
            self.words(f"{titles}. {caption}", 7.5)


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


def _set(to: _Sheets, section: Section, size: float) -> None:
    if section.title:
        to.room(4.5 if section.drawings else 1.2)  # no heading alone at the foot of a sheet
        to.words(section.title, size, bold=True, above=0.18 if size > 12 else 0.1)
    for text in section.paragraphs:
        to.words(text, _BODY)
    for tile in section.tiles:
        to.words(f"{tile.value} {tile.unit}: {tile.more}", _BODY + 1, bold=True, indent=2)
    for item in section.items:
        to.words(f"– {item}", _BODY - 1, indent=2)
    if section.code:
        to.rows(section.code.splitlines(), _CELLS)
    to.figures(section.drawings)
    for table in section.tables:
        if table.title:
            to.words(table.title, _BODY, bold=True, above=0.08)
        to.rows(_aligned(table), _CELLS)
    for name, text in section.facts:
        to.words(f"{name}: {text}", _BODY - 1)
    for part in section.parts:
        _set(to, part, 11.0)


def _aligned(table: WordTable | Table) -> list[str]:
    """Return a table in columns; cells of the widest columns are broken so that it fits."""
    rows = [tuple(table.head), *(tuple(map(words, row)) for row in table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    most = int(_WIDE_IN * 72 / (_CELLS * _LETTER))
    needed = [max(map(len, cells)) for cells in zip(*rows[1:], strict=True)] or widths
    while sum(widths) + 2 * (len(widths) - 1) > most and max(widths) > _LEAST_CELL:
        spare = [width - cells for width, cells in zip(widths, needed, strict=True)]
        heads = [column for column, width in enumerate(widths) if width > _LEAST_CELL]
        # Long heads are broken before numbers.
        at = max(heads, key=lambda column: (spare[column] > 0, widths[column]))
        widths[at] -= 1
    right = numeric(table)
    lines = []
    for number, row in enumerate(rows):
        cells = [
            textwrap.wrap(cell, width) or [""] for cell, width in zip(row, widths, strict=True)
        ]
        for i in range(max(map(len, cells))):
            texts = [cell[i] if i < len(cell) else "" for cell in cells]
            line = "  ".join(
                text.rjust(width) if column in right else text.ljust(width)
                for column, (text, width) in enumerate(zip(texts, widths, strict=True))
            )
            lines.append(line.rstrip())
        if number == 0:
            lines.append("─" * min(most, sum(widths) + 2 * (len(widths) - 1)))
    return lines
