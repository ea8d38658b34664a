"""The certificate as an A4 PDF, set by matplotlib: the same content as the page, the same bytes.

Lengths are in points, from the top left of a sheet. The letters are DejaVu Sans, which comes with
matplotlib; their widths are measured.
"""

import io
from collections.abc import Iterator, Sequence
from dataclasses import astuple

from matplotlib import rc_context
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure
from matplotlib.image import imread

from hbench.errors import ConfigError
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.conformity.certificate.content import content
from hbench.report.conformity.certificate.layout import Content, GridTable, Part
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
    wrapped,
)
from hbench.report.render.pdf_table import QUIET, least_height, set_table

_ACCENT, _MARK = "#1d4e6f", "#9b1c1c"
_GAP = 20.0  # between parts side by side
_BODY, _HEADING, _VERDICT, _TITLE = 7.2, 8.8, 16.0, 18.0
_LABEL = 0.34  # share of a fact's name
_LOGO = (125.0, 60.0)  # largest
_SIGNATURE = 50.0  # height
_ABOVE, _BELOW = 4.5, 1.5  # a heading and its rule
_TITLED = 22.0  # height of a heading with its rule and spaces
_OPENING = 50.0  # height of a heading and the first lines of its text
_PARAGRAPH = 2.0  # between paragraphs


def certificate_pdf(certificate: Certificate) -> bytes:
    """Return the certificate as PDF.

    Raises ``ConfigError`` for a logo that is an SVG, and for letters that the font does not have.
    """
    target = io.BytesIO()
    with rc_context({"font.family": "DejaVu Sans", "pdf.fonttype": 42}):
        metadata = {"CreationDate": None, "Title": f"{certificate.number}", "Creator": "hbench"}
        with PdfPages(target, metadata=metadata) as file:
            for sheet in sheets(certificate):
                file.savefig(sheet)
    return target.getvalue()


def _require_letters(shown: Content, *more: str) -> None:
    """Raise ``ConfigError`` for texts that would be printed as boxes."""
    texts = dict.fromkeys(text for text in (*_texts(astuple(shown)), *more) if not is_in_font(text))
    if texts:
        quoted = ", ".join(f"'{text}'" for text in texts)
        raise ConfigError(
            f"the font of the PDF (DejaVu Sans) does not have all letters of {quoted}",
            "Write the certificate as .html and print it from a browser, or use other letters.",
        )


def _texts(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, (tuple, list)):
        for each in value:
            yield from _texts(each)


def sheets(certificate: Certificate) -> list[Figure]:
    """Return the sheets of paper that the certificate fills."""
    shown = content(certificate)
    _require_letters(shown, certificate.file.laboratory.name)
    pen = Pen()
    _header(pen, certificate, shown)
    if shown.mark:
        _mark(pen, shown.mark, shown.mark_text)
    *rows, (validity,) = shown.rows
    for row in rows:
        _row(pen, row)
    pen.room(_text_height(validity) + _signatures_height(shown) + 6 + _BODY * LINE)
    _part(pen, validity)  # on the sheet of the signatures
    _signatures(pen, shown)
    pen.space(6)
    pen.write(shown.end, _BODY, x=SHEET_WIDTH / 2, ha="center", color=QUIET)
    for number, sheet in enumerate(pen.done, start=1):
        page = f"{shown.page_label} {number} {shown.of_label} {len(pen.done)}"
        set_text(sheet, LEFT, 34, f"{shown.number_label} {shown.number}", 7.5, color=QUIET)
        set_text(sheet, SHEET_WIDTH - LEFT, 34, page, 7.5, color=QUIET, ha="right")
        if shown.mark:
            set_text(
                sheet,
                SHEET_WIDTH / 2,
                SHEET_HEIGHT - 24,
                shown.mark,
                10,
                color=_MARK,
                ha="center",
                weight="bold",
            )
            _mark_margins(sheet, shown.mark)
    return pen.done


def _mark_margins(sheet: Figure, text: str) -> None:
    """Write along both margins, where it covers no number."""
    style = {"ha": "center", "va": "center", "color": _MARK, "weight": "bold"}
    middle = LEFT / 2 / SHEET_WIDTH
    for x in (middle, 1 - middle):
        sheet.text(x, 0.5, text, size=10, rotation=90, **style)


def _header(pen: Pen, certificate: Certificate, shown: Content) -> None:
    top, logo_height = pen.y, _logo(pen, certificate)
    pen.width = INNER - (_LOGO[0] + _GAP if certificate.logo else 0)
    pen.words(shown.title, _TITLE, weight="bold", color=_ACCENT)
    pen.words(certificate.file.laboratory.name, _HEADING, weight="bold")
    _facts(pen, shown.head_facts, 0.25)
    pen.width = INNER
    pen.y = max(pen.y, top + logo_height) + 5
    pen.rule(_ACCENT, 1.5)


def _logo(pen: Pen, certificate: Certificate) -> float:
    """Set the logo at the right; return its height."""
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
    pen.image(image, SHEET_WIDTH - LEFT - wide, wide, high, cmap="gray")
    return high


def _mark(pen: Pen, mark: str, text: str) -> None:
    """Frame the mark of a document that certifies nothing."""
    lines = wrapped(text, INNER - 20, _BODY + 0.5) if text else []
    height = 10 + 11 * LINE + len(lines) * (_BODY + 0.5) * LINE
    pen.space(5)
    pen.room(height)
    pen.frame(pen.y, pen.y + height, _MARK)
    pen.space(1)
    pen.write(mark, 11, x=LEFT + 10, color=_MARK, weight="bold")
    for line in lines:
        pen.write(line, _BODY + 0.5, x=LEFT + 10, color=_MARK)
    pen.space(6)


def _row(pen: Pen, parts: Sequence[Part]) -> None:
    if len(parts) == 1:
        _part(pen, parts[0])
        return
    left, *right = parts
    pen.width = (INNER - _GAP) / 2
    heights = [_fact_height(part, pen.width) for part in parts]
    pen.room(max(heights[0], sum(heights[1:])))
    top = pen.y
    _part(pen, left)
    lowest, pen.y = pen.y, top
    pen.x += pen.width + _GAP
    for part in right:
        _part(pen, part)
    pen.x, pen.width, pen.y = LEFT, INNER, max(lowest, pen.y)


def _fact_height(part: Part, width: float) -> float:
    lines = sum(
        max(
            len(wrapped(text, width * (1 - _LABEL), _BODY)),
            len(wrapped(name, width * _LABEL - 6, _BODY)),
        )
        for name, text in part.facts
    )
    return _TITLED + lines * _BODY * LINE


def _text_height(part: Part) -> float:
    lines = (len(wrapped(text, INNER, _BODY)) for text in part.paragraphs)
    return _TITLED + sum(count * _BODY * LINE + _PARAGRAPH for count in lines)


def _signatures_height(shown: Content) -> float:
    return 21 + -(-len(shown.signatories) // _columns(shown)) * _SIGNATURE


def _columns(shown: Content) -> int:
    return 2 if len(shown.signatories) > 1 else 1


def _part(pen: Pen, part: Part) -> None:
    if part.tables:  # no heading alone at the foot
        table = part.tables[0]
        pen.room(_TITLED + least_height(pen, table.head, _unbroken(table)))
    elif part.facts:
        pen.room(_TITLED + 3 * _BODY * LINE)
    else:
        pen.room(min(_text_height(part), _OPENING))
    pen.space(_ABOVE)
    pen.write(part.title, _HEADING, weight="bold", color=_ACCENT)
    pen.space(_BELOW)
    pen.rule()
    pen.space(1)
    if part.verdict:
        pen.words(part.verdict, _VERDICT, weight="bold")
        pen.space(2)
    if part.reserve:
        pen.words(part.reserve, _BODY, weight="bold")
        pen.space(2)
    if part.lead:
        pen.words(part.lead, _BODY)
        pen.space(3)
    _facts(pen, part.facts, _LABEL if pen.width < INNER else 0.22)
    for table in part.tables:
        _table(pen, table)
    for text in part.paragraphs:
        pen.words(text, _BODY)
        pen.space(_PARAGRAPH)


def _facts(pen: Pen, facts: Sequence[tuple[str, str]], share: float) -> None:
    left, width = pen.x, pen.width
    for name, text in facts:
        names = wrapped(name, width * share - 6, _BODY)
        texts = wrapped(text, width * (1 - share), _BODY)
        height = max(len(names), len(texts)) * _BODY * LINE
        pen.room(height)
        top = pen.y
        for line in names:
            pen.write(line, _BODY, x=left, color=QUIET)
        pen.y = top
        for line in texts:
            pen.write(line, _BODY, x=left + width * share)
        pen.y = top + height


def _table(pen: Pen, table: GridTable) -> None:
    set_table(pen, table.head, _unbroken(table), table.numbers, bold=table.emphasised)


def _unbroken(table: GridTable) -> list[list[str]]:
    """Return the rows of a table, with numbers that stay on a line."""
    return [
        [unbroken(cell) if column in table.numbers else cell for column, cell in enumerate(row)]
        for row in table.rows
    ]


def _signatures(pen: Pen, shown: Content) -> None:
    columns = _columns(shown)
    pen.room(_signatures_height(shown))
    pen.space(_ABOVE)
    pen.write(shown.signature_title, _HEADING, weight="bold", color=_ACCENT)
    pen.space(_BELOW)
    pen.rule()
    width = (INNER - _GAP) / 2
    for start in range(0, len(shown.signatories), columns):
        top = pen.y
        for column, (name, role) in enumerate(shown.signatories[start : start + columns]):
            pen.x, pen.width, pen.y = LEFT + column * (width + _GAP), width, top + 26
            pen.rule(INK)
            pen.write(shown.signature_label, 6.5, color=QUIET)
            for line in wrapped(name, width, _BODY, "bold")[:2]:
                pen.write(line, _BODY, weight="bold")
            for line in wrapped(role, width, _BODY)[:2]:
                pen.write(line, _BODY)
        pen.x, pen.width, pen.y = LEFT, INNER, top + _SIGNATURE
