"""The page of an identification."""

import re
from collections.abc import Iterable
from dataclasses import replace

from hbench.records import Identification, WordTable
from hbench.records.friction_laws import FRICTION_LAWS
from hbench.report.campaign.fit_tables import in_words, law_words
from hbench.report.identification.figures import STEADY
from hbench.report.identification.text import (
    ERRORS,
    HELD_OUT,
    PARAMETERS,
    RAMPS,
    SUMMARY,
    identification_tables,
    reasons,
    rms_n,
)
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import alike, significant

_SOURCE = (
    "Laws and verification profile",
    "M. Hvoldal and C. Olesen, Friction Modelling and Parameter Estimation for Hydraulic "
    "Asymmetrical Cylinders, Aalborg University, 2011: equations 3.1 to 3.20, section 5.5.",
)
_SUMMARY = (
    ("RMS error of friction", "Over all samples of the verification runs; the section "
     "Verification has the errors of each part of the runs."),
    ("Not determined", "The 95 % interval is wider than the value and than a tenth of its typical "
     "size, or the value is at a bound of the fit. Other parameters may take its place."),
)  # fmt: skip
_HELD_OUT = ("RMS error of friction", "Along the motion of runs left out of the fits.")
_PARTS = (
    ("Steady", "The reference has been constant for 0.3 s."),
    ("Rest", "The reference has been zero for 0.3 s; there friction is the force that holds the "
     "piston. Laws of speed and pressure alone (Tustin, Marton and Lantos, pressure-based) do not "
     "determine it."),
    ("Unsteady", "All other samples."),
)  # fmt: skip
_RANKED = "RMS error, undetermined parameters and plant file of each law"
_RAMP_ERRORS = "RMS errors of both Tustin laws"
_SECTION = (
    "Each law is a plant file beside this page. Use one with hbench run --plant, or copy its "
    "section into a bench file."
)
_DIRECTION = re.compile(r"(?:^|; )(extend|retract): (?=\w)")  # before the remarks on it
_EQUALLY_GOOD = 1.05  # times the smallest error; the laws below are all named
_SCATTER = (
    "Trials' scatter",
    "Root mean square difference of the trials from their mean. A part of it comes from their "
    "initial states, which a simulation of the same trials reproduces.",
)
_RAMPS = (
    "Friction during a ramp can differ from that of steady runs. One Tustin law is fitted to the "
    "steady runs of a load and direction, and another to a ramp from breakaway on. During ramps "
    "the steady law has an RMS error of {errors} N."
)


def identification_page(identification: Identification, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    provenance = identification.provenance
    read = (*_PARTS, _SCATTER) if identification.scatter else _PARTS
    tables = {table.title: _named(table) for table in identification_tables(identification)}
    summary = (replace(tables[SUMMARY], title=_RANKED),) if SUMMARY in tables else ()
    with_errors = any(law.errors for law in identification.laws)
    facts = _SUMMARY if with_errors else (_HELD_OUT, *_SUMMARY[1:])
    drawings = tuple(drawings)
    steady = tuple(drawing for drawing in drawings if drawing.section == STEADY)
    overview = tuple(drawing for drawing in drawings if drawing.section == "errors")
    profiles = tuple(drawing for drawing in drawings if drawing not in (*steady, *overview))
    best = _best(identification)
    shown = tuple(drawing for drawing in profiles if drawing.section == best)
    others = tuple(drawing for drawing in profiles if drawing.section != best)
    verified = [_once(tables[title]) for title in (ERRORS, HELD_OUT) if title in tables]
    parameters = _of_each_law(tables[PARAMETERS]) if PARAMETERS in tables else ()
    ramps = [replace(tables[RAMPS], title=_RAMP_ERRORS)] if RAMPS in tables else []
    sections = (
        Section(SUMMARY, tables=summary, facts=facts if summary else ()),
        Section("Friction over speed", drawings=steady),
        Section("Identified parameters", (_SECTION,), tables=parameters),
        Section(
            "Verification",
            drawings=overview,
            tables=tuple(verified),
            facts=read if verified else (),
        ),
        Section(
            "Verification profile",
            drawings=shown,
            parts=(Section(f"Other laws ({len(others)})", drawings=others, folded=True),)
            if others
            else (),
        ),
        Section("Steady runs and ramps", _ramp_words(identification), tables=tuple(ramps)),
        _remarks(identification),
    )
    return document(
        "Friction laws of the test cylinder",
        f"Campaign {provenance.name} of {provenance.started[:10]}; bench {provenance.bench}.",
        tuple(
            section
            for section in sections
            if section.drawings or section.tables or section.items or section.facts or section.parts
        ),
        _verdict(identification),
        provenance.source,
    )


def _ramp_words(identification: Identification) -> tuple[str, ...]:
    """Return what the ramps' table is of, and how well the steady law predicts ramps."""
    errors = [ramp.steady_on_ramp_n for ramp in identification.ramps]
    return (_RAMPS.format(errors=alike(errors)),) if errors else ()


def _remarks(identification: Identification) -> Section:
    """Return the remarks on each law, and those on the runs and the model."""
    facts, items = [], []
    left_out = " ".join(_sentences(f"run {line}") for line in identification.left_out)
    for sentence in (*reasons(identification), *identification.notes):
        law, colon, rest = in_words(sentence.strip()).partition(": ")
        if colon and law in FRICTION_LAWS:
            facts += _by_direction(law_words(law), rest)
        else:
            items.append(_sentences(f"{law_words(law)}{colon}{rest}"))
    title = "Missing or uncertain results, and source"
    if left_out:
        facts.append(("Runs left out", in_words(left_out)))
    return Section(title, items=tuple(items), facts=(*facts, _SOURCE))


def _by_direction(law: str, message: str) -> list[tuple[str, str]]:
    """Return the remarks on a law, those of each direction for themselves."""
    common, *rest = _DIRECTION.split(message)
    remarks = [(law, common)] if common else []
    sides = zip(rest[::2], rest[1::2], strict=True)
    remarks += [(f"{law}, {side}ing", text) for side, text in sides]
    return [(name, _sentences(text)) for name, text in remarks]


def _sentences(message: str) -> str:
    """Return the parts of a message, which semicolons separate, as sentences."""
    parts = re.sub(r"\b(extend|retract): (?=\w)", r"\1ing: ", message).split("; ")
    return " ".join(f"{_capital(part).rstrip('.')}." for part in parts)


def _capital(text: str) -> str:
    """Begin with a capital letter, except with a symbol such as ``n = 1``."""
    return text if text[1:2] == " " else f"{text[:1].upper()}{text[1:]}"


def _of_each_law(table: WordTable) -> tuple[WordTable, ...]:
    """Return a table for each law: values with their units, and remarks where there are any."""
    laws = dict.fromkeys(law for law, *_ in table.rows)
    _, parameter, value, _, remark = table.head
    return tuple(
        _without_empty(
            WordTable(
                f"{name}: identified parameters",
                (parameter, value, remark),
                tuple(
                    (words, f"{number} {unit}".strip(), *remarks)
                    for law, words, number, unit, *remarks in table.rows
                    if law == name
                ),
            )
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
        f"firmware in closed loop, over {count} verification runs, which were not "
        f"used for the identification.{_next_step(identification)}"
    ).strip()


def _closest(identification: Identification) -> str:
    """Name the laws with the smallest errors of friction over all parts of the runs."""
    errors = _errors(identification)
    if not errors:
        return ""
    least = min(errors.values())
    best = {law: error for law, error in errors.items() if error <= _EQUALLY_GOOD * least}
    names = [f"{law_words(law)} ({significant(error, 2)} N)" for law, error in best.items()]
    verb = "predicts" if len(best) == 1 else "predict"
    scatter = identification.scatter and rms_n(identification.scatter.values())
    more = f"; the trials scatter by {significant(scatter, 2)} N" if scatter else ""
    return f"{' and '.join(names)} {verb} friction best by RMS error{more}. "


def _next_step(identification: Identification) -> str:
    """Return how to use the law with the smallest error; empty if none was verified."""
    best = _best(identification)
    return f" Next step: simulate with hbench run --plant {best}.yaml." if best else ""


def _best(identification: Identification) -> str:
    """Return the law with the smallest error; empty if none was verified."""
    errors = _errors(identification)
    return min(errors, key=errors.__getitem__, default="")


def _errors(identification: Identification) -> dict[str, float]:
    """Return the error of friction of each verified law, over all parts of the runs."""
    return {law.law: rms_n(law.errors.values()) for law in identification.laws if law.errors}
