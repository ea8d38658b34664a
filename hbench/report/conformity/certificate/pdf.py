"""The certificate as an A4 PDF, set by matplotlib: the same content as the page, the same bytes.

Lengths are in points, from the top left of a sheet. The letters are DejaVu Sans, which comes with
matplotlib; their widths are measured.
"""

import io
from collections.abc import Callable, Sequence
from functools import cache

from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.image import imread
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.textpath import TextToPath

from hbench.errors import ConfigError
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.content import Content, GridTable, Part, content

_WIDTH, _HEIGHT = 595.28, 841.89  # of A4
_LEFT, _TOP, _BOTTOM = 43.0, 50.0, 44.0
_INNER = _WIDTH - 2 * _LEFT
_GAP = 20.0  # between parts side by side
_LINE = 1.27  # times the size of the letters
_BODY, _CELLS, _HEADING, _TITLE = 7.5, 7.2, 8.8, 18.0
_INK, _QUIET, _RULE, _ACCENT, _MARK = "#000000", "#444444", "#bbbbbb", "#1d4e6f", "#9b1c1c"
_LABEL = 0.34  # share of a fact's name
_CELL_GAP = 8.0
_LOGO = (125.0, 60.0)  # largest
_SIGNATURE = 62.0  # height
_TOGETHER = 6  # lines of a paragraph that is not broken


def certificate_pdf(certificate: Certificate) -> bytes:
    """Return the certificate as PDF. Raises ``ConfigError`` for a logo that is an SVG."""
    target = io.BytesIO()
    with rc_context({"font.family": "DejaVu Sans", "pdf.fonttype": 42}):
        metadata = {"CreationDate": None, "Title": f"{certificate.number}", "Creator": "hbench"}
        with PdfPages(target, metadata=metadata) as file:
            for sheet in sheets(certificate):
                file.savefig(sheet)
    return target.getvalue()


def sheets(certificate: Certificate) -> list[Figure]:
    """Return the sheets of paper that the certificate fills."""
    shown = content(certificate)
    pen = _Pen()
    _header(pen, certificate, shown)
    if shown.mark:
        _mark(pen, shown.mark, shown.mark_text)
    for row in shown.rows:
        _row(pen, row)
    _signatures(pen, shown)
    if shown.mark:
        _mark(pen, shown.mark, "")
    pen.space(6)
    pen.room(_BODY * _LINE)
    pen.write(shown.end, _BODY, x=_WIDTH / 2, ha="center", color=_QUIET)
    for number, sheet in enumerate(pen.done, start=1):
        page = f"{shown.page_label} {number} {shown.of_label} {len(pen.done)}"
        _text(sheet, _LEFT, 34, f"{shown.number_label} {shown.number}", 7.5, color=_QUIET)
        _text(sheet, _WIDTH - _LEFT, 34, page, 7.5, color=_QUIET, ha="right")
        if shown.mark:
            _text(
                sheet,
                _WIDTH / 2,
                _HEIGHT - 24,
                shown.mark,
                10,
                color=_MARK,
                ha="center",
                weight="bold",
            )
            _watermark(sheet, shown.mark)
    return pen.done


class _Pen:
    """Place on the sheets that is filled next: a column at a height."""

    def __init__(self) -> None:
        self.done: list[Figure] = []
        self.x, self.width = _LEFT, _INNER
        self.on_turn: Callable[[], None] | None = None  # repeats the head of a table
        self._turn()

    def _turn(self) -> None:
        figure = Figure(figsize=(_WIDTH / 72, _HEIGHT / 72))
        FigureCanvasAgg(figure)
        self.done.append(figure)
        self.y = _TOP

    def room(self, height: float) -> None:
        """Begin another sheet where this one has less than ``height`` left."""
        if self.y + height > _HEIGHT - _BOTTOM and self.y > _TOP:
            self._turn()
            if self.on_turn is not None:
                self.on_turn()

    def space(self, height: float) -> None:
        self.y += height

    def write(self, line: str, size: float, x: float | None = None, **look: str) -> None:
        """Set a line and go below it."""
        self.y += size * _LINE
        _text(self.done[-1], self.x if x is None else x, self.y, line, size, **look)

    def words(self, text: str, size: float, weight: str = "normal", color: str = _INK) -> None:
        """Set a paragraph in the column, over sheets if need be."""
        lines = wrapped(text, self.width, size, weight)
        if len(lines) <= _TOGETHER:
            self.room(len(lines) * size * _LINE)
        for line in lines:
            self.room(size * _LINE)
            self.write(line, size, weight=weight, color=color)

    def rule(self, color: str = _RULE, width: float = 0.6) -> None:
        """Draw a line over the column."""
        y = 1 - self.y / _HEIGHT
        ends = self.x / _WIDTH, (self.x + self.width) / _WIDTH
        self.done[-1].add_artist(Line2D(ends, (y, y), color=color, linewidth=width))


@cache
def _font(weight: str, family: str = "DejaVu Sans") -> FontProperties:
    return FontProperties(family=family, weight=weight, size=100)


_MEASURE = TextToPath()


@cache
def _width_of(text: str, weight: str, family: str = "DejaVu Sans") -> float:
    """Return the width of a text per point of its size."""
    font = _font(weight, family)
    return float(_MEASURE.get_text_width_height_descent(text, font, False)[0]) / 100


def wrapped(text: str, width: float, size: float, weight: str = "normal") -> list[str]:
    """Break a text into lines of at most ``width``; a longer word is broken too."""
    width += 0.01  # of rounding
    lines, line = [], ""
    for word in text.split(" "):
        longer = f"{line} {word}".strip()
        if _width_of(longer, weight) * size <= width:
            line = longer
            continue
        if line:
            lines.append(line)
        while len(word) > 1 and _width_of(word, weight) * size > width:
            fits = max(
                1, sum(_width_of(word[:n], weight) * size <= width for n in range(1, len(word)))
            )
            lines.append(word[:fits])
            word = word[fits:]
        line = word
    return [*lines, line] if line or not lines else lines


def _text(sheet: Figure, x: float, y: float, text: str, size: float, **look: str) -> None:
    style = {"color": _INK, "va": "baseline", **look}
    if text:
        sheet.text(x / _WIDTH, 1 - y / _HEIGHT, text, size=size, parse_math=False, **style)


def _watermark(sheet: Figure, text: str) -> None:
    style = {"ha": "center", "va": "center", "color": _MARK, "weight": "bold"}
    sheet.text(0.5, 0.5, text, size=34, rotation=52, alpha=0.12, zorder=0, **style)


def _header(pen: _Pen, certificate: Certificate, shown: Content) -> None:
    top = pen.y
    logo_height = _logo(pen, certificate, top)
    pen.width = _INNER - (_LOGO[0] + _GAP if certificate.logo else 0)
    pen.words(shown.title, _TITLE, weight="bold", color=_ACCENT)
    pen.words(certificate.file.laboratory.name, _HEADING, weight="bold")
    _facts(pen, shown.head_facts, 0.25)
    pen.width = _INNER
    pen.y = max(pen.y, top + logo_height) + 5
    pen.rule(_ACCENT, 1.5)


def _logo(pen: _Pen, certificate: Certificate, top: float) -> float:
    """Draw the logo at the top right; return its height."""
    logo = certificate.logo
    if logo is None:
        return 0.0
    if logo.media_type != "image/png":
        raise ConfigError(
            f"logo = {certificate.file.logo!r}: the PDF takes a PNG file only",
            "Give a PNG file, or print the page (.html) from a browser.",
        )
    try:
        image = imread(io.BytesIO(logo.data))
    except (SyntaxError, OSError, ValueError) as error:  # of Pillow
        raise ConfigError(f"logo = {certificate.file.logo!r}: {error}") from None
    high, wide = image.shape[:2]
    scale = min(_LOGO[0] / wide, _LOGO[1] / high)
    wide, high = wide * scale, high * scale
    left = _WIDTH - _LEFT - wide
    box = (left / _WIDTH, 1 - (top + high) / _HEIGHT, wide / _WIDTH, high / _HEIGHT)
    axes = pen.done[-1].add_axes(box)
    axes.imshow(image, aspect="auto", cmap="gray")
    axes.set_axis_off()
    return high


def _mark(pen: _Pen, mark: str, text: str) -> None:
    """Frame the mark of a document that certifies nothing."""
    lines = wrapped(text, _INNER - 20, _BODY + 0.5) if text else []
    height = 10 + 11 * _LINE + len(lines) * (_BODY + 0.5) * _LINE
    pen.space(7)
    pen.room(height)
    frame = Rectangle(
        (_LEFT / _WIDTH, 1 - (pen.y + height) / _HEIGHT),
        _INNER / _WIDTH,
        height / _HEIGHT,
        fill=False,
        edgecolor=_MARK,
        linewidth=1.5,
    )
    pen.done[-1].add_artist(frame)
    pen.space(1)
    pen.write(mark, 11, x=_LEFT + 10, color=_MARK, weight="bold")
    for line in lines:
        pen.write(line, _BODY + 0.5, x=_LEFT + 10, color=_MARK)
    pen.space(9)


def _row(pen: _Pen, parts: Sequence[Part]) -> None:
    if len(parts) == 1:
        _part(pen, parts[0])
        return
    pen.width = (_INNER - _GAP * (len(parts) - 1)) / len(parts)
    pen.room(max(_fact_height(part, pen.width) for part in parts))
    top, lowest = pen.y, pen.y
    for part in parts:
        pen.y = top
        _part(pen, part)
        lowest = max(lowest, pen.y)
        pen.x += pen.width + _GAP
    pen.x, pen.width, pen.y = _LEFT, _INNER, lowest


def _fact_height(part: Part, width: float) -> float:
    lines = sum(
        max(
            len(wrapped(text, width * (1 - _LABEL), _BODY)),
            len(wrapped(name, width * _LABEL - 6, _BODY)),
        )
        for name, text in part.facts
    )
    return 22 + lines * _BODY * _LINE


def _part(pen: _Pen, part: Part) -> None:
    pen.room(22 + 3 * _BODY * _LINE + (20 if part.tables else 0))  # no heading alone at the foot
    pen.space(7)
    pen.write(part.title, _HEADING, weight="bold", color=_ACCENT)
    pen.space(2.5)
    pen.rule()
    pen.space(1)
    if part.lead:
        pen.words(part.lead, _BODY, weight="bold")
    _facts(pen, part.facts, _LABEL if pen.width < _INNER else 0.22)
    for table in part.tables:
        _table(pen, table)
    for text in part.paragraphs:
        pen.words(text, _BODY)


def _facts(pen: _Pen, facts: Sequence[tuple[str, str]], share: float) -> None:
    left, width = pen.x, pen.width
    for name, text in facts:
        names = wrapped(name, width * share - 6, _BODY)
        texts = wrapped(text, width * (1 - share), _BODY)
        height = max(len(names), len(texts)) * _BODY * _LINE
        pen.room(height)
        top = pen.y
        for line in names:
            pen.write(line, _BODY, x=left, color=_QUIET)
        pen.y = top
        for line in texts:
            pen.write(line, _BODY, x=left + width * share)
        pen.y = top + height


def _table(pen: _Pen, table: GridTable) -> None:
    """Set a table over the column; its head is repeated on the next sheet."""
    widths = _columns(table, pen.width)
    head = _cells(table.head, widths, "bold")

    def set_head() -> None:
        _line(pen, table, head, widths, weight="bold", color=_QUIET)

    pen.room(_height(head) + 2 * _CELLS * _LINE)
    set_head()
    pen.on_turn = set_head
    for row in table.rows:
        cells = _cells(row, widths, "normal")
        pen.room(_height(cells))
        _line(pen, table, cells, widths)
    pen.on_turn = None
    pen.space(2)


def _line(
    pen: _Pen, table: GridTable, cells: list[list[str]], widths: list[float], **look: str
) -> None:
    top, left = pen.y, pen.x
    for column, (lines, width) in enumerate(zip(cells, widths, strict=True)):
        pen.y = top + 1
        right = column in table.numbers
        for line in lines:
            x = left + width if right else left
            pen.write(line, _CELLS, x=x, ha="right" if right else "left", **look)
        left += width + _CELL_GAP
    pen.y = top + _height(cells)
    pen.rule()


def _height(cells: list[list[str]]) -> float:
    return max(map(len, cells)) * _CELLS * _LINE + 3


def _cells(row: Sequence[str], widths: list[float], weight: str) -> list[list[str]]:
    return [wrapped(cell, width, _CELLS, weight) for cell, width in zip(row, widths, strict=True)]


def _columns(table: GridTable, width: float) -> list[float]:
    """Return widths that fill ``width``: numbers and single words are not broken if possible."""
    rows = [(table.head, "bold"), *((row, "normal") for row in table.rows)]
    least, best = [0.0] * len(table.head), [0.0] * len(table.head)
    for number, (row, weight) in enumerate(rows):
        for column, cell in enumerate(row):
            whole = _width_of(cell, weight) * _CELLS
            word = max((_width_of(w, weight) * _CELLS for w in cell.split(" ")), default=0.0)
            unbroken = whole if column in table.numbers and number else word
            least[column] = max(least[column], unbroken)
            best[column] = max(best[column], whole)
    free = width - _CELL_GAP * (len(table.head) - 1)
    spare = free - sum(least)
    wanted = [more - fewer for more, fewer in zip(best, least, strict=True)]
    if spare <= 0:  # words longer than the page is wide are broken
        return [free * each / sum(least) for each in least]
    share = min(1.0, spare / sum(wanted)) if sum(wanted) else 0.0
    widths = [fewer + share * more for fewer, more in zip(least, wanted, strict=True)]
    rest = (free - sum(widths)) / len(widths)
    return [each + rest for each in widths]


def _signatures(pen: _Pen, shown: Content) -> None:
    columns = 2 if len(shown.signatories) > 1 else 1
    rows = -(-len(shown.signatories) // columns)
    pen.room(30 + rows * _SIGNATURE)
    pen.space(7)
    pen.write(shown.signature_title, _HEADING, weight="bold", color=_ACCENT)
    pen.space(2.5)
    pen.rule()
    width = (_INNER - _GAP) / 2
    for start in range(0, len(shown.signatories), columns):
        top = pen.y
        for column, (name, role) in enumerate(shown.signatories[start : start + columns]):
            pen.x, pen.width, pen.y = _LEFT + column * (width + _GAP), width, top + 30
            pen.rule(_INK)
            pen.write(shown.signature_label, 6.5, color=_QUIET)
            for line in wrapped(name, width, _BODY, "bold")[:2]:
                pen.write(line, _BODY, weight="bold")
            for line in wrapped(role, width, _BODY)[:2]:
                pen.write(line, _BODY)
        pen.x, pen.width, pen.y = _LEFT, _INNER, top + _SIGNATURE
