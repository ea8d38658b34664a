"""Parts of a certificate: facts, tables, paragraphs, and numbers in its language."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace

from hbench.records.conformity.acceptance import Measurement, Requirement
from hbench.report.conformity.certificate.certificate import Certificate
from hbench.report.render.numbers import NONE, short, unbroken
from hbench.units import from_si

_UNIT = re.compile(r"(\d) (mm/s|mm²|N/s|N|bar|%|°C|s|ml/min)(?![\w/])")

Fact = tuple[str, str]  # name and text


@dataclass(frozen=True)
class GridTable:
    """Table of a certificate; the columns ``numbers`` are aligned to the right.

    The rows ``emphasised`` are bold.
    """

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numbers: frozenset[int] = frozenset()
    emphasised: frozenset[int] = frozenset()


@dataclass(frozen=True)
class Part:
    """Part of a certificate; ``key`` names it for templates."""

    key: str
    title: str
    facts: tuple[Fact, ...] = ()
    tables: tuple[GridTable, ...] = ()
    paragraphs: tuple[str, ...] = ()
    verdict: str = ""  # the decision in large letters, first of all
    reserve: str = ""  # what the decision rests on, in bold
    lead: str = ""  # before the rest


@dataclass(frozen=True)
class Content:
    """All that a certificate shows.

    ``rows`` holds the parts. Of several in a row the first is on the left, the others on the right.
    """

    language: str
    title: str
    number_label: str
    number: str
    page_label: str
    of_label: str
    mark: str  # on every page of a document that certifies nothing; empty: none
    mark_text: str  # the same in full
    head_facts: tuple[Fact, ...]
    rows: tuple[tuple[Part, ...], ...]
    signature_title: str
    signatories: tuple[tuple[str, str], ...]  # name and role
    signature_label: str
    end: str

    @property
    def parts(self) -> dict[str, Part]:
        """The parts by their keys."""
        return {part.key: part for row in self.rows for part in row}


def localized(certificate: Certificate, text: str) -> str:
    """Return a number's text with the decimal sign of the certificate's language."""
    return text.replace(".", ",") if certificate.file.language == "de" else text


def series_words(
    certificate: Certificate, series: Measurement | Requirement, load: bool, back_pressure: bool
) -> str:
    """Write label and direction of a series, and its load and back pressure where asked for."""
    word = certificate.word
    words = [
        certificate.named(series.label or ""),
        word(series.direction) if series.direction else "",
    ]
    if load and series.f_load_n is not None:
        words.append(word("of_load", load=localized(certificate, short(series.f_load_n))))
    if back_pressure and series.p_lr_ref_pa is not None:
        bar = short(from_si(series.p_lr_ref_pa, "bar"))
        words.append(word("at_back_pressure", pressure=localized(certificate, bar)))
    return ", ".join(filter(None, words))


def on_a_line(text: str, longest: int) -> str:
    """Return a text so that it is not broken over lines if it has up to ``longest`` letters."""
    return text if len(text) > longest else unbroken(text)


def with_joined_units(part: Part) -> Part:
    """Return a part whose numbers stay on the line of their units."""

    def join(text: str) -> str:
        return _UNIT.sub("\\1\u00a0\\2", text)

    tables = (
        replace(table, rows=tuple(tuple(map(join, row)) for row in table.rows))
        for table in part.tables
    )
    return replace(
        part,
        facts=tuple((name, join(text)) for name, text in part.facts),
        tables=tuple(tables),
        paragraphs=tuple(map(join, part.paragraphs)),
    )


def stated_facts(
    certificate: Certificate, pairs: Iterable[tuple[str, str, bool]]
) -> tuple[Fact, ...]:
    """Return facts of words' keys and texts; empty ones only if they are required."""
    return tuple(
        (certificate.word(key), text or certificate.word("not_stated"))
        for key, text, required in pairs
        if text or required
    )


def without_empty(table: GridTable) -> GridTable:
    """Return the table without columns that have no text in any row."""
    kept = [
        i for i in range(len(table.head)) if any(row[i] not in ("", NONE) for row in table.rows)
    ]
    return GridTable(
        tuple(table.head[i] for i in kept),
        tuple(tuple(row[i] for i in kept) for row in table.rows),
        frozenset(new for new, old in enumerate(kept) if old in table.numbers),
        table.emphasised,
    )
