"""The page of an identification."""

import math
import re
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
    ("Steady", "The reference has been constant for 0.3 s."),
    ("Rest", "The reference has been zero for 0.3 s; there friction is the force that holds the "
     "piston."),
    ("Unsteady", "All other samples."),
)  # fmt: skip
_SECTION = "Use one with hbench run --plant, or copy its section into a bench file."
_EQUALLY_GOOD = 1.05  # times the smallest error; the laws below are all named
_SCATTER = (
    "Trials' scatter",
    "Root mean square difference of the trials from their mean. A part of it comes from their "
    "initial states, which a simulation of the same trials reproduces.",
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
    read = (*_PARTS, _SCATTER) if identification.scatter else _PARTS
    tables = {table.title: _named(table) for table in identification_tables(identification)}
    drawings = tuple(drawings)
    steady = tuple(drawing for drawing in drawings if drawing.section == STEADY)
    overview = tuple(drawing for drawing in drawings if drawing.section == "errors")
    profiles = tuple(drawing for drawing in drawings if drawing not in (*steady, *overview))
    verified = [_once(tables[title]) for title in (ERRORS, HELD_OUT) if title in tables]
    parameters = _of_each_law(tables[PARAMETERS]) if PARAMETERS in tables else ()
    ramps = [replace(tables[RAMPS], title="")] if RAMPS in tables else []
    sections = (
        Section("Friction over speed", drawings=steady),
        Section("Identified parameters", (f"{plants}{_SECTION}",), tables=parameters),
        Section(
            "Verification",
            drawings=overview,
            tables=tuple(verified),
            facts=read if verified else (),
        ),
        Section(
            "Verification profile",
            parts=(
                Section(f"Figures of each law ({len(profiles)})", drawings=profiles, folded=True),
            )
            if profiles
            else (),
        ),
        Section("Steady runs and ramps", (_RAMPS,) if ramps else (), tables=tuple(ramps)),
        _remarks(identification),
    )
    return document(
        "Friction laws of the test cylinder",
        f"Campaign {provenance.name} of {provenance.started[:10]}; bench {provenance.bench}. "
        f"{_SOURCE}",
        tuple(
            section
            for section in sections
            if section.drawings or section.tables or section.items or section.facts or section.parts
        ),
        _verdict(identification),
        provenance.source,
    )


def _remarks(identification: Identification) -> Section:
    """Return the remarks on each law, and those on the runs and the model."""
    facts, items = [], []
    for sentence in (*reasons(identification), *identification.notes):
        law, colon, rest = in_words(sentence.strip()).partition(": ")
        if colon and law in FRICTION_LAWS:
            facts.append((law_words(law), _sentences(rest)))
        else:
            items.append(_sentences(f"{law_words(law)}{colon}{rest}"))
    return Section("Missing or uncertain results", items=tuple(items), facts=tuple(facts))


def _sentences(message: str) -> str:
    """Return the parts of a message, which semicolons separate, as sentences."""
    parts = re.sub(r"\b(extend|retract): (?=\w)", r"\1ing: ", message).split("; ")
    return " ".join(f"{_capital(part).rstrip('.')}." for part in parts)


def _capital(text: str) -> str:
    """Begin with a capital letter, except with a symbol such as ``n = 1``."""
    return text if text[1:2] == " " else f"{text[:1].upper()}{text[1:]}"


def _of_each_law(table: WordTable) -> tuple[WordTable, ...]:
    """Return a table for each law, without the columns that have no entry."""
    laws = dict.fromkeys(law for law, *_ in table.rows)
    return tuple(
        _without_empty(
            WordTable(name, table.head[1:], tuple(row[1:] for row in table.rows if row[0] == name))
        )
        for name in laws
    )


def _without_empty(table: WordTable) -> WordTable:
    """Return a table without the columns that have no entry."""
    kept = [i for i, cells in enumerate(zip(*table.rows, strict=True)) if any(cells)]
    rows = tuple(tuple(row[i] for i in kept) for row in table.rows)
    return replace(table, head=tuple(table.head[i] for i in kept), rows=rows)


def _once(table: WordTable) -> WordTable:
    """Return a table that has the name of a law in the first of its rows only."""
    names = [row[0] for row in table.rows]
    repeated = [name == before for before, name in zip(["", *names], names, strict=False)]
    rows = tuple(
        ("", *row[1:]) if same else row for same, row in zip(repeated, table.rows, strict=True)
    )
    return replace(table, rows=rows)


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
    """Name the laws with the smallest errors of friction over all parts of the runs."""
    errors = {
        law.law: _rms_n(tuple(law.errors.values())) for law in identification.laws if law.errors
    }
    if not errors:
        return ""
    least = min(errors.values())
    best = [law_words(law) for law, error in errors.items() if error <= _EQUALLY_GOOD * least]
    alone = len(best) == 1
    verb, size = ("predicts", "RMS error") if alone else ("predict", "RMS errors within 5 % of")
    text = f"{' and '.join(best)} {verb} friction best: {size} {significant(least, 2)} N"
    scatter = identification.scatter and _rms_n(tuple(identification.scatter.values()))
    more = f", where the trials scatter by {significant(scatter, 2)} N" if scatter else ""
    return f"{text}{more}. "


def _rms_n(parts: tuple[ModelErrors, ...]) -> float:
    sampled = [part for part in parts if part.samples]
    squares = sum(part.samples * part.friction_n**2 for part in sampled)
    return math.sqrt(squares / sum(part.samples for part in sampled)) if sampled else math.inf
