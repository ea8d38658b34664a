"""The page of a diagnosis."""

import re
from collections.abc import Sequence
from dataclasses import replace

from hbench.records import Diagnosis, Gap, WordTable
from hbench.records.diagnosis import LEAST_EXPLAINED, LEAST_SIZE
from hbench.records.summary import SIGNIFICANCE
from hbench.report.diagnosis import text as text
from hbench.report.diagnosis.change_words import (
    candidates_table,
    changes_tables,
    lookalikes_tables,
    wrong_readings,
)
from hbench.report.diagnosis.names import (
    BALANCE_NAMES,
    SIGNAL_NAMES,
    deviation_and_limit,
    in_sentence,
    in_words,
    p_equation,
    value_words,
)
from hbench.report.diagnosis.run_gaps import run_table
from hbench.report.diagnosis.sentences import (
    deviations,
    gap_change,
    largest_deviation,
    title,
    undetectable,
)
from hbench.report.diagnosis.separability_tables import MATRIX_TEXT, matrix_table
from hbench.report.diagnosis.summary import answers, next_step
from hbench.report.render.document import Section, document
from hbench.report.render.figures import Drawing
from hbench.report.render.numbers import number
from hbench.report.render.symbols import listed

_MOST_RUNS = 40  # rows of the page
_KEY = re.compile(r"\b[a-z]+(?:_[a-z]+)+\b")  # name of an effect
_SENSOR = (
    "An effect of a sensor is an error of the measurement, not of the bench. Correct the "
    "instrument rather than the model."
)
_CHANGES = (
    ("At the working point", "The measured operating point that is nearest to the median speed, "
     "load and pressures, in steady motion. The 95 % interval is that of the effect's "
     "coefficients."),
    ("Along the logs", "Over all measured motion, in windows of 0.16 s: the root mean square, and "
     "the value that 5 % of the windows exceed."),
    ("Signs", "A flow is positive into its chamber, friction against the motion. The speed changes "
     "at the same commands and pressures; the pressure, which is that of the fed chamber, at the "
     "same speed and load."),
)  # fmt: skip
_COMPUTED = (
    "Error of an instrument",
    "It changes the readings, and the friction and the flows that are computed from them. At the "
    "bench nothing is different.",
)
_GAP = (
    "Root mean square of measurement less model, in units of the scatter of repeated trials. 1 is "
    "the repeatability of the bench. Gaps below 0.3 are drawn at 0.3."
)
_BALANCES = (
    "Laws that the measured signals must obey: the oil that flows into each of the four chambers, "
    "the forces of either cylinder, position against velocity, and the supply. They are evaluated "
    "along the measured logs, and they decide."
)
_SIGNALS = (
    "The same schedule, simulated in closed loop and in open loop. They check the revised model; "
    "the verdict does not depend on them, and no expected gap is computed for them."
)
_REFITTED_STAGE = "The model with its poorly known values fitted, and no effect added."
_REFUSED = "Any increase refuses it. Everything is compared with the model as given{fitted}."
_FITTED_WITH = "; the values of model.yaml are those fitted together with the {added}"
_EXPECTED = (
    "Gap that a correct model has on average, because its fitted values are uncertain. It is no "
    "lower limit: a fit can come closer."
)
_RUNS = (
    "The gap of a single run includes its own scatter and is 1 for a correct model. The last "
    "columns show the worst balance and signals of the run, at the last step. gaps_by_run.csv "
    "beside this page contains every run and signal."
)
_WHERE = (
    ("All runs", "The gaps and deviations of this section are of all runs, those of the section on "
     "the gap of the held-out runs alone."),
    ("Structured", "Part of the gap beyond the repeatability of the trials: √(gap² − 1)."),
    ("p (Holm)", "Probability of such a gap for a correct model, corrected after Holm for the "
     "number of balances."),
    ("Deviation", "Root mean square of the residual in the unit of the balance, without the noise "
     "of single windows, but with the scatter from trial to trial. Below the next column it does "
     "not matter."),
    ("Tolerances allow", "Deviation that sensors within their tolerances may cause in a model that "
     "is not refitted."),
    ("Metering edge", "Edge of the valve's spool that connects the chamber with the supply or the "
     "tank. Where one gap is much larger, inspect that edge."),
)  # fmt: skip
_WHICH = (
    ("Score", "Gain of log-likelihood in nats (natural logarithm) by cross-validation: each fifth "
     "of the operating points of the fit is predicted from the others. It also counts changes from "
     "window to window, as at a step or after a reversal, which a gap hardly shows."),
    ("Explains", "Share of the excess gap that the effect removes there, in the balances that it "
     "touches alone. A candidate can have a large share and a score near 0: the score "
     "counts all balances and the uncertainty of the fit, and the refitted values of the model "
     "predict these points as well without the effect."),
    ("Size", "Its largest coefficient relative to a typical one."),
    ("Named", "An effect whose score exceeds the limit beside it in the table, that explains more "
     f"than {100 * LEAST_EXPLAINED:g} %, and whose size is at least {LEAST_SIZE:g} of a typical "
     "one."),
)  # fmt: skip
_POORLY_KNOWN = (
    "Poorly known values of the model file are levels of friction, a valve's gain, dead volumes "
    "and the like"
)
_REFITTED = (
    f"{_POORLY_KNOWN}. They are fitted first, so that their errors do not appear as effects."
)
_NUMBERS = (
    "diagnosis.json and gaps_by_run.csv contain all numbers, also those of folded tables, which "
    "are not printed. The folder figures has each figure as SVG, PNG and CSV."
)
_NEXT_FILE = "next.yaml is the schedule that is proposed above."


def diagnosis_page(diagnosis: Diagnosis, drawings: Sequence[Drawing]) -> str:
    """Return the page with ``drawings`` inside."""
    provenance = diagnosis.provenance

    def drawn(section: str) -> tuple[Drawing, ...]:
        return tuple(drawing for drawing in drawings if drawing.section == section)

    unnamed = Section(
        "Unnamed laws in the revised model",
        items=text.law_lines(diagnosis),
        drawings=drawn("unnamed"),
    )
    gap = Section(
        "The gap before and after" if diagnosis.effects else "The gap",
        (text.gap_line(diagnosis),),
        drawings=drawn("gap"),
        facts=_gap_facts(diagnosis),
        parts=(
            *_numbers("Gaps of held-out runs in numbers", *_held_out_tables(diagnosis)),
            *_run_part(diagnosis),
            *_numbers("Gaps of the runs that the model was fitted to", *_train_tables(diagnosis)),
        ),
    )
    where = Section(
        "Deviations that remain" if diagnosis.verdict == "none" else "Where the model disagrees",
        drawings=drawn("where"),
        tables=_with_rows(
            text.where_table(diagnosis), text.rest_table(diagnosis), text.edges_table(diagnosis)
        ),
        facts=_WHERE,
    )
    overlay = Section("Held-out runs, measured and simulated", drawings=drawn("overlay"))
    which = Section(
        "Which effect",
        () if diagnosis.verdict == "unknown" else (_sentence(_in_words(diagnosis.why)),),
        drawings=drawn("ranking"),
        facts=_WHICH,
        parts=(
            *_numbers("All candidates in numbers", _untitled(text.ranking_table(diagnosis))),
            *_matrix_part(diagnosis),
        ),
    )
    refitted = Section(
        "Refitted values",
        (_refitted_words(diagnosis),),
        drawings=drawn("refitted"),
        parts=_numbers("Refitted values in numbers", _refitted_table(diagnosis)),
    )
    effects = Section(
        "The effects" if diagnosis.effects else "The candidates that remain",
        (_SENSOR,) if any(effect.of_sensor for effect in diagnosis.effects) else (),
        tables=_with_rows(
            text.effects_table(diagnosis),
            text.alternatives_table(diagnosis),
            candidates_table(diagnosis),
            *changes_tables(diagnosis),
            *lookalikes_tables(diagnosis),
        ),
        facts=(*_laws(diagnosis), *_change_facts(diagnosis)),
    )
    missing = Section(
        "Missing data and runs left out", items=diagnosis.notes, facts=_caveats(diagnosis)
    )
    shape = _shape(diagnosis, drawn("shape"))
    if diagnosis.verdict == "unknown":
        evidence = (shape, where, gap, overlay, effects)
    else:
        evidence = (gap, overlay, effects, where, shape)
    sections = (unnamed, *evidence, which, refitted)
    return document(
        f"Model {diagnosis.model} against campaign {provenance.name}",
        f"{provenance.source.capitalize()}, {provenance.started[:10]}; bench {provenance.bench}.",
        (
            _answer(diagnosis),
            *(section for section in sections if _holds_something(section)),
            *([missing] if missing.items or missing.facts else []),
        ),
        _verdict(diagnosis),
        provenance.source,
    )


def _verdict(diagnosis: Diagnosis) -> str:
    """Return the terminal's headline as sentences."""
    _, _, finding = text.verdict_sentence(diagnosis).partition(": ")
    finding, step = _in_words(finding), f" {next_step(diagnosis)}".rstrip()
    if diagnosis.verdict == "named":
        effects = "effect is" if len(diagnosis.effects) == 1 else "effects are"
        no_gain = [
            f" {title(effect.name)}: {gap_change(effect)}"
            for effect in diagnosis.effects
            if effect.gap_after >= effect.gap_before
        ]
        found = f"{finding} All intervals: 95 %.{''.join(no_gain)}"
        return f"The missing {effects} identified: {found}{step}"
    if diagnosis.verdict == "ambiguous":
        return f"One of these effects is missing in the model: {finding}{step}"
    if diagnosis.verdict == "none":
        more = "Those of next.yaml would show more." if diagnosis.next_schedule else ""
        remarks = (undetectable(diagnosis), more)
        found = " ".join((f"{finding}{_largest(diagnosis.where)}", *filter(None, remarks)))
        return f"No missing effect is found: {found}"
    if not diagnosis.where:
        missing = f" Missing: {diagnosis.missing[0]}." if diagnosis.missing else ""
        return f"These runs do not suffice to find a missing effect.{missing}"
    gaps = diagnosis.rest or diagnosis.where[:1]
    return (
        "No known effect explains how the measurement deviates from the model: "
        f"{deviations(gaps)}.{step}"
    )


def _largest(gaps: Sequence[Gap]) -> str:
    """State the deviation that exceeds its limit most, and why it is no missing effect."""
    largest = largest_deviation(gaps)
    if largest is None:
        return ""
    why = f"is not significant ({p_equation(largest.p_value)})"
    if largest.deviation <= largest.material:
        why = "does not matter"
    elif largest.p_value < SIGNIFICANCE:
        why = f"is {number(largest.gap, 1)} trial scatters, too few for a missing effect"
    deviation, limit = deviation_and_limit(largest)
    return (
        f" The largest deviation that remains, {in_sentence(largest.name)} by {deviation} RMS "
        f"(limit {limit}), {why}."
    )


def _answer(diagnosis: Diagnosis) -> Section:
    """Return the first section: the engineer's answers, and the files beside the page."""
    known = tuple((question, _in_words(words)) for question, words in answers(diagnosis))
    if diagnosis.refit_refused:
        added = "effects" if diagnosis.effects else "unnamed laws" if diagnosis.unnamed else ""
        fitted = _FITTED_WITH.format(added=added) if added and diagnosis.refitted else ""
        known += (("Refit", f"{diagnosis.refit_refused} {_REFUSED.format(fitted=fitted)}"),)
    return Section(facts=(*known, ("Files beside this page", _files(diagnosis))))


def _files(diagnosis: Diagnosis) -> str:
    """Return which files are beside the page, and what they are for."""
    contents = [
        *(["the effects"] if diagnosis.effects else []),
        *(["unnamed laws"] if diagnosis.unnamed else []),
    ]
    if diagnosis.refitted and diagnosis.refit_refused:
        contents.append("values fitted with them")
    elif diagnosis.refitted:
        contents.insert(0, "refitted values")
    model = f"the model with {listed(contents)}" if contents else "the model as given"
    files = [_NEXT_FILE] if diagnosis.next_schedule else []
    files.append(f"model.yaml is {model}, for hbench run --plant.")
    files.append(_NUMBERS if diagnosis.gap_runs else "diagnosis.json is this result as data.")
    return " ".join(files)


def _gap_facts(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    held_out = ("Held-out runs", f"Not used for the fit: {', '.join(diagnosis.heldout_runs)}.")
    signals = (("Signals", _SIGNALS),) if diagnosis.gap_heldout.signals else ()
    refitted = () if diagnosis.refit_refused else (("Refitted", _REFITTED_STAGE),)
    stages = *refitted, ("Expected", _EXPECTED)
    return (("Gap", _GAP), ("Balances", _BALANCES), *signals, *stages, held_out)


def _shape(diagnosis: Diagnosis, drawings: tuple[Drawing, ...]) -> Section:
    """Return the residuals of each balance: all where they are the answer, else the worst."""
    if diagnosis.verdict == "unknown":
        return Section("Shape of the residuals", drawings=drawings)
    others = Section("Residuals of the other balances", drawings=drawings[1:], folded=True)
    parts = (replace(others, printed=False),) if others.drawings else ()
    return Section("Residuals of the worst balance", drawings=drawings[:1], parts=parts)


def _held_out_tables(diagnosis: Diagnosis) -> tuple[WordTable, ...]:
    return text.gap_tables(diagnosis, diagnosis.gap_heldout, "held-out runs")


def _train_tables(diagnosis: Diagnosis) -> tuple[WordTable, ...]:
    return text.gap_tables(diagnosis, diagnosis.gap_train, "training runs")


def _refitted_table(diagnosis: Diagnosis) -> WordTable:
    table = _untitled(text.refitted_table(diagnosis))
    return replace(table, rows=tuple((value_words(path), words) for path, words in table.rows))


def _refitted_words(diagnosis: Diagnosis) -> str:
    """Return what was fitted, and when."""
    if not diagnosis.refit_refused:
        return _REFITTED
    added = "effects" if diagnosis.effects else "unnamed laws"
    return (
        f"{_POORLY_KNOWN}. Fitted first, they made held-out runs worse; these are fitted together "
        f"with the {added}."
    )


def _laws(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Return the law of each effect that was added, by whose symbols its coefficients are meant."""
    return tuple(
        (f"Law of {in_words(effect.name)}", f"{effect.law.replace(' - ', ' − ')}.")
        for effect in diagnosis.effects
        if effect.law
    )


def _change_facts(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Return how the tables of changes are to be read; empty without any."""
    computed = (_COMPUTED,) if any(map(wrong_readings, diagnosis.practice)) else ()
    return (*_CHANGES, *computed) if diagnosis.practice else ()


def _caveats(diagnosis: Diagnosis) -> tuple[tuple[str, str], ...]:
    """Return missing data, effects that were not tried and runs left out."""
    untried = [
        _sentence(f"{_in_words(', '.join(names)) if diagnosis.ranking else 'all'} ({reason}).")
        for reason, names in text.by_reason(diagnosis.not_tried).items()
    ]
    parts = {
        "Missing data": [f"{_sentence(item)}." for item in diagnosis.missing if diagnosis.where],
        "Effects not tried": untried,
        "Runs left out": [f"{_sentence(line)}." for line in diagnosis.left_out],
    }
    return tuple((name, " ".join(lines)) for name, lines in parts.items() if lines)


def _numbers(title: str, *tables: WordTable) -> tuple[Section, ...]:
    """Return a folded part of tables, whose numbers the files beside the page contain too."""
    known = _with_rows(*tables)
    return (Section(title, tables=known, folded=True, printed=False),) if known else ()


def _run_part(diagnosis: Diagnosis) -> tuple[Section, ...]:
    table = run_table(diagnosis, _MOST_RUNS)
    parts = _numbers(table.title, _untitled(table))
    return tuple(replace(part, paragraphs=(_RUNS,)) for part in parts)


def _matrix_part(diagnosis: Diagnosis) -> tuple[Section, ...]:
    table = matrix_table(diagnosis)
    parts = _numbers(table.title, _untitled(table))
    return tuple(replace(part, paragraphs=(MATRIX_TEXT,)) for part in parts)


def _untitled(table: WordTable) -> WordTable:
    return replace(table, title="")


def _with_rows(*tables: WordTable) -> tuple[WordTable, ...]:
    """Return the tables that have rows, with effects' names in words."""
    return tuple(
        WordTable(
            _in_words(table.title),
            tuple(name if name.startswith("p ") else _head(name) for name in table.head),
            tuple(tuple(map(_in_words, row)) for row in table.rows),
        )
        for table in tables
        if table.rows
    )


def _head(name: str) -> str:
    """Return the head of a column, which begins with a capital letter."""
    return _sentence(_in_words(name))


def _in_words(line: str) -> str:
    """Return a text with effects, balances and channels in words or symbols, not in keys."""
    names = {key: name.title for key, name in (*SIGNAL_NAMES.items(), *BALANCE_NAMES.items())}
    return _KEY.sub(lambda key: names.get(key[0]) or in_words(key[0]), line)


def _sentence(line: str) -> str:
    line = line.strip()
    return f"{line[:1].upper()}{line[1:]}"


def _holds_something(section: Section) -> bool:
    return bool(section.items or section.drawings or section.tables or section.parts)
