"""Pages: self-contained HTML files with all text escaped."""

import re
from base64 import b64encode
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from importlib.metadata import version
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from hbench.records import WordTable
from hbench.report.render.figures import Drawing
from hbench.report.render.inline_svg import inline
from hbench.report.render.numbers import unit_kept
from hbench.report.render.style import DARK
from hbench.report.render.symbols import subscripts
from hbench.report.render.word_tables import (
    Cell,
    Table,
    Tile,
    cell_classes,
    head_classes,
    numeric,
)
from hbench.sentences import sentences

# Settings of all Jinja environments: text is escaped, and an unknown variable is an error.
ESCAPED: dict[str, Any] = {
    "autoescape": True,
    "undefined": StrictUndefined,
    "trim_blocks": True,
    "lstrip_blocks": True,
}
_COUNT = re.compile(r" \(\d+\)$")  # of rows, behind a folded section's title
_FIGURE = re.compile(r"Figure (\d+)\. ")
_REFERENCE = re.compile(r"\[\[([\w-]+)\]\]")
BANNERS = {
    "simulated": "Simulated. A simulation made these numbers; no cylinder was measured.",
    "imported": "Imported. Another bench logged these runs; hbench screened and analysed them.",
    "real": "Measured on a bench that hbench ran.",
}
_PARAGRAPH = 240  # letters of a verdict that is all emphasised
_NARROW = 3  # columns of a table that fits beside a figure
_MENU = 4  # sections with a title: a shorter page needs no menu


@dataclass(frozen=True)
class Section:
    """Part of a document: tiles, paragraphs, then figures, tables, facts and smaller parts."""

    title: str = ""
    paragraphs: tuple[str, ...] = ()
    items: tuple[str, ...] = ()
    code: str = ""
    drawings: tuple[Drawing, ...] = ()
    tables: tuple[WordTable | Table, ...] = ()
    facts: tuple[tuple[str, str], ...] = ()  # name and description
    parts: tuple["Section", ...] = ()
    tiles: tuple[Tile, ...] = ()
    anchor: str = ""  # by default derived from the title
    folded: bool | None = None  # behind its title: whether it starts folded; None: it never is
    printed: bool = True  # on paper; of folded parts whose numbers are in files beside the page
    holds: str = ""  # the figures and tables that a folded one hides, by their numbers


@dataclass(frozen=True)
class Document:
    """Content of a page, a Markdown file or a PDF."""

    title: str
    subtitle: str
    sections: tuple[Section, ...]
    verdict: str = ""
    banner: str = ""  # warning at the top: the origin of the numbers
    source: str = ""  # simulated, imported, real: the banner's colour
    folder: str = ""  # distinguishes reports of the same title, as in browser tabs
    identity: tuple[tuple[str, str], ...] = ()  # name and value: what was measured, where, by whom
    alarm: str = ""  # why the document is not to be used as it is, such as an aborted campaign

    @property
    def headline(self) -> tuple[str, str]:
        """Return the first sentence of a long verdict, and the others; all of a short one.

        A first sentence of one word, such as ``PASS.``, has the next one with it.
        """
        if len(self.verdict) <= _PARAGRAPH:
            return self.verdict, ""
        first, *others = sentences(self.verdict)
        count = 1 if " " in first else 2
        return " ".join((first, *others)[:count]), " ".join((first, *others)[count:])

    @property
    def tab(self) -> str:
        """Return the title with the folder's name before it; source and incompleteness behind."""
        remarks = ", ".join(filter(None, (self.source, "incomplete" if self.alarm else "")))
        title = ": ".join(filter(None, (self.folder, self.title)))
        return f"{title} ({remarks})" if remarks else title


def document(
    title: str,
    subtitle: str,
    sections: tuple[Section, ...],
    verdict: str = "",
    source: str = "",
    identity: tuple[tuple[str, str], ...] = (),
) -> str:
    """Return a page of sections; ``source`` is that of the numbers, where a bench has any.

    Those of this bench need no banner.
    """
    banner = BANNERS[source] if source in ("simulated", "imported") else ""
    colour = source if banner else ""
    return page(Document(title, subtitle, sections, verdict, banner, colour, identity=identity))


def numbered(document: Document, on_paper: bool = False) -> Document:
    """Return ``document`` with a number before the title of each figure and table, in their order.

    A table without a title has that of its section. ``[[anchor]]`` in the verdict or in the text of
    a section becomes the number of the first table in the section with this anchor, or without one
    its title. Parts that are not printed are left out ``on_paper``, where a reference to one is its
    title. They are counted, so that a table has the same number on the page and on paper.
    """
    counted = _Numbers(on_paper)
    sections = tuple(counted.numbered(section, "") for section in document.sections)
    return replace(
        document,
        sections=tuple(map(counted.referred, sections)),
        verdict=counted.resolved(document.verdict),
    )


def _dotted(number: str, title: str) -> str:
    return ". ".join(filter(None, (number, title)))


def _numbers(kind: str, first: int, last: int) -> str:
    """Return what figures or tables are called, such as ``Tables 2–5``; empty without any."""
    if first >= last:
        return f"{kind} {first}" if first == last else ""
    return f"{kind}s {first}–{last}"


class _Numbers:
    """Numbers of figures and tables so far, and what each anchor is called."""

    def __init__(self, on_paper: bool):
        self.on_paper = on_paper
        self.figures = self.tables = 0
        self.name_of: dict[str, str] = {}

    def numbered(
        self, section: Section, title: str, written: Mapping[str, int] | None = None
    ) -> Section:
        """Return a section with numbered figures and tables.

        A caption is written out once in a section and its parts; one in a folded part may not be
        seen, so no figure outside of that part refers to it. ``written`` are captions before it.
        """
        title = _COUNT.sub("", section.title) or title
        drawings, tables, first = [], [], self.tables + 1
        first_figure = self.figures + 1
        captions = dict(written or {})
        for drawing in section.drawings:
            self.figures += 1
            with_caption = captions.setdefault(drawing.caption, self.figures)
            caption = drawing.caption
            if caption and with_caption < self.figures:
                caption = f"As for Figure {with_caption}."
            drawings.append(
                replace(
                    drawing, title=_dotted(f"Figure {self.figures}", drawing.title), caption=caption
                )
            )
        for table in section.tables:
            self.tables += 1
            named = _dotted(f"Table {self.tables}", table.title or title)
            tables.append(replace(table, title=named))
        parts = []
        for part in section.parts:
            printed = part.printed or not self.on_paper
            if not printed and part.title:
                name = f"“{_COUNT.sub('', part.title)}” on the page"
                self.name_of.setdefault(anchor(part), name)
            next_figure = self.figures + 1
            counted = self.numbered(part, title, captions)
            parts += [counted] if printed else []
            if part.folded is None:
                for i, drawing in enumerate(part.drawings):
                    captions.setdefault(drawing.caption, next_figure + i)
        if section.title:
            name = f"Table {first}" if self.tables >= first else f"“{section.title}”"
            self.name_of.setdefault(anchor(section), name)
        holds = (
            _numbers("Table", first, self.tables),
            _numbers("Figure", first_figure, self.figures),
        )
        return replace(
            section,
            drawings=tuple(drawings),
            tables=tuple(tables),
            parts=tuple(parts),
            holds=", ".join(filter(None, holds)) if section.folded is not None else "",
        )

    def referred(self, section: Section) -> Section:
        return replace(
            section,
            paragraphs=tuple(map(self.resolved, section.paragraphs)),
            facts=tuple((name, self.resolved(text)) for name, text in section.facts),
            parts=tuple(map(self.referred, section.parts)),
        )

    def resolved(self, text: str) -> str:
        return _REFERENCE.sub(lambda found: self.name_of.get(found[1], found[0]), text)


def page(document: Document) -> str:
    """Return ``document`` as HTML. The browser runs the page's own script only, by its hash."""
    document = numbered(document)
    loader = _environment().loader
    assert loader is not None  # _environment gives one
    script = loader.get_source(_environment(), "page.js")[0]
    return (
        _environment()
        .get_template("document.html.j2")
        .render(
            document=document,
            menu=menu(document),
            unprinted=has_unprinted(document.sections),
            script=Markup(script),
            script_hash=b64encode(sha256(script.encode()).digest()).decode("ascii"),
            dark=DARK,
            version=version("hbench"),
        )
    )


def has_unprinted(sections: Iterable[Section]) -> bool:
    """Return whether some part of some sections is not printed."""
    return any(not each.printed or has_unprinted(each.parts) for each in sections)


def menu(document: Document) -> list[Section]:
    """Return the sections that the contents list: those with a title, of a long document."""
    titled = [section for section in document.sections if section.title]
    return titled if len(titled) >= _MENU else []


def beside(section: Section) -> str:
    """Return what the page shows beside a section's only figure: ``text``, ``all``, or nothing.

    Tables of many columns, and the facts about them, are below the figure.
    """
    only = len(section.drawings) == 1 and not section.drawings[0].wide
    text = bool(section.paragraphs or section.items)
    narrow = all(len(table.head) <= _NARROW for table in section.tables)
    if not only or not (text or narrow and (section.tables or section.facts)):
        return ""
    return "all" if narrow else "text"


def anchor(section: Section) -> str:
    """Return the name that links lead to."""
    return section.anchor or slug(section.title)


def slug(text: str) -> str:
    """Return words as a name for links."""
    return "-".join(re.findall(r"\w+", text.lower()))


@cache
def _environment() -> Environment:
    environment = Environment(loader=PackageLoader("hbench.report.render", ""), **ESCAPED)
    filters = {
        "anchor": anchor,
        "beside": beside,
        "slug": slug,
        "inline": inline,
        "csv_link": _csv_link,
        "called": _called,
        "numeric": numeric,
        "cell_classes": cell_classes,
        "head_classes": head_classes,
        "flag": lambda cell: cell.flag if isinstance(cell, Cell) else "",
        "sortable": lambda table: isinstance(table, Table) and table.sortable,
        "link": lambda cell: cell.link if isinstance(cell, Cell) else "",
        "plain": lambda cell: cell.text if isinstance(cell, Cell) else cell,
        "unit_kept": unit_kept,
        "subscripts": subscripts,
    }
    environment.filters.update(filters)
    return environment


def _csv_link(drawing: Drawing) -> str:
    """Return a figure's data as a link that holds it."""
    return "data:text/csv;charset=utf-8," + quote(drawing.csv, safe="!$()*+,-./:;=?@_~")


def _called(drawing: Drawing) -> str:
    """Return the name of a figure by its number, if it has one."""
    number = _FIGURE.match(drawing.title)
    return f"figure {number[1]}" if number else "this figure"
