"""The page of an identification."""

import math
from collections.abc import Iterable
from dataclasses import replace

from hbench.records import Identification, ModelErrors, WordTable
from hbench.report.campaign.fit_tables import law_words
from hbench.report.identification.text import identification_tables, reasons
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import significant

_SOURCE = (
    "Equation and section numbers: M. Hvoldal and C. Olesen, Friction Modelling and Parameter "
    "Estimation for Hydraulic Asymmetrical Cylinders, Aalborg University, 2011."
)
_PARTS = (
    "Steady: the reference has been constant for 0.3 s. Rest: the reference has been zero for 0.3 "
    "s; there friction is the force that holds the piston."
)
_SCATTER = (
    "The trials' scatter is their rms difference from their mean. A part of it comes from their "
    "initial states, which a simulation of the same trials reproduces."
)
_RAMPS = (
    "In the source, friction of ramps and of steady runs differs (section 6.2). The last table has "
    "the error of each fit on its own data and on the other's."
)


def identification_page(identification: Identification, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    provenance = identification.provenance
    files = ", ".join(f"{law.law}.yaml" for law in identification.laws if law.fit is not None)
    plants = f"As plant files beside this page: {files}. Give one to hbench run --plant, or put "
    read = (
        [_PARTS, _SCATTER]
        if identification.scatter
        else []
        if identification.not_verified
        else [_PARTS]
    )
    read += [_RAMPS] if identification.ramps else []
    paragraphs = (*read, *identification.notes, f"{plants}its section into a bench file.")
    laws = Section(
        paragraphs=paragraphs,
        tables=tuple(map(_named, identification_tables(identification))),
    )
    missing = Section("Missing or uncertain results", items=reasons(identification))
    figures = Section("Verification profile", drawings=tuple(drawings))
    return document(
        "Friction laws of the test cylinder",
        f"Campaign {provenance.name}, {provenance.source}, {provenance.started}; "
        f"bench {provenance.bench}. {_SOURCE}",
        tuple(
            section
            for section in (laws, missing, figures)
            if section is not figures or figures.drawings
        ),
        _verdict(identification),
        provenance.source,
    )


def _named(table: WordTable) -> WordTable:
    """Return a table with the laws' names in place of their keys."""
    rows = tuple((law_words(first), *rest) for first, *rest in table.rows)
    return replace(table, rows=rows)


def _verdict(identification: Identification) -> str:
    if identification.not_verified:
        return f"{identification.not_verified[0].upper()}{identification.not_verified[1:]}."
    return (
        "Each law, in a model of the bench with the firmware in closed loop, followed the profile "
        f"of the {len(identification.verification_runs)} verification runs (section 5.5), which "
        f"took no part in the identification.{_closest(identification)}"
    )


def _closest(identification: Identification) -> str:
    """Name the law with the smallest error of friction over all parts of the runs."""
    errors = {
        law.law: _rms_n(tuple(law.errors.values())) for law in identification.laws if law.errors
    }
    if not errors:
        return ""
    best = min(errors, key=errors.__getitem__)
    text = f" Closest in friction: {law_words(best)}, {significant(errors[best], 2)} N rms"
    scatter = identification.scatter and _rms_n(tuple(identification.scatter.values()))
    return text + (f"; the trials scatter by {significant(scatter, 2)} N." if scatter else ".")


def _rms_n(parts: tuple[ModelErrors, ...]) -> float:
    sampled = [part for part in parts if part.samples]
    squares = sum(part.samples * part.friction_n**2 for part in sampled)
    return math.sqrt(squares / sum(part.samples for part in sampled)) if sampled else math.inf
