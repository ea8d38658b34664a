"""The page of an identification."""

import math
from collections.abc import Iterable
from dataclasses import replace

from hbench.records import Identification, ModelErrors, WordTable
from hbench.records.friction_laws import FRICTION_LAWS
from hbench.report.campaign.fit_tables import in_words, law_words
from hbench.report.identification.figures import STEADY
from hbench.report.identification.text import (
    ERRORS,
    HELD_OUT,
    PARAMETERS,
    RAMPS,
    identification_tables,
    reasons,
)
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
_SECTION = "Use one with hbench run --plant, or copy its section into a bench file."
_SCATTER = (
    "The trials' scatter is their rms difference from their mean. A part of it comes from their "
    "initial states, which a simulation of the same trials reproduces."
)
_RAMPS = (
    "In the source, friction of ramps and of steady runs differs (section 6.2). The table has the "
    "RMS error of each Tustin fit from breakaway on, on its own data and on the other's."
)


def identification_page(identification: Identification, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    provenance = identification.provenance
    files = ", ".join(f"{law.law}.yaml" for law in identification.laws if law.fit is not None)
    plants = f"Each law is a plant file beside this page: {files}. "
    read = (
        [_PARTS, _SCATTER]
        if identification.scatter
        else []
        if identification.not_verified
        else [_PARTS]
    )
    tables = {table.title: _named(table) for table in identification_tables(identification)}
    drawings = tuple(drawings)
    steady = tuple(drawing for drawing in drawings if drawing.section == STEADY)
    overview = tuple(drawing for drawing in drawings if drawing.section == "errors")
    profiles = tuple(drawing for drawing in drawings if drawing not in (*steady, *overview))
    verified = [tables[title] for title in (ERRORS, HELD_OUT) if title in tables]
    parameters = [_without_empty(tables[PARAMETERS])] if PARAMETERS in tables else []
    ramps = [replace(tables[RAMPS], title="")] if RAMPS in tables else []
    sections = (
        Section("Friction over speed", drawings=steady),
        Section("Identified parameters", (f"{plants}{_SECTION}",), tables=tuple(parameters)),
        Section("Verification", tuple(read), drawings=overview, tables=tuple(verified)),
        Section(
            "Verification profile",
            parts=(
                Section(f"Figures of each law ({len(profiles)})", drawings=profiles, folded=True),
            )
            if profiles
            else (),
        ),
        Section("Steady runs and ramps", (_RAMPS,) if ramps else (), tables=tuple(ramps)),
        Section(
            "Missing or uncertain results",
            items=tuple(map(_worded, (*reasons(identification), *identification.notes))),
        ),
    )
    return document(
        "Friction laws of the test cylinder",
        f"Campaign {provenance.name} of {provenance.started[:10]}; bench {provenance.bench}. "
        f"{_SOURCE}",
        tuple(
            section
            for section in sections
            if section.drawings or section.tables or section.items or section.parts
        ),
        _verdict(identification),
        provenance.source,
    )


def _folded(profiles: tuple[Drawing, ...]) -> tuple[Section, ...]:
    if not profiles:
        return ()
    title = f"Measurement and model of each law over time ({len(profiles)} figures)"
    return (Section(title, drawings=profiles, folded=True),)


def _worded(sentence: str) -> str:
    """Return a sentence with titles in place of the names of laws and parameters."""
    law, colon, rest = in_words(sentence.strip()).partition(":")
    name = law_words(law) if law in FRICTION_LAWS else law
    return f"{name[:1].upper()}{name[1:]}{colon}{rest}"


def _without_empty(table: WordTable) -> WordTable:
    """Return a table without title and without the columns that have no entry."""
    kept = [i for i, cells in enumerate(zip(*table.rows, strict=True)) if any(cells)]
    rows = tuple(tuple(row[i] for i in kept) for row in table.rows)
    return WordTable("", tuple(table.head[i] for i in kept), rows)


def _named(table: WordTable) -> WordTable:
    """Return a table with the laws' names in place of their keys."""
    rows = tuple((law_words(first), *rest) for first, *rest in table.rows)
    return replace(table, rows=rows)


def _verdict(identification: Identification) -> str:
    if identification.not_verified:
        return f"{identification.not_verified[0].upper()}{identification.not_verified[1:]}."
    count = len(identification.verification_runs)
    return (
        f"{_closest(identification)}Each law was simulated in a model of the bench, with the "
        f"firmware in closed loop, over {count} verification runs (section 5.5), which were not "
        "used for the identification."
    ).strip()


def _closest(identification: Identification) -> str:
    """Name the law with the smallest error of friction over all parts of the runs."""
    errors = {
        law.law: _rms_n(tuple(law.errors.values())) for law in identification.laws if law.errors
    }
    if not errors:
        return ""
    best = min(errors, key=errors.__getitem__)
    text = f"{law_words(best)} predicts friction best: RMS error {significant(errors[best], 2)} N"
    scatter = identification.scatter and _rms_n(tuple(identification.scatter.values()))
    more = f", where the trials scatter by {significant(scatter, 2)} N" if scatter else ""
    return f"{text}{more}. "


def _rms_n(parts: tuple[ModelErrors, ...]) -> float:
    sampled = [part for part in parts if part.samples]
    squares = sum(part.samples * part.friction_n**2 for part in sampled)
    return math.sqrt(squares / sum(part.samples for part in sampled)) if sampled else math.inf
