"""The page of an identification."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from hbench.records import Identification, WordTable
from hbench.records.friction_laws import FRICTION_LAWS
from hbench.records.identification import MEMORY_M
from hbench.report.campaign.fit_tables import in_words, law_words
from hbench.report.campaign.sections.settings import provenance_facts
from hbench.report.identification.figures import STEADY
from hbench.report.identification.misfit_words import MISFIT, MISFIT_FACT
from hbench.report.identification.ranking import best_law, ranked_laws
from hbench.report.identification.remarks import interval_words, left_out_words, oscillation_words
from hbench.report.identification.text import (
    ERRORS,
    HELD_OUT,
    PARAMETERS,
    RAMPS,
    SUMMARY,
    error_range,
    identification_tables,
    reasons,
    scatter_words,
    with_law_names,
)
from hbench.report.identification.verdict import verdict_words
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing, of_section
from hbench.report.render.numbers import alike
from hbench.report.render.word_tables import with_columns
from hbench.sentences import counted

_SOURCE = (
    "Laws and verification profile",
    "M. Hvoldal and C. Olesen, Friction Modelling and Parameter Estimation for Hydraulic "
    "Asymmetrical Cylinders, Aalborg University, 2011: equations 3.1 to 3.20, section 5.5.",
)
_SUMMARY = (
    ("RMS error", "Root mean square of simulated less measured friction over the verification "
     "runs, which were not used for the identification. Each law was simulated in a model of the "
     "bench, with the firmware in closed loop. At rest, friction is the force that holds the "
     "piston, which laws of speed and pressure alone do not determine."),
    ("Start", f"The first {1e3 * MEMORY_M:.0f} mm of each run are not counted, as in the fits: "
     "there friction depends on how the piston came to rest before the log began."),
)  # fmt: skip
_DETERMINED = (
    ("Not determined", "The value is at a bound of the fit, or the half-width of its 95 % interval "
     "exceeds the value, or a bound cuts the interval off. Intervals below a tenth of the "
     "parameter's typical size do not count. Other parameters may take its place."),
    ("Hardly determined", "The 95 % interval contains 0, or its half-width exceeds half of the "
     "value."),
)  # fmt: skip
_HELD_OUT = ("RMS error of friction", "Along the motion of runs left out of the fits.")
_PARTS = (
    ("Steady", "The reference has been constant for 0.3 s. It is oscillating where simulated "
     "friction has more than three times the standard deviation of the measured one, else smooth."),
    ("Rest", "The reference has been zero for 0.3 s."),
    ("Unsteady", "All other samples."),
)  # fmt: skip
_RANKED = "RMS error of friction, poorly determined parameters and plant file of each law"
_STEADY = (
    "Titles state the load and the pressure on the rod side of the load cylinder. Tustin is one "
    "curve for all loads and directions. Marton and Lantos is two tangents of such a curve, as in "
    "the source; near the switch velocity v_SW, where they meet, they lie far below the points: do "
    "not use this plant file there. The other laws depend on the chamber pressures."
)
_IN_NUMBERS = "Errors in numbers"
_RAMP_ERRORS = "RMS errors of both Tustin laws"
_SECTION = (
    "Each law is a plant file beside this page. Use one with hbench run --plant, or copy its "
    "section into a bench file."
)
_DIRECTION = re.compile(r"(?:^|; )(extend|retract): (?=\w)")  # before the remarks on it
_SCATTER = "Root mean square difference of the trials from their mean: {sizes}."
_RAMPS = (
    "Friction during a ramp can differ from that of steady runs. One Tustin law is fitted to the "
    "steady runs of a load and direction, and another to a ramp from breakaway on. During ramps "
    "the steady law has an RMS error of {errors} N, at steady speeds one of {steady} N."
)


def identification_page(identification: Identification, drawings: Iterable[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    provenance = identification.provenance
    tables = {table.title: with_law_names(table) for table in identification_tables(identification)}
    summary = (replace(tables[SUMMARY], title=_RANKED),) if SUMMARY in tables else ()
    with_errors = any(law.errors for law in identification.laws)
    facts: tuple[tuple[str, str], ...] = (_HELD_OUT, *_DETERMINED)
    facts = (*_SUMMARY, *_DETERMINED) if with_errors else facts
    if identification.scatter:
        facts += (("Trials' scatter", _SCATTER.format(sizes=scatter_words(identification))),)
    facts += _about_errors(identification)
    drawings = tuple(drawings)
    steady = of_section(drawings, STEADY)
    overview = of_section(drawings, "errors")
    profiles = tuple(drawing for drawing in drawings if drawing not in (*steady, *overview))
    best = best_law(identification)
    shown = of_section(profiles, best)
    others = tuple(drawing for drawing in profiles if drawing.section != best)
    verified = [_once(tables[title]) for title in (ERRORS, HELD_OUT) if title in tables]
    ranked = sorted(ranked_laws(identification), key=lambda law: law.law != best)
    order = [law_words(law.law) for law in ranked]  # the one to be used is not folded
    parameters = _of_each_law(tables[PARAMETERS], order) if PARAMETERS in tables else ()
    misfits = tuple(tables[title] for title in (MISFIT,) if title in tables)
    ramps = [replace(tables[RAMPS], title=_RAMP_ERRORS)] if RAMPS in tables else []
    terms = Section("Criteria for the errors and the parameters", facts=facts, folded=True)
    named = f"The other laws over the profile ({len(others)})"
    rest = (Section(named, drawings=others, folded=True, printed=False),)
    sections = (
        Section(SUMMARY, tables=summary, parts=(terms,)) if summary else Section(),
        Section("Verification profile", drawings=shown, parts=rest if others else ()),
        Section("Friction over speed", (_STEADY,) if steady else (), drawings=steady),
        Section("Misfit of the laws", tables=misfits, facts=(MISFIT_FACT,) if misfits else ()),
        Section(
            "Identified parameters",
            (_SECTION, interval_words(identification)),
            tables=parameters[:1],
            parts=_folded(f"Parameters of the other laws ({len(parameters) - 1})", parameters[1:]),
        ),
        Section(
            "Errors by law",
            drawings=overview,
            facts=_PARTS if verified else (),
            parts=_folded(_IN_NUMBERS, verified),
        ),
        Section(
            "Steady runs and ramps", _ramp_words(identification), parts=_folded("Errors", ramps)
        ),
        _remarks(identification),
    )
    return document(
        "Friction laws of the test cylinder",
        "Identified from measured runs, and verified on others",
        tuple(
            section
            for section in sections
            if section.drawings or section.tables or section.items or section.facts or section.parts
        ),
        verdict_words(identification),
        provenance.source,
        _identity(identification),
    )


def _identity(identification: Identification) -> tuple[tuple[str, str], ...]:
    """Return what was measured, where and when, and of which runs the laws are."""
    used = {run for law in identification.laws for run in law.runs}
    verified = len(identification.verification_runs)
    left_out = len(identification.left_out)
    runs = f"laws from {counted(len(used), 'run')}, verified on {counted(verified, 'other')}"
    runs += f"; {left_out} not used" if left_out else ""
    return (
        ("Campaign", identification.provenance.name),
        *provenance_facts(identification.provenance),
        ("Runs", runs),
    )


def _folded(title: str, tables: Sequence[WordTable]) -> tuple[Section, ...]:
    """Return a folded part; identification.json contains its numbers too."""
    known = tuple(tables)
    return (Section(title, tables=known, folded=True, printed=False),) if known else ()


def _about_errors(identification: Identification) -> tuple[tuple[str, str], ...]:
    """Return the errors of dynamic laws and of the others, and those of oscillations."""
    verified = [law for law in ranked_laws(identification) if law.errors]
    kinds = [
        [law for law in verified if FRICTION_LAWS[law.law].dynamic is dynamic]
        for dynamic in (True, False)
    ]
    words = oscillation_words(identification)
    oscillations = (("At constant speed", words),) if words else ()
    if not all(kinds):
        return oscillations
    unsteady = [error_range([law.errors["unsteady"].friction_n for law in laws]) for laws in kinds]
    names = [", ".join(law_words(law.law) for law in laws) for laws in kinds]
    words = (
        f"Dynamic laws ({names[0]}) contain the deflection of the seals before they slide; static "
        f"laws ({names[1]}) depend on speed and pressure alone. RMS errors while the speed "
        f"changes: {unsteady[0]} N against {unsteady[1]} N."
    )
    return (*oscillations, ("Kinds of laws", words))


def _ramp_words(identification: Identification) -> tuple[str, ...]:
    """Return what the ramps' table is of, and how well the steady law predicts ramps."""
    errors = [ramp.steady_on_ramp_n for ramp in identification.ramps]
    steady = [ramp.steady_on_steady_n for ramp in identification.ramps]
    return (_RAMPS.format(errors=alike(errors), steady=error_range(steady)),) if errors else ()


def _remarks(identification: Identification) -> Section:
    """Return the remarks on each law, and those on the runs and the model."""
    facts, items = [], []
    left_out = " ".join(map(_sentences, left_out_words(identification)))
    for sentence in (*reasons(identification), *identification.notes):
        law, colon, rest = in_words(sentence.strip()).partition(": ")
        if colon and law in FRICTION_LAWS:
            facts += _by_direction(law_words(law), rest)
        else:
            items.append(_sentences(f"{law_words(law)}{colon}{rest}"))
    title = "Remarks and source"
    if left_out:
        facts.append(("Runs not used", in_words(left_out)))
    return Section(title, items=tuple(items), facts=(*facts, _SOURCE), folded=True)


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


def _of_each_law(table: WordTable, order: Sequence[str]) -> tuple[WordTable, ...]:
    """Return a table for each law: values with their units, and remarks where there are any."""
    known = {law for law, *_ in table.rows}
    laws = [law for law in order if law in known]
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
    return with_columns(table, kept)


def _once(table: WordTable) -> WordTable:
    """Return a table that has the name of a law in the first of its rows only."""
    names = [row[0] for row in table.rows]
    repeated = [name == before for before, name in zip(["", *names], names, strict=False)]
    rows = tuple(
        ("", *row[1:]) if same else row for same, row in zip(repeated, table.rows, strict=True)
    )
    return replace(table, rows=rows)
